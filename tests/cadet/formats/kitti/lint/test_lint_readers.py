"""What OpenPCDet's and MMDetection3D's readers rely on, and the lint finds."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from cadet.formats.kitti import Calibration, lint, write_frame
from synthetic import DONT_CARE, make_calib, make_frame


def findings(root: Path, *, strict: bool = True) -> list[str]:
    return [str(finding) for finding in lint(root, strict=strict)]


def test_a_dont_care_before_an_object_is_found(tmp_path: Path) -> None:
    car, other, pedestrian, region = make_frame().labels
    write_frame(tmp_path, 0, make_frame(labels=(car, region, other, DONT_CARE, pedestrian)), split=None)
    message = "after the DontCare of line 2: objects must come first, as in KITTI; OpenPCDet and MMDetection3D take"
    for strict, severity in ((True, "error"), (False, "warning")):
        assert findings(tmp_path, strict=strict) == [
            f"label_2/000000.txt:3: {severity}: Car {message} the DontCare for an object",
            f"label_2/000000.txt:5: {severity}: Pedestrian {message} the DontCare for an object",
        ]


def test_regions_alone_pass(tmp_path: Path) -> None:
    write_frame(tmp_path, 0, make_frame(labels=(DONT_CARE, DONT_CARE)), split=None)
    assert findings(tmp_path) == []


@pytest.mark.parametrize(
    ("old", "new", "message"),
    [
        ("Car 0.00 0 ", "Car  0.00 0 ", "1: error: expected one blank between fields, as MMDetection3D does"),
        ("Car 0.00 0 ", "Car\t0.00 0 ", "1: error: expected one blank between fields, as MMDetection3D does"),
        ("Car 0.00 0 ", "Car 0.00 0.0 ", "1: error: occluded 0.0 is read as 0: MMDetection3D expects"),
    ],
)
def test_lines_that_others_cannot_split_are_found(tmp_path: Path, old: str, new: str, message: str) -> None:
    write_frame(tmp_path, 0, make_frame(), split=None)
    path = tmp_path / "training" / "label_2" / "000000.txt"
    path.write_text(path.read_text().replace(old, new, 1))
    (finding,) = findings(tmp_path)
    assert finding.startswith(f"label_2/000000.txt:{message}")


def test_line_ends_of_another_system_pass(tmp_path: Path) -> None:
    write_frame(tmp_path, 0, make_frame(), split=None)
    for kind in ("label_2", "calib"):
        path = tmp_path / "training" / kind / "000000.txt"
        path.write_bytes(path.read_bytes().replace(b"\n", b"\r\n"))
    assert findings(tmp_path) == []


@pytest.mark.parametrize(
    ("kind", "old", "new", "found"),
    [
        ("label_2", "Car 0", "car 0", ["1: warning: type car is read as Car"]),
        ("label_2", "Car 0.00 0 ", "Car 0.00 0.0 ", ["1: warning: occluded 0.0 is read as 0: MMDetection3D expects"]),
        ("label_2", "Car 0", "Cone 0", ["1: warning: type Cone is not one of KITTI's"]),
        ("label_2", "Pedestrian", "\nPedestrian", ["3: warning: a blank line: OpenPCDet and MMDetection3D stop at it"]),
        ("label_2", "", "\ufeff", ["1: warning: the byte order mark before the text is passed over"]),
        ("calib", "Tr_imu", "TR_imu", ["7: warning: TR_imu_to_velo is read as Tr_imu_to_velo"]),
    ],
)
def test_dialects_are_warnings_once_a_file(tmp_path: Path, kind: str, old: str, new: str, found: list[str]) -> None:
    car, other, pedestrian, region = make_frame().labels
    write_frame(tmp_path, 0, make_frame(labels=(car, other, pedestrian, region)), split=None)
    path = tmp_path / "training" / kind / "000000.txt"
    text = path.read_text()
    path.write_bytes(text.replace(old, new, -1 if old else 1).encode("utf-8"))
    messages = findings(tmp_path, strict=False)
    places = [message.removeprefix(f"{kind}/000000.txt:") for message in messages]
    assert len(places) == len(found), messages
    assert all(place.startswith(start) for place, start in zip(places, found, strict=True)), messages


def test_line_numbers_are_the_files_own(tmp_path: Path) -> None:
    write_frame(tmp_path, 0, make_frame(), split=None)
    path = tmp_path / "training" / "label_2" / "000000.txt"
    path.write_text("\n\n" + path.read_text().replace("Pedestrian 0.00", "Pedestrian 1.40"))
    assert "label_2/000000.txt:5: error: truncated 1.4, expected 0..1" in findings(tmp_path)


def test_matrices_in_another_order_are_found(tmp_path: Path) -> None:
    write_frame(tmp_path, 0, make_frame(), split=None)
    path = tmp_path / "training" / "calib" / "000000.txt"
    lines = path.read_text().split("\n")
    path.write_text("\n".join([*lines[:4], lines[5], lines[4], *lines[6:]]))
    assert Calibration.from_text(path.read_text()) == make_calib()
    (finding,) = findings(tmp_path)
    assert finding.startswith("calib/000000.txt:5: error: expected 'R0_rect' here, as in KITTI: OpenPCDet and")


@pytest.mark.parametrize("old", ["P2: ", "P2:"])
def test_two_blanks_in_a_calibration_are_found(tmp_path: Path, old: str) -> None:
    write_frame(tmp_path, 0, make_frame(), split=None)
    path = tmp_path / "training" / "calib" / "000000.txt"
    path.write_text(path.read_text().replace(old, "P2:  ", 1))
    assert findings(tmp_path) == ["calib/000000.txt:3: error: expected one blank between numbers, as OpenPCDet does"]


def test_a_point_at_depth_0_is_found(tmp_path: Path) -> None:
    calib = make_calib()
    beside_cam = np.array([[5.0, 1.0, 0.0], [-6.0, 0.5, 0.0], [4.0, 1.0, 0.001], [0.0, 1.0, 10.0]])
    points_velo = np.hstack([calib.points_velo_from_cam(beside_cam), np.full((4, 1), 0.5)])
    # Single precision moves a coordinate by some tenths of a micrometer, more than what counts as 0.
    at_zero = calib.points_cam_from_velo(points_velo.astype(np.float32))[:, 2]
    write_frame(tmp_path, 0, make_frame(points_velo=points_velo.astype(np.float32), labels=(DONT_CARE,)), split=None)
    num_zero = int((np.abs(at_zero) < 2.5e-7).sum())
    assert 0 < num_zero < 3
    (finding,) = findings(tmp_path)
    assert finding.startswith(f"velodyne/000000.bin: error: {num_zero} points with z = 0 in the cam frame")
    (finding,) = findings(tmp_path, strict=False)
    assert "warning" in finding


@pytest.mark.parametrize("missing", ["train", "val", "test"])
def test_the_lists_that_others_read_must_be_there(tmp_path: Path, missing: str) -> None:
    write_frame(tmp_path, 0, make_frame(), split=None)
    (tmp_path / "manifest.json").write_text("{}")
    (tmp_path / "ImageSets").mkdir()
    for split in {"train", "val", "test"} - {missing}:
        (tmp_path / "ImageSets" / f"{split}.txt").write_text("")
    message = "missing: OpenPCDet and MMDetection3D stop without it; an empty list will do"
    assert findings(tmp_path) == [f"ImageSets/{missing}.txt: error: {message}"]


def test_test_frames_are_checked_too(tmp_path: Path) -> None:
    write_frame(tmp_path, 0, make_frame(), split=None)
    write_frame(tmp_path, 1, make_frame(seed=1), split=None)
    (tmp_path / "testing").mkdir()
    for kind in ("image_2", "velodyne", "calib", "label_2"):
        (tmp_path / "testing" / kind).mkdir()
        for path in (tmp_path / "training" / kind).glob("000001.*"):
            path.rename(tmp_path / "testing" / kind / path.name)
    for kind, suffix in (("planes", "txt"), ("meta", "json")):
        (tmp_path / "training" / kind / f"000001.{suffix}").unlink()
    (tmp_path / "manifest.json").write_text("{}")
    (tmp_path / "ImageSets").mkdir()
    for split, text in (("train", "000000\n"), ("val", ""), ("test", "000001\n")):
        (tmp_path / "ImageSets" / f"{split}.txt").write_text(text)
    assert findings(tmp_path) == []
    (tmp_path / "testing" / "calib" / "000001.txt").write_text("P0: 1\n")
    (tmp_path / "ImageSets" / "train.txt").write_text("000000\n000001\n")
    assert findings(tmp_path) == [
        "ImageSets/train.txt:2: error: 1 of 2 ids have no frame in training, the first is 000001",
        "ImageSets/test.txt:1: error: 000001 is in train, too",
        "testing/calib/000001.txt:1: error: P0: expected 12 numbers, got 1",
    ]
