"""Against real KITTI files; skipped, saying why, where they are missing."""

from __future__ import annotations

import functools
from pathlib import Path

import numpy as np
import pytest
from numpy.typing import NDArray

from cadet.errors import MissingFileError
from cadet.formats.kitti import (
    Calibration,
    Dataset,
    ImageSet,
    boxes,
    boxes_cam_from_labels,
    labels_from_text,
    lint,
    points_in_image,
    read_frame,
    read_image_set,
    text_from_labels,
    write_frame,
)
from cadet.formats.kitti.files.planes import plane_from_text, text_from_plane
from cadet.formats.kitti.files.velodyne import bytes_from_points, points_from_bytes
from real_kitti import ROOT, files, needs_kitti

pytestmark = needs_kitti

IMAGE_SIZES = {7.070493e02: (1224, 370), 7.183351e02: (1238, 374), 7.188560e02: (1241, 376), 7.215377e02: (1242, 375)}


def exact_text(path: Path) -> str:
    return path.read_bytes().decode("ascii")


def test_every_calibration_comes_back_byte_for_byte() -> None:
    paths = files("*/calib/*.txt")
    assert len(paths) > 190
    for path in paths:
        assert Calibration.from_text(exact_text(path)).to_text() == exact_text(path), path


def test_every_label_file_comes_back_byte_for_byte() -> None:
    paths = files("*/label_2/*.txt")
    assert len(paths) > 200
    for path in paths:
        assert text_from_labels(labels_from_text(exact_text(path))) == exact_text(path), path


def test_every_plane_scan_and_list_comes_back_byte_for_byte() -> None:
    planes, scans, lists = (files(p) for p in ("training/planes/*.txt", "training/velodyne/*.bin", "ImageSets/*.txt"))
    assert len(planes) == len(scans) >= 6 and len(lists) >= 2
    for path in planes:
        assert text_from_plane(plane_from_text(exact_text(path))) == exact_text(path), path
    for path in scans:
        assert bytes_from_points(points_from_bytes(path.read_bytes())) == path.read_bytes(), path
    for path in lists:
        assert ImageSet.from_text(exact_text(path)).to_text() == exact_text(path), path


def test_a_frame_written_again_has_the_same_files(tmp_path: Path) -> None:
    for frame_id in Dataset(ROOT).ids:
        frame = read_frame(ROOT, frame_id)
        write_frame(tmp_path, frame_id, frame)
        for kind, suffix in (("calib", "txt"), ("label_2", "txt"), ("planes", "txt"), ("velodyne", "bin")):
            name = f"training/{kind}/{frame_id}.{suffix}"
            assert (tmp_path / name).read_bytes() == (ROOT / name).read_bytes(), name
        assert np.array_equal(read_frame(tmp_path, frame_id).image, frame.image)


def test_a_dataset_reads_all_frames() -> None:
    data = Dataset(ROOT)
    assert data.ids == ("000000", "000001", "000002", "000004", "000005", "000009")
    for frame in data:
        assert frame.image.shape in {(370, 1224, 3), (375, 1242, 3)}
        assert 110_000 < len(frame.points_velo) < 128_000
        assert (frame.depth, frame.instance, frame.semantic, frame.meta) == (None, None, None, None)
        assert frame.plane is not None
        # The folder's planes were fitted without the camera's pitch in mind: within 10 cm and 3 degrees of level.
        assert np.linalg.norm(frame.plane[:3]) == pytest.approx(1.0, abs=1e-6)
        assert frame.plane[1] < -0.998
    assert len(Dataset(ROOT, "val")) == len(read_image_set(ROOT, "val")) == 3769
    with pytest.raises(MissingFileError, match=r"000003\.png: no such file$"):
        read_frame(ROOT, 3)


def test_as_many_points_fall_into_the_image_as_in_kitti() -> None:
    for frame in Dataset(ROOT):
        points_cam = frame.calib.points_cam_from_velo(frame.points_velo)
        assert 16_000 < points_in_image(points_cam, frame.calib, frame.image_size).sum() < 21_000


def test_lint_finds_no_error() -> None:
    assert [str(finding) for finding in lint(ROOT) if finding.severity == "error"] == []


@functools.cache
def labeled_boxes() -> tuple[NDArray[np.float64], NDArray[np.float64], NDArray[np.float64], NDArray[np.float64]]:
    """Overlap with and without P2's fourth column, truncation of the projected boxes, labeled truncation."""
    rows = []
    for path in files("labels_200/calib/*.txt"):
        labels = [
            label
            for label in labels_from_text(exact_text(ROOT / "labels_200" / "label_2" / path.name))
            if not label.is_dont_care
        ]
        if not labels:
            continue
        calib = Calibration.from_text(exact_text(path))
        size = IMAGE_SIZES[calib.P2[0, 0]]
        matrices = {
            name: getattr(calib, name) for name in ("P0", "P1", "P3", "R0_rect", "Tr_velo_to_cam", "Tr_imu_to_velo")
        }
        centered = Calibration(P2=calib.P2 * [1.0, 1.0, 1.0, 0.0], **matrices)
        boxes_cam, boxes_img = boxes_cam_from_labels(labels), np.array([label.bbox for label in labels])
        rows.append(
            np.stack(
                [
                    boxes.iou_img(boxes.clip_boxes_img(boxes.project_boxes(boxes_cam, calib), size), boxes_img),
                    boxes.iou_img(boxes.clip_boxes_img(boxes.project_boxes(boxes_cam, centered), size), boxes_img),
                    boxes.truncation(boxes_cam, calib, size),
                    [label.truncated for label in labels],
                ]
            )
        )
    iou, iou_centered, truncation, truncated = np.concatenate(rows, axis=1)
    return iou, iou_centered, truncation, truncated


def test_projected_boxes_are_the_labeled_ones_with_the_whole_of_p2() -> None:
    iou, iou_centered, _, _ = labeled_boxes()
    assert len(iou) > 900
    assert np.median(iou) > 0.97
    assert np.median(iou_centered) < 0.945


def test_truncation_is_the_labeled_one() -> None:
    _, _, truncation, truncated = labeled_boxes()
    is_cut = truncated > 0.0
    assert is_cut.sum() > 80
    assert np.corrcoef(truncation[is_cut], truncated[is_cut])[0, 1] > 0.998
    assert np.median(np.abs(truncation - truncated)[is_cut]) < 0.005
