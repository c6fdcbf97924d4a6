"""BDD100K's labels as KITTI's: types, riders, marks of the unknown, and what is refused."""

from __future__ import annotations

import json
from pathlib import Path
from typing import Any

import cv2
import numpy as np
import pytest
from click.testing import CliRunner

from cadet import kitti
from cadet.cli.tools import cadet as command
from cadet.errors import CadetError, FileFormatError, MissingFileError
from cadet.formats.bdd100k import convert_bdd100k, labels_from_text
from cadet.formats.kitti import Label
from cadet.formats.kitti.files.images import decode_image
from image_bytes import PNG_START, header


def entry(category: str, *box: float, **attributes: object) -> dict[str, Any]:
    return {
        "id": 7,
        "category": category,
        "attributes": {"occluded": False, "truncated": False, "trafficLightColor": "none", **attributes},
        "box2d": dict(zip(("x1", "y1", "x2", "y2"), box, strict=True)),
    }


def read(*labels: dict[str, Any]) -> tuple[Label, ...]:
    (image,) = labels_from_text(json.dumps([{"name": "a.jpg", "labels": list(labels)}]), "det.json")
    return image.labels


def test_a_car_keeps_its_box_and_says_what_is_unknown() -> None:
    (label,) = read(entry("car", 10.5, 20.25, 110, 80))
    assert label.to_line() == "Car 0.00 0 -10 10.50 20.25 110.00 80.00 -1 -1 -1 -1000 -1000 -1000 -10"
    (label,) = read(entry("car", 0, 0, 9, 9, occluded=True, truncated=True))
    assert (label.occluded, label.truncated) == (3, 1.0)


@pytest.mark.parametrize(
    ("category", "name"),
    [("person", "Pedestrian"), ("pedestrian", "Pedestrian"), ("bus", "Truck"), ("train", "Tram"), ("trailer", "Misc")],
)
def test_both_releases_categories_become_types(category: str, name: str) -> None:
    assert [label.type for label in read(entry(category, 0, 0, 9, 9))] == [name]


@pytest.mark.parametrize("category", ["traffic light", "traffic sign", "lane", "drivable area"])
def test_what_is_no_object_is_left_out(category: str) -> None:
    shape = {"category": category, "poly2d": [[[0, 1], [2, 3]]]}
    assert read(entry(category, 0, 0, 9, 9), shape) == ()


def test_a_rider_and_the_bicycle_below_are_one_cyclist() -> None:
    rider, near, far = (
        entry("rider", 20, 10, 40, 60, occluded=True),
        entry("bike", 15, 40, 45, 80),
        entry("bike", 38, 40, 70, 80),
    )
    labels = read(far, entry("car", 100, 0, 150, 40), rider, near)
    assert [label.type for label in labels] == ["Car", "Cyclist", "DontCare"]
    assert labels[1].bbox == (15, 10, 45, 80)
    assert labels[1].occluded == 3
    assert labels[2].bbox == (38, 40, 70, 80)
    assert labels[2].occluded == labels[2].truncated == -1


def test_two_riders_do_not_share_a_motorcycle() -> None:
    labels = read(entry("rider", 0, 0, 20, 50), entry("rider", 2, 0, 22, 50), entry("motor", 0, 30, 20, 70))
    assert sorted(label.type for label in labels) == ["DontCare", "Misc"]


def test_a_rider_of_nothing_is_no_pedestrian() -> None:
    labels = read(entry("rider", 0, 0, 20, 50), entry("bicycle", 300, 0, 340, 50))
    assert [label.type for label in labels] == ["DontCare", "DontCare"]


def test_frames_without_labels_and_the_newer_layout() -> None:
    frames = [{"name": "b.jpg", "labels": None}, {"name": "a.jpg"}]
    assert labels_from_text(json.dumps({"frames": frames, "config": {}}), "det.json") == labels_from_text(
        json.dumps(frames), "det.json"
    )


@pytest.mark.parametrize(
    ("labels", "said"),
    [
        ({"version": 1}, "not labels of BDD100K: expected a list of frames"),
        ([{"name": "../a.jpg"}], "frame 0: name: expected an image's file name, got '../a.jpg'"),
        ([{"name": "a.jpg"}, {"name": "a.jpg"}], "a.jpg is listed twice"),
        ([{"name": "a.jpg", "labels": [{"category": "cow"}]}], "frame 0, label 0: unknown category 'cow'"),
        ([{"name": "a.jpg", "labels": [entry("car", 9, 0, 0, 9)]}], "x1 9 to x2 0, y1 0 to y2 9 is no box"),
        (
            [{"name": "a.jpg", "labels": [{"category": "car", "box2d": {"x1": 1}}]}],
            "expected the numbers x1, y1, x2, y2",
        ),
        ([{"name": "a.jpg", "labels": [{"category": "car", "box2d": [1, 2]}]}], "expected the numbers x1, y1, x2, y2"),
        ([{"name": "a.jpg", "labels": [entry("car", 0, 0, 1, 1, occluded=2)]}], "occluded: expected true or false"),
        ([{"name": "a.jpg", "labels": 3}], "labels: expected a list, got 3"),
    ],
)
def test_what_is_wrong_is_named(labels: Any, said: str) -> None:
    with pytest.raises(FileFormatError) as refused:
        labels_from_text(json.dumps(labels), "det.json")
    assert str(refused.value).startswith("det.json: ")
    assert said in str(refused.value)


@pytest.fixture
def source(tmp_path: Path) -> Path:
    (tmp_path / "images").mkdir()
    for number, name in enumerate(("b.jpg", "a.jpg")):
        image = np.full((72, 128, 3), 60 * number + 40, np.uint8)
        cv2.imwrite(str(tmp_path / "images" / name), image)
    frames = [{"name": "b.jpg", "labels": [entry("car", 1, 2, 30, 40)]}, {"name": "a.jpg"}]
    (tmp_path / "det.json").write_text(json.dumps(frames))
    return tmp_path


def test_the_command_writes_a_folder_that_reads_back(source: Path) -> None:
    arguments = [str(source / "det.json"), str(source / "out"), "--to", "kitti", "--images", str(source / "images")]
    done = CliRunner().invoke(command, ["convert", *arguments], catch_exceptions=False)
    assert done.exit_code == 0
    training = source / "out" / "training"
    assert [label.bbox for label in kitti.read_labels(source / "out", 0)] == [(1, 2, 30, 40)]
    assert kitti.read_labels(source / "out", 1) == ()
    for number, level in enumerate((40, 100)):
        image = decode_image((training / "image_2" / f"{number:06d}.png").read_bytes())
        assert image.shape == (72, 128, 3)
        assert np.abs(image.astype(int) - level).max() <= 1
    assert (source / "out" / "ImageSets" / "train.txt").read_text() == "000000\n000001\n"
    assert (source / "out" / "names.txt").read_text() == "000000 b.jpg\n000001 a.jpg\n"
    with pytest.raises(CadetError, match="is not an empty folder"):
        convert_bdd100k(source / "det.json", source / "images", source / "out")


@pytest.mark.parametrize(
    ("data", "message"),
    [
        (b"\xff\xd8 no image", r"a\.jpg: no PNG, JPEG or WebP image"),
        (PNG_START + header(32_768, 32_768), r"a\.jpg: 32768 x 32768 pixels, at most 67108864 are read"),
    ],
)
def test_an_image_that_is_none_is_named(source: Path, data: bytes, message: str) -> None:
    (source / "images" / "a.jpg").write_bytes(data)
    with pytest.raises(FileFormatError, match=message):
        convert_bdd100k(source / "det.json", source / "images", source / "out")


def test_images_and_options_that_lack_are_named(source: Path) -> None:
    (source / "images" / "a.jpg").unlink()
    with pytest.raises(MissingFileError, match=r"a\.jpg: no such image, which .*det\.json lists"):
        convert_bdd100k(source / "det.json", source / "images", source / "out")
    assert not (source / "out").exists()
    for arguments, said in (
        ([str(source / "det.json"), "out", "--to", "kitti"], "--to kitti --images DIR"),
        ([str(source), "out", "--to", "kitti", "--images", str(source)], "--images belongs to labels of BDD100K"),
    ):
        with pytest.raises(CadetError, match=said):
            CliRunner().invoke(command, ["convert", *arguments], catch_exceptions=False)
