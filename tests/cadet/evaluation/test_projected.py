"""Objects without a 2D box: told, and given the box that their 3D box has in the image."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from click.testing import CliRunner

import cadet
from cadet import CadetError, MissingFileError
from cadet.cli.tools import cadet as command
from cadet.evaluation.packed import read_packed
from cadet.evaluation.projected import project_sides
from cadet.formats.kitti import Label, boxes
from cadet.formats.kitti.files import images
from evaluation_helpers import DONT_CARE, detected, write
from synthetic import IMAGE_SIZE, make_calib, make_label

CALIB = make_calib()
CARS = tuple(make_label("Car", (x, 1.65, z, 4.1, 1.7, 1.5, 1.2), CALIB) for x, z in ((-4.0, 14.0), (3.0, 11.0)))
NONE, MARK = (0.0, 0.0, 0.0, 0.0), (-1.0, -1.0, -1.0, -1.0)
NUM_FRAMES = 25


def without_boxes(bbox: tuple[float, float, float, float], **changes: object) -> list[Label]:
    return [replace(car, bbox=bbox, **changes) for car in CARS]  # type: ignore[arg-type]


def make_set(root: Path, truths: list[Label], found: list[Label], *, has_images: bool = True) -> tuple[Path, Path]:
    write(root / "training" / "label_2", [[*truths, DONT_CARE]] * NUM_FRAMES)
    for kind in ("calib", "image_2"):
        (root / "training" / kind).mkdir()
    width, height = IMAGE_SIZE
    png = images.encode_png(np.zeros((height, width, 3), np.uint8))
    for index in range(NUM_FRAMES):
        (root / "training" / "calib" / f"{index:06d}.txt").write_text(CALIB.to_text())
        if has_images:
            (root / "training" / "image_2" / f"{index:06d}.png").write_bytes(png)
    return root, write(root / "det", [[detected(car) for car in found]] * NUM_FRAMES)


@pytest.mark.parametrize("bbox", [NONE, MARK, (50.0, 50.0, 50.0, 90.0)])
def test_detections_that_count_nothing_are_told_and_projected(tmp_path: Path, bbox: tuple[float, ...]) -> None:
    gt, det = make_set(tmp_path, list(CARS), without_boxes(bbox, alpha=-10.0))  # type: ignore[arg-type]
    plain = cadet.evaluate(gt, det, classes=["Car"])
    low = 0 if bbox[1] < bbox[3] else 50
    if low:
        note = (
            "50 of 50 detections are less than 25 px high in the image and count nothing; 50 have no 2D box (such as "
        )
        assert [one for one in plain.warnings if one.startswith(note) and "--boxes-2d project" in one]
        assert plain.ap["Car"]["3d"]["Easy"] == 0.0
    mended = cadet.evaluate(gt, det, classes=["Car"], boxes_2d="project")
    perfect = cadet.evaluate(
        gt, write(tmp_path / "perfect", [[detected(car) for car in CARS]] * NUM_FRAMES), classes=["Car"]
    )
    assert [row["Easy"] for row in mended.ap["Car"].values()] == pytest.approx([100.0] * 6, abs=1e-3)
    assert mended.ap["Car"].keys() == {"2d", "bev", "3d", "aos", "ahs_bev", "ahs_3d"}
    options = ["--classes", "Car", "--boxes-2d", "project", "--json"]
    printed = CliRunner().invoke(command, ["eval", str(gt), str(det), *options], catch_exceptions=False)
    assert printed.output == mended.to_json()
    assert mended.ap["Car"]["3d"] == perfect.ap["Car"]["3d"]
    assert mended.warnings == perfect.warnings == ()


def test_objects_without_a_2d_box_are_told_and_projected(tmp_path: Path) -> None:
    gt, det = make_set(tmp_path, without_boxes(NONE), without_boxes(NONE))
    plain = cadet.evaluate(gt, det, classes=["Car"])
    note = "50 of 50 objects have no 2D box (such as 0 0 0 0), so that no level asks for them; --boxes-2d project"
    assert [one for one in plain.warnings if one.startswith(note)]
    assert plain.n_gt["Car"]["3d"]["Easy"] == 0
    assert cadet.analyze(gt, det, classes=["Car"], parts=(), boxes_2d="project").report.n_gt["Car"]["3d"]["Easy"] == 50


@pytest.mark.parametrize("has_images", [True, False])
def test_boxes_are_those_of_the_projection_within_the_image(tmp_path: Path, has_images: bool) -> None:
    behind = replace(CARS[0], location_cam=(0.0, 1.65, -20.0))
    beside = replace(CARS[0], location_cam=(-9.0, 1.65, 10.0))
    flat = Label.in_image("Car", (10.0, 20.0, 60.0, 80.0))
    found = [replace(car, bbox=(1.0, 2.0, 3.0, 4.0), alpha=0.0) for car in (CARS[0], behind, beside)] + [flat]
    gt, det = make_set(tmp_path, list(CARS), found, has_images=has_images)
    ids = ["000000"]
    truths = read_packed(gt / "training" / "label_2", ids, cadet.GroundTruth)
    detections = read_packed(det, ids, cadet.Detections)
    same, seen = project_sides(truths, detections, ids, gt / "training")
    np.testing.assert_array_equal(same.objects.boxes_img, truths.objects.boxes_img)
    boxes_cam = np.stack([CARS[0].box_cam, beside.box_cam])
    size = IMAGE_SIZE if has_images else (1242, 375)
    expected = boxes.clip_boxes_img(boxes.project_boxes(boxes_cam, CALIB), size)
    np.testing.assert_allclose(seen.objects.boxes_img[[0, 2]], expected)
    np.testing.assert_array_equal(seen.objects.boxes_img[[1, 3]], [[1.0, 2.0, 3.0, 4.0], [10.0, 20.0, 60.0, 80.0]])
    np.testing.assert_allclose(seen.objects.alphas[[0, 2]], boxes.alpha_from_boxes(boxes_cam))
    assert seen.objects.alphas[3] == -10.0


def test_small_detections_are_told_where_they_are_most(tmp_path: Path) -> None:
    left, top, right, _ = CARS[0].bbox
    small = replace(CARS[0], bbox=(left, top, right, top + 20.0))
    gt, det = make_set(tmp_path, list(CARS), [small, small, CARS[1]])
    note = "50 of 75 detections are less than 25 px high in the image and count nothing."
    assert note in cadet.evaluate(gt, det, classes=["Car"]).warnings
    few = write(tmp_path / "few", [[detected(car) for car in (small, *CARS)]] * NUM_FRAMES)
    assert not [one for one in cadet.evaluate(gt, few, classes=["Car"]).warnings if "count nothing" in one]


def test_without_calibrations_there_is_nothing_to_project_with(tmp_path: Path) -> None:
    gt, det = make_set(tmp_path, list(CARS), without_boxes(NONE))
    with pytest.raises(CadetError, match=r"^boxes_2d: the ground truth is not a KITTI folder"):
        cadet.evaluate([list(CARS)], [[detected(car) for car in CARS]], boxes_2d="project")
    (gt / "training" / "calib" / "000007.txt").unlink()
    with pytest.raises(MissingFileError, match=r"calib/000007\.txt: no such file"):
        cadet.evaluate(gt, det, boxes_2d="project")
