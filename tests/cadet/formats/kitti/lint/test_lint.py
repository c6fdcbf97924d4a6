from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from cadet.formats.kitti import ImageSet, Label, lint, write_frame, write_image_set
from cadet.formats.kitti.files import images
from synthetic import DONT_CARE, make_calib, make_frame, make_label


@pytest.fixture
def root(tmp_path: Path) -> Path:
    for frame_id in range(2):
        write_frame(tmp_path, frame_id, make_frame(has_maps=True, seed=frame_id))
    write_image_set(tmp_path, "train", ImageSet(("000000",)))
    write_image_set(tmp_path, "val", ImageSet(("000001",)))
    write_image_set(tmp_path, "trainval", ImageSet(("000000", "000001")))
    write_image_set(tmp_path, "test", ImageSet(()))
    (tmp_path / "manifest.json").write_text("{}")
    return tmp_path


def replace(root: Path, name: str, old: str, new: str) -> None:
    path = root / "training" / name
    text = path.read_text()
    assert old in text
    path.write_text(text.replace(old, new, 1))


def test_exact_labels_pass_the_strict_lint(root: Path) -> None:
    assert [str(finding) for finding in lint(root)] == []
    assert [str(finding) for finding in lint(root, strict=False)] == []


def test_rounding_alone_never_fails_the_strict_lint(tmp_path: Path) -> None:
    """Thousands of random boxes, near, far, cut off and beside the camera, as their definitions label them."""
    rng, calib = np.random.default_rng(11), make_calib()
    labels: list[Label] = []
    while len(labels) < 2000:
        size = rng.uniform([3.0, 1.4, 1.3], [6.0, 2.2, 2.5])
        place = [
            rng.uniform(-15, 15),
            rng.uniform(0.5, 2.5),
            rng.uniform(-0.5, 60) if len(labels) % 3 else rng.uniform(1, 6),
        ]
        label = make_label("Car", (*place, *size, rng.uniform(-np.pi, np.pi)), calib)
        left, top, right, bottom = label.bbox
        if right - left > 1 and bottom - top > 1:
            labels.append(label)
    write_frame(tmp_path, 0, make_frame(labels=tuple(labels)))
    assert [str(finding) for finding in lint(tmp_path, strict=True) if finding.rule != "label-evidence"] == []


@pytest.mark.parametrize(
    ("old", "new", "line", "message"),
    [
        ("Car 0.00 0 1.64", "Car 0.00 0 1.70", 1, "alpha 1.7, expected rotation_y - atan2(x, z) = 1.64"),
        ("Car 0.00 0 1.64", "Car 0.04 0 1.64", 1, "truncated 0.04, expected 0.00"),
        ("Car 0.00 0", "Car 1.20 0", 1, "truncated 1.2, expected 0..1"),
        ("Car 0.00 0", "Car 0.00 3", 1, "occluded 3 (unknown), expected 0..2"),
        ("Car 0.00 0", "Car 0.00 -1", 1, "occluded -1, expected 0..3"),
        ("1.50 1.70 4.10", "1.50 4.10 1.70", 1, "a car 1.7 m long and 4.1 m wide: expected h w l, got 1.5 first"),
        ("1.50 1.70 4.10", "1.50 -1.70 4.10", 1, "dimensions h w l (1.5, -1.7, 4.1) are not positive"),
        ("14.00 1.50", "14.00 4.50", 1, "rotation_y 4.5, expected -pi..pi"),
        (
            "14.00 1.50",
            "14.00 1.50 0.9",
            1,
            "1 of 4 lines have a 16th field, a score: expected 15",
        ),
        ("DontCare -1 -1", "DontCare 0 -1", 4, "DontCare: truncated is 0.0, expected -1.0"),
        ("DontCare -1 -1 -10 300.00", "DontCare -1 -1 -10 325.00", 4, "bbox (325.0, 80.0, 320.0, 95.0) is empty"),
        (
            "DontCare -1 -1 -10 300.00",
            "DontCare -1 -1 -10 -3.00",
            4,
            "bbox (-3.0, 80.0, 320.0, 95.0) leaves [0, 619] x [0, 189]",
        ),
    ],
)
def test_a_label_off_its_definition_is_an_error_with_its_line(
    root: Path, old: str, new: str, line: int, message: str
) -> None:
    replace(root, "label_2/000001.txt", old, new)
    found = [finding for finding in lint(root) if finding.message == message]
    assert [(finding.file, finding.line, finding.severity) for finding in found] == [
        ("label_2/000001.txt", line, "error")
    ], [str(finding) for finding in lint(root)]


def test_a_bbox_off_by_a_pixel_is_an_error_for_ours_and_nothing_for_human_labels(root: Path) -> None:
    path = root / "training" / "label_2" / "000000.txt"
    fields = path.read_text().split("\n")[2].split(" ")
    moved = " ".join([*fields[:4], f"{float(fields[4]) + 2.0:.2f}", *fields[5:]])
    replace(root, "label_2/000000.txt", " ".join(fields), moved)
    (finding,) = lint(root)
    assert (finding.file, finding.line, finding.severity) == ("label_2/000000.txt", 3, "error")
    assert finding.message.startswith("bbox (")
    assert "is off the projected box (" in finding.message
    assert "by 2.0" in finding.message
    assert lint(root, strict=False) == []


def test_a_box_elsewhere_is_a_warning_for_human_labels(root: Path) -> None:
    replace(root, "label_2/000000.txt", "-2.00 1.65 14.00", "2.00 1.65 14.00")
    assert {finding.severity for finding in lint(root, strict=False)} == {"warning"}
    assert {finding.severity for finding in lint(root)} == {"error"}


@pytest.mark.parametrize(
    ("name", "expected"),
    [
        ("velodyne/000001.bin", "velodyne/000001.bin: error: missing"),
        ("label_2/000001.txt", "label_2/000001.txt: error: missing"),
        ("calib/000001.txt", "calib/000001.txt: error: missing"),
        ("image_2/000001.png", "image_2/000001.png: error: missing"),
    ],
)
def test_a_missing_partner_is_an_error(root: Path, name: str, expected: str) -> None:
    (root / "training" / name).unlink()
    assert [str(finding) for finding in lint(root)] == [expected]


def test_all_damaged_files_and_lines_of_a_frame_are_found_at_once(root: Path) -> None:
    replace(root, "label_2/000001.txt", "Car 0.00", "Car nan")
    replace(root, "label_2/000001.txt", "Pedestrian", "pedestrian")
    replace(root, "calib/000001.txt", "P2: ", "P9: ")
    (root / "training" / "velodyne" / "000001.bin").write_bytes(bytes(33))
    (root / "training" / "depth" / "000001.png").write_bytes(images.encode_png(np.zeros((4, 4), np.uint8)))
    places = [(finding.file, finding.line) for finding in lint(root)]
    assert places == [
        ("label_2/000001.txt", 3),
        ("velodyne/000001.bin", None),
        ("calib/000001.txt", None),
        ("depth/000001.png", None),
        ("label_2/000001.txt", 1),
    ]


def test_files_without_a_frame_are_found(root: Path) -> None:
    (root / "training" / "planes" / "000009.txt").write_text("")
    (root / "training" / "label_2" / ".000000.txt.77.tmp").write_text("")
    assert [str(finding) for finding in lint(root)] == [
        "label_2/.000000.txt.77.tmp: warning: belongs to no frame",
        "planes/000009.txt: warning: belongs to no frame",
    ]


def test_scans_are_checked(tmp_path: Path) -> None:
    points_velo = np.array([[10, 0, 0, 0.5], [0.5, 0, 0, 0.5], [0, 90, 0, 1.5]], np.float32)
    write_frame(tmp_path, 0, make_frame(points_velo=points_velo, labels=(DONT_CARE,)))
    assert [str(finding) for finding in lint(tmp_path, strict=True)] == [
        "velodyne/000000.bin: error: intensity 0.500..1.500, expected 0..1: divide by the greatest, such as 255",
        "velodyne/000000.bin: error: 2 points with range outside 1.45..80.0 m (smallest 0.500, largest 90.000)",
    ]


@pytest.mark.parametrize(
    ("plane", "message"),
    [
        ([0.0, -2.0, 0.0, 1.65], "normal has length 2.000000, expected 1"),
        ([0.0, 1.0, 0.0, 1.65], "b = 1.000000, expected below 0: the normal must point up"),
        ([0.0, -1.0, 0.0, -1.65], "d = -1.650 m, expected 1.0..2.5"),
    ],
)
def test_planes_are_checked(tmp_path: Path, plane: list[float], message: str) -> None:
    write_frame(tmp_path, 0, make_frame(plane=np.array(plane)))
    assert [str(finding) for finding in lint(tmp_path, strict=True)] == [f"planes/000000.txt:4: error: {message}"]


def test_calibrations_are_checked(root: Path) -> None:
    replace(root, "calib/000000.txt", "R0_rect: 9.9", "R0_rect: 1.9")
    assert any(
        finding.file == "calib/000000.txt" and finding.message.startswith("R0_rect: not a rotation")
        for finding in lint(root)
    )


def test_meta_is_checked_against_the_files(tmp_path: Path) -> None:
    write_frame(tmp_path, 0, make_frame(meta={"image_size": [1242, 375], "objects": [{}]}))
    assert [str(finding) for finding in lint(tmp_path)] == [
        "meta/000000.json: error: 1 objects, label_2 has 4 lines",
        "image_2/000000.png: error: image is [620, 190] pixels, meta says [1242, 375]",
    ]


def test_lists_are_checked(root: Path) -> None:
    write_image_set(root, "train", ImageSet(("000000", "000007", "000008")))
    write_image_set(root, "val", ImageSet(("000001", "000000")))
    write_image_set(root, "test", ImageSet(("000055",)))
    (root / "ImageSets" / "odd.txt").write_text("000000\n.x\n")
    assert [str(finding) for finding in lint(root)] == [
        "ImageSets/odd.txt:2: error: expected a frame's id such as 000012, got '.x'",
        "ImageSets/test.txt:1: error: 1 of 1 ids have no frame in testing, the first is 000055",
        "ImageSets/train.txt:2: error: 2 of 3 ids have no frame in training, the first is 000007",
        "ImageSets/val.txt:2: error: 000000 is in train, too",
        "ImageSets/trainval.txt: error: is not train and val together",
    ]
