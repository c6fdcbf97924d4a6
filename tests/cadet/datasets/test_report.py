"""`cadet report`: its numbers, its figures, and the page, read by parsers."""

from __future__ import annotations

import base64
import json
import re
import shutil
import subprocess
import sys
import tarfile
from html.parser import HTMLParser
from pathlib import Path
from typing import Any
from xml.etree import ElementTree

import cv2
import numpy as np
import pytest

from cadet import kitti
from cadet.cli import run_cadet
from cadet.datasets.report import write_report
from cadet.datasets.report.charts import distance, histogram
from cadet.datasets.report.gather import gather
from cadet.datasets.report.quantities import CLASSES, LABEL_QUANTITIES, POINTS, QUANTITIES
from cadet.datasets.report.statistics import Statistics, kitti_statistics
from cadet.errors import CadetError, FileFormatError, MissingFileError
from cadet.formats.kitti import boxes
from real_kitti import ROOT as KITTI
from synthetic import make_calib, make_frame, make_labels

VOID = {"meta", "input", "br", "rect", "path", "image"}
CHROMIUM = shutil.which("chromium") or shutil.which("chromium-browser") or shutil.which("google-chrome")


class Page(HTMLParser):
    """The elements of a page; tags that are not closed in turn are an error."""

    def __init__(self, path: Path) -> None:
        super().__init__()
        self.elements: list[tuple[str, dict[str, str | None]]] = []
        self.texts: dict[str, str] = {}
        self._open: list[str] = []
        self.feed(path.read_text(encoding="utf-8"))
        self.close()
        assert self._open == []

    def handle_starttag(self, tag: str, attrs: list[tuple[str, str | None]]) -> None:
        self.elements.append((tag, dict(attrs)))
        if tag not in VOID:
            self._open.append(tag)

    def handle_startendtag(self, tag: str, attrs: list[tuple[str, str | None]]) -> None:
        self.elements.append((tag, dict(attrs)))

    def handle_endtag(self, tag: str) -> None:
        assert tag in VOID or self._open.pop() == tag, f"</{tag}> closes nothing at {self.getpos()}"

    def handle_data(self, data: str) -> None:
        tag, attributes = self.elements[-1] if self.elements else ("", {})
        key = attributes.get("id") or tag
        self.texts[key] = self.texts.get(key, "") + data

    def all(self, tag: str, **wanted: str) -> list[dict[str, str | None]]:
        return [
            attributes
            for name, attributes in self.elements
            if name == tag and all(attributes.get(key.rstrip("_")) == value for key, value in wanted.items())
        ]


@pytest.fixture(scope="module")
def dataset(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """Twelve frames: the weather changes, and every fourth has no objects."""
    root = tmp_path_factory.mktemp("report") / "my set"
    for number in range(12):
        labels = make_labels(make_calib())
        meta = {"episode": number // 4, "weather": "snow" if number < 3 else "clear_noon", "district": "quiet"}
        frame = make_frame(seed=number, labels=labels[3:] if number % 4 == 3 else labels, meta=meta)
        kitti.write_frame(root, number, frame, split="train" if number < 8 else "val")
    policy = {"name": "kitti", "weathers": {"snow": 1, "clear_noon": 2, "dusk": 1}}
    (root / "manifest.json").write_text(json.dumps({"seed": 7, "policy": policy}))
    return root


@pytest.fixture(scope="module")
def page(dataset: Path) -> Path:
    return write_report(dataset, dataset.parent / "report.html", num_frames=10)


def test_kittis_numbers_are_those_that_are_known() -> None:
    known = kitti_statistics()
    assert known.num_frames == 7481
    # As counted in the literature, for instance in the statistics of OpenPCDet's data base.
    assert (known.labels["Car"], known.labels["Pedestrian"], known.labels["Cyclist"]) == (28742, 4487, 1627)
    for name in CLASSES:
        for quantity in LABEL_QUANTITIES:
            assert known.counts(quantity.name, name).sum() == known.labels[name]
        assert known.counts("objects", name).sum() == 7481
        assert known.counts("objects", name)[1:].sum() == known.num_frames_with[name]


@pytest.mark.skipif(not KITTI.is_dir(), reason="needs KITTI's label files in ../shared/kitti")
def test_kittis_numbers_follow_from_its_labels() -> None:
    """Count three of them anew, with other code."""
    rows: list[list[str]] = []
    with tarfile.open(KITTI / "labels_7481.tar.xz") as tar:
        for member in tar:
            file = tar.extractfile(member)
            if file is not None and member.name.startswith("label_2/"):
                rows += [line.split(" ") for line in file.read().decode().splitlines()]
    known = kitti_statistics()
    for name in ("Car", "Pedestrian", "Tram"):
        numbers = np.array([row[1:15] for row in rows if row[0] == name], float)
        occluded = [int((numbers[:, 1] == level).sum()) for level in range(4)]
        assert known.counts("occluded", name).tolist() == occluded
        far = int((np.hypot(numbers[:, 10], numbers[:, 12]) >= 30.0).sum())
        assert known.counts("distance", name)[10:].sum() == far
        assert known.counts("height", name)[18:].sum() == (numbers[:, 7] >= 1.8).sum()


def test_a_datasets_numbers(dataset: Path) -> None:
    facts = gather(dataset)
    own = facts.statistics
    assert (own.num_frames, facts.num_episodes, facts.splits) == (12, 3, {"train": 8, "val": 4})
    assert dict(own.labels) == {"Car": 18, "Pedestrian": 9, "DontCare": 12}
    assert dict(own.num_frames_with) == {"Car": 9, "Pedestrian": 9}
    assert own.counts("objects", "Car").tolist()[:4] == [3, 0, 9, 0]
    assert dict(facts.recorded["weather"]) == {"snow": 3, "clear_noon": 9}
    assert facts.expected == {"weather": {"snow": 0.25, "clear_noon": 0.5, "dusk": 0.25}}
    # The pedestrian stands 21.1 m away, 1.8 m tall, and 200 points were laid into its box.
    assert own.counts("distance", "Pedestrian").nonzero()[0].tolist() == [7]
    assert own.counts("height", "Pedestrian").nonzero()[0].tolist() == [18]
    few, many = own.counts(POINTS.name, "Pedestrian")[:7].sum(), own.counts(POINTS.name, "Pedestrian")[7:].sum()
    assert (few, many) == (0, 9)


def test_frames_without_labels_are_counted_apart(dataset: Path, tmp_path: Path) -> None:
    """KITTI's own test frames have none."""
    shutil.copytree(dataset, tmp_path / "set")
    for kind in ("image_2", "velodyne", "calib"):
        shutil.copytree(dataset / "training" / kind, tmp_path / "set" / "testing" / kind)
    facts = gather(tmp_path / "set")
    assert (facts.statistics.num_frames, facts.num_unlabeled) == (12, 12)
    num_points = [len(frame.points_velo) for frame in kitti.Dataset(dataset)]
    assert facts.num_points == sum(num_points)


def test_statistics_come_back_from_their_text(dataset: Path) -> None:
    own = gather(dataset).statistics
    again = Statistics.from_text(own.to_text(), "x")
    assert (again.num_frames, again.labels, again.num_frames_with) == (own.num_frames, own.labels, own.num_frames_with)
    for quantity in QUANTITIES:
        for name in CLASSES:
            np.testing.assert_array_equal(again.counts(quantity, name), own.counts(quantity, name))
    with pytest.raises(FileFormatError, match=r"^x: invalid statistics"):
        Statistics.from_text(
            '{"num_frames": 1, "labels": {}, "num_frames_with": {}, "histograms": {"points": {"Car": [1]}}}', "x"
        )


def test_the_distance_of_histograms() -> None:
    one, other = np.array([3, 1, 0, 0]), np.array([0, 0, 2, 5])
    assert distance(one, 7 * one) == pytest.approx(0.0, abs=1e-9)
    assert distance(one, other) == pytest.approx(1.0)
    # By hand: p = (1, 0), q = (1/2, 1/2), m = (3/4, 1/4).
    half = 0.5 * np.log2(4 / 3) + 0.5 * (0.5 * np.log2(2 / 3) + 0.5 * np.log2(2))
    assert distance(np.array([4, 0]), np.array([1, 1])) == pytest.approx(np.sqrt(half))
    assert distance(one, np.zeros(4, np.int64)) is None


def test_bars_are_as_high_as_their_shares() -> None:
    quantity = QUANTITIES["occluded"]
    svg = ElementTree.fromstring(histogram(quantity, np.array([30, 10, 0, 0]), np.array([1, 1, 2, 0])))
    heights = [float(bar.get("height", "nan")) for bar in svg.findall("rect")]
    assert heights[0] == pytest.approx(3 * heights[1], abs=0.2)
    grid = [path.get("d", "") for path in svg.findall("path") if path.get("class") == "grid"]
    zero, _, full = (float(d.partition(" ")[2].partition("H")[0]) for d in grid)
    top = float((svg.findall("text")[2].text or "").removesuffix(" %"))
    assert heights[0] == pytest.approx((zero - full) * 75 / top, abs=0.2)
    line = next(path.get("d", "") for path in svg.findall("path") if path.get("class") == "kitti")
    levels = [float(y) for _, y in re.findall(r"[ML]([\d.]+) ([\d.]+)", line)]
    bottom = levels[-1]
    # KITTI's first bin has 25 %, ours 75 %; its third has 50 %.
    assert bottom - levels[0] == pytest.approx(heights[0] / 3, abs=0.2)
    assert bottom - levels[4] == pytest.approx(2 * (bottom - levels[0]), abs=0.2)
    assert [text.text for text in svg.findall("text")][-4:] == list(quantity.names)


@pytest.mark.parametrize("name", QUANTITIES)
def test_a_histogram_of_nothing_is_drawn(name: str) -> None:
    none = np.zeros(QUANTITIES[name].num_bins, np.int64)
    ElementTree.fromstring(histogram(QUANTITIES[name], none, none))


def test_the_page_stands_alone(page: Path) -> None:
    parsed = Page(page)
    ids = [attributes["id"] for _, attributes in parsed.elements if "id" in attributes]
    assert len(ids) == len(set(ids))
    links = [value for _, attributes in parsed.elements for key, value in attributes.items() if key in ("src", "href")]
    assert all(link is not None and link.startswith(("#", "data:image/jpeg;base64,")) for link in links)
    assert {link[1:] for link in links if link is not None and link[0] == "#"} <= set(ids)
    (policy,) = [one["content"] or "" for one in parsed.all("meta") if "http-equiv" in one]
    assert policy.startswith("default-src 'none'")
    text = page.read_text()
    assert not re.search(r"url\(|@import|https?:", text)
    assert "prefers-color-scheme: dark" in text
    assert parsed.all("meta", name="viewport")
    assert page.stat().st_size < 5_000_000


def test_the_page_has_every_figure_and_frame(page: Path) -> None:
    parsed = Page(page)
    figures = [one for one in parsed.all("svg") if one.get("class") is None]
    assert len(figures) == len(CLASSES) * len(QUANTITIES)
    assert len(parsed.all("figure")) == 10
    assert {one["name"] for one in parsed.all("input", type="checkbox")} == {"box3d", "box2d", "dontcare"}
    text = page.read_text()
    assert "13,989" in text and "4,895" in text
    assert re.search(r"<th>.*?Car</th><td>18</td><td[^>]*>9</td><td>15,000</td><td>38,420</td><td>13,989</td>", text)
    assert "1.07 times as many cars" in text
    assert 'title="dusk"' in text


def test_a_frame_of_the_gallery_is_the_datasets(page: Path, dataset: Path) -> None:
    frame = kitti.read_frame(dataset, "000001")
    parsed = Page(page)
    images = [one["href"] or "" for one in parsed.all("image")]
    data = np.frombuffer(base64.b64decode(images[1].partition(",")[2]), np.uint8)
    decoded = cv2.imdecode(data, cv2.IMREAD_COLOR)
    assert decoded is not None
    image = cv2.cvtColor(decoded, cv2.COLOR_BGR2RGB)
    assert image.shape == frame.image.shape
    # JPEG keeps no noise, but it keeps the mean of blocks.
    assert np.abs(image.astype(float).mean(axis=(0, 1)) - frame.image.mean(axis=(0, 1))).max() < 2.0

    cloud = json.loads(parsed.texts["cloud-000001"])
    raw = base64.b64decode(cloud["points"])
    count = len(raw) // 7
    points = np.frombuffer(raw[: 6 * count], "<i2").reshape(-1, 3) / cloud["steps"]
    near = frame.points_velo[np.abs(frame.points_velo[:, :2]).max(axis=1) <= 60.0]
    assert count == len(near)
    np.testing.assert_allclose(points, near[:, :3], atol=0.5 / cloud["steps"] + 1e-6)
    objects = [label for label in frame.labels if not label.is_dont_care]
    corners = frame.calib.points_velo_from_cam(boxes.corners_cam(kitti.boxes_cam_from_labels(objects)).reshape(-1, 3))
    np.testing.assert_allclose(np.concatenate([box["corners"] for box in cloud["boxes"]]), corners, atol=0.0051)


def test_boxes_are_drawn_where_they_are_projected(page: Path, dataset: Path) -> None:
    frame = kitti.read_frame(dataset, "000000")
    svg = re.search(r'<svg class="frame".*?</svg>', page.read_text(), re.DOTALL)
    assert svg is not None
    tree = ElementTree.fromstring(svg[0])
    paths = tree.findall(".//g[@class='box3d']/path")
    # From far to near.
    far = max((label for label in frame.labels if not label.is_dont_care), key=lambda label: label.location_cam[2])
    drawn = np.array(re.findall(r"[ML]([-\d.]+) ([-\d.]+)", paths[0].get("d", "")), float)
    corners = frame.calib.project(boxes.corners_cam(far.box_cam[None])[0])
    assert np.linalg.norm(drawn[:, None] - corners[None], axis=2).min(axis=0).max() < 0.1
    rectangles = tree.findall(".//g[@class='box2d']/rect")
    left, top, right, bottom = far.bbox
    shown = [float(rectangles[0].get(key, "nan")) for key in ("x", "y", "width", "height")]
    assert shown == pytest.approx([left, top, right - left, bottom - top], abs=0.051)
    assert len(tree.findall(".//g[@class='dontcare']/rect")) == 1


def test_the_same_dataset_gives_the_same_page(dataset: Path, page: Path, tmp_path: Path) -> None:
    again = write_report(dataset, tmp_path / "again.html", num_frames=10, workers=2)
    assert again.read_bytes() == page.read_bytes()


def test_names_are_text_and_no_code(tmp_path: Path) -> None:
    root = tmp_path / "<script>alert(1)<&"
    meta = {"weather": "</div><script>", "district": '"quiet"'}
    kitti.write_frame(root, 0, make_frame(meta=meta))
    page = write_report(root, tmp_path / "page.html")
    assert len(Page(page).all("script")) == 2, "the page's own, and the frame's scan"


def test_frames_without_labels_scan_or_record(tmp_path: Path) -> None:
    for number in range(2):
        kitti.write_frame(tmp_path, number, make_frame(seed=number, labels=(), meta=None), split=None)
    page = Page(write_report(tmp_path, tmp_path / "page.html", num_frames=1))
    assert len(page.all("figure")) == 1
    assert "No frame has a record" in (tmp_path / "page.html").read_text()


def test_what_cannot_be_reported_is_one_line(dataset: Path, tmp_path: Path) -> None:
    with pytest.raises(CadetError, match=r"ends in \.html"):
        write_report(dataset, tmp_path / "report.pdf")
    with pytest.raises(MissingFileError, match="no such folder"):
        write_report(dataset, tmp_path / "nowhere" / "report.html")
    with pytest.raises(MissingFileError, match="no KITTI folder"):
        write_report(tmp_path, tmp_path / "report.html")
    with pytest.raises(CadetError, match="num_frames"):
        write_report(dataset, tmp_path / "report.html", num_frames=-1)
    (tmp_path / "calib").mkdir()
    with pytest.raises(MissingFileError, match="no label files"):
        write_report(tmp_path, tmp_path / "report.html")
    shutil.copytree(dataset, tmp_path / "damaged")
    for number in range(7):
        (tmp_path / "damaged" / "training" / "label_2" / f"{number:06d}.txt").write_text("Car 0.0\n")
    with pytest.raises(
        CadetError, match=r"7 of 12 frames cannot be read \(000000: label_2/000000\.txt:1: .*more than half"
    ):
        write_report(tmp_path / "damaged", tmp_path / "report.html")
    assert not (tmp_path / "report.html").exists()


def test_the_command(dataset: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: Any) -> None:
    out = tmp_path / "page.html"
    monkeypatch.setattr(
        sys, "argv", ["cadet", "report", str(dataset), "-o", str(out), "--frames", "2", "--workers", "1"]
    )
    with pytest.raises(SystemExit) as ended:
        run_cadet()
    assert ended.value.code == 0
    assert capsys.readouterr().out == f"wrote {out}\n"
    assert len(Page(out).all("figure")) == 2


@pytest.mark.skipif(CHROMIUM is None, reason="needs Chromium (apt-get install chromium)")
def test_the_script_draws_the_scan(page: Path, tmp_path: Path) -> None:
    """A canvas is 300 pixels wide until the script has made it as wide as it is shown."""
    command = [str(CHROMIUM), "--headless", "--no-sandbox", "--disable-gpu", f"--user-data-dir={tmp_path}"]
    command += ["--window-size=900,700", "--virtual-time-budget=3000", "--dump-dom", page.as_uri()]
    done = subprocess.run(command, capture_output=True, text=True, timeout=100, check=True)
    canvas = re.search(r'<canvas id="cloud"[^>]*width="(\d+)"', done.stdout)
    assert canvas is not None
    assert int(canvas[1]) > 800
