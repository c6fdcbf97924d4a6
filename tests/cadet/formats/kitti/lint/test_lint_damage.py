"""Whatever a folder holds, the lint answers with findings: it never ends before the last frame."""

from __future__ import annotations

import json
import os
import shutil
from pathlib import Path

import pytest

from cadet.formats.kitti import ImageSet, lint, write_frame, write_image_set
from synthetic import make_frame

DEEP = "[" * 100_000
KINDS = {"image_2": ".png", "velodyne": ".bin", "calib": ".txt", "label_2": ".txt", "planes": ".txt", "meta": ".json"}


@pytest.fixture
def root(tmp_path: Path) -> Path:
    """Three frames, the last without objects: its one finding shows that the lint got there."""
    for frame_id in range(2):
        write_frame(tmp_path, frame_id, make_frame(seed=frame_id), split=None)
    write_frame(tmp_path, 2, make_frame(labels=(), seed=2), split=None)
    return tmp_path


LAST = "label_2/000002.txt: error: no line: OpenPCDet cannot read an empty label file"


def found(root: Path, *, strict: bool = True) -> list[str]:
    """Return the findings before the last frame's."""
    *findings, last = (str(finding) for finding in lint(root, strict=strict))
    assert last == (LAST if strict else LAST.replace("error", "warning"))
    return findings


def test_only_the_last_frame_has_a_finding(root: Path) -> None:
    assert found(root) == found(root, strict=False) == []


@pytest.mark.parametrize("field", range(8, 15))
@pytest.mark.parametrize("value", ["1e30", "-1e30", "1e308", "1e-308", "-0.0"])
@pytest.mark.parametrize("strict", [True, False])
def test_any_number_in_a_label_is_answered(root: Path, field: int, value: str, strict: bool) -> None:
    path = root / "training" / "label_2" / "000000.txt"
    lines = [line.split(" ") for line in path.read_text().splitlines()]
    lines[0][field] = value
    path.write_text("".join(f"{' '.join(line)}\n" for line in lines))
    findings = found(root, strict=strict)
    assert all(finding.startswith("label_2/000000.txt:1: ") for finding in findings)
    assert findings or (abs(float(value)) < 1 and (field > 10 or not strict))


def test_a_place_beyond_every_scene_is_named(root: Path) -> None:
    path = root / "training" / "label_2" / "000000.txt"
    path.write_text(path.read_text().replace("14.00 1.50", "1e30 1.50", 1))
    assert found(root) == ["label_2/000000.txt:1: error: location (-2.0, 1.65, 1e+30), expected less than 1000 m"]


@pytest.mark.parametrize("key", ["P2", "R0_rect", "Tr_velo_to_cam", "Tr_imu_to_velo"])
@pytest.mark.parametrize("value", ["1e308", "-1e308", "1e-308", "0"])
def test_any_number_in_a_calibration_is_answered(root: Path, key: str, value: str) -> None:
    path = root / "training" / "calib" / "000000.txt"
    lines = path.read_text().splitlines()
    for index, line in enumerate(lines):
        if line.startswith(f"{key}:"):
            lines[index] = " ".join([f"{key}:", *[value] * (len(line.split(" ")) - 1)])
    path.write_text("\n".join(lines) + "\n")
    findings = found(root)
    place = "calib/000000.txt:7: error: " if (key, value) == ("Tr_imu_to_velo", "0") else "calib/000000.txt: error: "
    assert findings and (key == "P2" or findings[0].startswith(place))


@pytest.mark.parametrize("value", [5, 2.5, True, "1242", [1242], [1242, 375, 3], [None, 1], [10**19, 1], {"a": 1}])
def test_an_image_size_of_any_type_is_answered(root: Path, value: object) -> None:
    (root / "training" / "meta" / "000001.json").write_text(json.dumps({"image_size": value}))
    (finding,) = found(root)
    assert finding.startswith(
        ("meta/000001.json: error: image_size: expected two numbers", "image_2/000001.png: error:")
    )


@pytest.mark.parametrize(
    ("objects", "message"),
    [
        (5, "objects: expected a list of JSON objects"),
        ([{}, {}, {}, 7], "objects: expected a list of JSON objects"),
        ([{}], "1 objects, label_2 has 4 lines"),
        ([{"type": "Van"}, {}, {}, {}], "object 1 is Van, label_2 says Car on line 1"),
        ([{"type": [1]}, {}, {}, {}], "object 1 is no type, label_2 says Car on line 1"),
        (
            [{}, {"location_cam": [-2.0, 1.65, 14.0]}, {}, {}],
            "object 2 lies elsewhere than line 2 of label_2: (5.6, 1.65, 7.5)",
        ),
        (
            [{"location_cam": [10**19, 0, "x"]}, {}, {}, {}],
            "object 1 lies elsewhere than line 1 of label_2: (-2.0, 1.65, 14.0)",
        ),
    ],
)
def test_objects_that_are_not_the_labels_are_found(root: Path, objects: object, message: str) -> None:
    (root / "training" / "meta" / "000001.json").write_text(json.dumps({"objects": objects}))
    assert found(root) == [f"meta/000001.json: error: {message}"]


def test_objects_in_the_labels_order_pass(root: Path) -> None:
    labels = make_frame().labels
    objects = [{"type": label.type, "location_cam": label.location_cam} for label in labels[:3]]
    # A DontCare region's entry says what it really is.
    objects.append({"type": "Truck", "location_cam": (1.0, 1.7, 70.0)})
    (root / "training" / "meta" / "000001.json").write_text(json.dumps({"objects": objects}))
    assert found(root) == []


@pytest.mark.parametrize("text", [DEEP, '{"a":' * 100_000, "{", "", "\xff", "[NaN]"])
def test_json_of_any_kind_is_answered(root: Path, text: str) -> None:
    (root / "training" / "meta" / "000000.json").write_text(text, encoding="latin-1")
    (finding,) = found(root)
    assert finding.startswith("meta/000000.json")


@pytest.mark.parametrize(
    "text",
    [DEEP, '{"a":' * 100_000, "{", "\xff", '{"rig": {"range_m": 5}}', '{"rig": {"range_m": [1, "x"]}}']
    + [f'{{"rig": {{"range_m": {range_m}}}}}' for range_m in ("[80, 1]", "[NaN, 80]", "[1, 1e999]", f"[1, {10**400}]")],
)
def test_a_damaged_manifest_is_a_finding(root: Path, text: str) -> None:
    (root / "manifest.json").write_text(text, encoding="latin-1")
    findings = [finding for finding in found(root) if not finding.startswith("ImageSets/")]
    assert len(findings) == 1
    assert findings[0].startswith("manifest.json")


@pytest.mark.parametrize("kind", KINDS)
def test_a_folder_in_a_files_place_is_a_finding(root: Path, kind: str) -> None:
    path = root / "training" / kind / f"000001{KINDS[kind]}"
    path.unlink()
    path.mkdir()
    assert found(root) == [f"{kind}/000001{KINDS[kind]}: error: not a regular file"]


@pytest.mark.parametrize("kind", KINDS)
def test_a_pipe_in_a_files_place_is_a_finding(root: Path, kind: str) -> None:
    path = root / "training" / kind / f"000001{KINDS[kind]}"
    path.unlink()
    os.mkfifo(path)
    assert found(root) == [f"{kind}/000001{KINDS[kind]}: error: not a regular file"]


@pytest.mark.parametrize("kind", KINDS)
def test_a_file_that_may_not_be_read_is_a_finding(root: Path, kind: str, monkeypatch: pytest.MonkeyPatch) -> None:
    """As another user's file; whoever runs the tests may be allowed to read everything."""
    closed = root / "training" / kind / f"000001{KINDS[kind]}"
    read_bytes = Path.read_bytes

    def refuse(path: Path) -> bytes:
        if path == closed:
            raise PermissionError(13, "Permission denied", str(path))
        return read_bytes(path)

    monkeypatch.setattr(Path, "read_bytes", refuse)
    assert found(root) == [f"{kind}/000001{KINDS[kind]}: error: cannot be read: Permission denied"]


def test_a_file_in_a_folders_place_is_a_finding(root: Path) -> None:
    shutil.rmtree(root / "training" / "planes")
    (root / "training" / "planes").write_text("")
    assert "planes: error: cannot be read: Not a directory" in found(root)


def test_a_broken_link_is_missing(root: Path) -> None:
    path = root / "training" / "planes" / "000001.txt"
    path.unlink()
    path.symlink_to("nowhere")
    assert found(root) == ["planes/000001.txt: error: missing"]


def test_a_list_that_cannot_be_read_is_a_finding(root: Path) -> None:
    write_image_set(root, "val", ImageSet(("000001",)))
    (root / "ImageSets" / "train.txt").mkdir()
    assert found(root) == ["ImageSets/train.txt: error: expected a regular file, got a folder"]


def test_names_that_cannot_be_printed_are_escaped(root: Path) -> None:
    for name in ("\udcff.txt", "two\nlines.txt"):
        (root / "training" / "planes" / name).write_text("")
    assert found(root) == [
        r"planes/two\nlines.txt: warning: belongs to no frame",
        r"planes/\udcff.txt: warning: belongs to no frame",
    ]
