"""A generated folder as other programs read it: the programs themselves where they are installed, else their rules.

The rules are written down from what the programs do: the steps of OpenPCDet and MMDetection3D that make info files, in
single precision, as they compute. What they count is compared with what `cadet` counts.
"""

from __future__ import annotations

from collections import Counter
from collections.abc import Iterator
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from numpy.typing import NDArray

import cadet
from cadet import kitti
from cadet.evaluation import LEVELS
from cadet.formats.kitti import boxes, points_in_image
from cadet.generate import Settings, generate
from readers.toolbox_rules import Info, ids_of, read_info

NUM_FRAMES = 8
CLASSES = {"Car", "Van", "Truck", "Pedestrian", "Person_sitting", "Cyclist", "Tram", "Misc"}


@pytest.fixture(scope="module")
def root(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """Four episodes of two frames: train, val, test, train."""
    out = tmp_path_factory.mktemp("toolboxes") / "out"
    policy = replace(cadet.ResetPolicy.kitti(), samples_per_episode=2)
    generate(out, Settings(seed=5, num_frames=NUM_FRAMES, policy=policy, test_fraction=0.25), workers=2)
    return out


def infos(root: Path, split: str) -> Iterator[tuple[str, Info, cadet.Frame]]:
    """Yield a split's frames as a toolbox reads them and as `cadet` does."""
    part = "testing" if split == "test" else "training"
    dataset = kitti.Dataset(root, split)
    for frame_id in ids_of(root, split):
        yield frame_id, read_info(root, part, frame_id), dataset[frame_id]


def rect_from_velo(info: Info) -> NDArray[np.float32]:
    homogeneous = np.hstack([info.points_velo[:, :3], np.ones((len(info.points_velo), 1), np.float32)])
    points: NDArray[np.float32] = homogeneous @ (info.calib["V2C"].T @ info.calib["R0"].T)
    return points


def in_view(info: Info) -> NDArray[np.bool_]:
    """OpenPCDet's field of view: pixels by dividing by the camera frame's z."""
    rect = rect_from_velo(info)
    projected = np.hstack([rect, np.ones((len(rect), 1), np.float32)]) @ info.calib["P2"].T
    u, v = (projected[:, :2] / rect[:, 2:]).T
    depth = projected[:, 2] - info.calib["P2"][2, 3]
    width, height = info.image_size
    seen: NDArray[np.bool_] = (u >= 0) & (u < width) & (v >= 0) & (v < height) & (depth >= 0)
    return seen


def count_points(info: Info, points_rect: NDArray[np.float32]) -> list[int]:
    """Count the points in each box, turned into the box's own axes."""
    counts = []
    for x, y, z, length, width, height, rotation_y in info.boxes_cam.astype(np.float32):
        moved = points_rect - np.array([x, y - height / 2, z], np.float32)
        along = np.cos(rotation_y) * moved[:, 0] - np.sin(rotation_y) * moved[:, 2]
        across = np.sin(rotation_y) * moved[:, 0] + np.cos(rotation_y) * moved[:, 2]
        inside = (np.abs(along) <= length / 2) & (np.abs(across) <= width / 2) & (np.abs(moved[:, 1]) <= height / 2)
        counts.append(int(inside.sum()))
    return counts


@pytest.mark.parametrize("split", ["train", "val", "test"])
def test_the_first_n_lines_are_the_n_objects(root: Path, split: str) -> None:
    for frame_id, info, frame in infos(root, split):
        assert set(info.names) <= CLASSES, frame_id
        assert info.names == [label.type for label in frame.labels if not label.is_dont_care]
        ours = kitti.boxes_cam_from_labels(label for label in frame.labels if not label.is_dont_care)
        np.testing.assert_allclose(info.boxes_cam, ours, atol=1e-12)


def test_no_point_has_depth_0_in_single_precision(root: Path) -> None:
    for split in ("train", "val", "test"):
        for _, info, _ in infos(root, split):
            with np.errstate(all="raise"):
                in_view(info)


def test_the_field_of_view_is_ours(root: Path) -> None:
    for frame_id, info, frame in infos(root, "trainval"):
        theirs = in_view(info)
        ours = points_in_image(frame.calib.points_cam_from_velo(frame.points_velo), frame.calib, frame.image_size)
        # They divide by the camera frame's z, we by the depth before camera 2, some millimeters more: their field of
        # view ends a little earlier at the right and below.
        assert np.sum(theirs & ~ours) <= 2, frame_id
        assert np.mean(theirs != ours) < 2e-3, frame_id
        assert ours.sum() > 10_000


def test_points_in_boxes_are_ours(root: Path) -> None:
    num_boxes = 0
    for frame_id, info, frame in infos(root, "trainval"):
        seen = in_view(info)
        theirs = count_points(info, rect_from_velo(info)[seen])
        points_cam = frame.calib.points_cam_from_velo(frame.points_velo)[seen]
        ours = boxes.points_in_boxes(points_cam, info.boxes_cam).sum(axis=0 if len(info.boxes_cam) else None)
        assert np.abs(np.atleast_1d(ours)[: len(theirs)] - theirs).max(initial=0) <= 2, frame_id
        num_boxes += len(theirs)
    assert num_boxes > 0


def test_upright_boxes_differ_from_ours_by_the_calibrations_tilt_alone(root: Path) -> None:
    """MMDetection3D takes boxes into the LIDAR's frame by place and heading, and drops the camera's tilt."""
    num_ours = num_theirs = 0
    for frame_id, info, frame in infos(root, "trainval"):
        velo_from_cam = frame.calib.velo_from_cam
        tilt_rad = np.arccos(-velo_from_cam[2, 1])
        points_velo = info.points_velo[:, :3].astype(float)
        points_cam = frame.calib.points_cam_from_velo(points_velo)
        for x, y, z, length, width, height, rotation_y in info.boxes_cam:
            half = np.array([length, width, height]) / 2
            place_velo = velo_from_cam[:3, :3] @ [x, y, z] + velo_from_cam[:3, 3]
            outside = []
            for points, place, heading, axes, up in (
                (points_cam, [x, y, z], rotation_y, (0, 2, 1), -1.0),
                (points_velo, place_velo, -rotation_y - np.pi / 2, (0, 1, 2), 1.0),
            ):
                along, across, above = (points - place)[:, axes].T
                turn = heading * up
                forward = np.cos(turn) * along + np.sin(turn) * across
                left = -np.sin(turn) * along + np.cos(turn) * across
                own = np.stack([forward, left, up * above - height / 2], axis=1)
                outside.append((np.abs(own) - half).max(axis=1))
            ours, theirs = (distance_m <= 0 for distance_m in outside)
            limit_m = 2.0 * tilt_rad * np.linalg.norm(half) + 1e-3
            assert (np.abs(outside[0][ours != theirs]) < limit_m).all(), frame_id
            num_ours, num_theirs = num_ours + int(ours.sum()), num_theirs + int(theirs.sum())
    assert 0.94 * num_ours < num_theirs < 1.02 * num_ours, (num_theirs, num_ours)


def difficulty(info: Info, least_px: tuple[float, float, float], extra_px: float) -> list[int]:
    """0 easy, 1 moderate, 2 hard, -1 none: each object's first level that takes it."""
    found = []
    for height, truncated, occluded in zip(info.heights_px + extra_px, info.truncated, info.occluded, strict=True):
        limits = zip(least_px, (0.15, 0.3, 0.5), (0, 1, 2), strict=True)
        passed = [height > least and truncated <= most and occluded <= hidden for least, most, hidden in limits]
        found.append(passed.index(True) if any(passed) else -1)
    return found


def test_difficulties_are_our_levels(root: Path) -> None:
    """MMDetection3D's; OpenPCDet adds a pixel to the height, as its boxes count both borders."""
    counts: Counter[int] = Counter()
    for frame_id, info, frame in infos(root, "trainval"):
        theirs = difficulty(info, (40, 25, 25), 0.0)
        labels = [label for label in frame.labels if not label.is_dont_care]
        ours = []
        for label in labels:
            height = label.bbox[3] - label.bbox[1]
            passed = [
                (height >= level.min_height_px if level.inclusive else height > level.min_height_px)
                and (level.max_occlusion is None or label.occluded <= level.max_occlusion)
                and (level.max_truncation is None or label.truncated <= level.max_truncation)
                for level in LEVELS["kitti"]
            ]
            ours.append(passed.index(True) if any(passed) else -1)
        assert theirs == ours, frame_id
        easier = difficulty(info, (39.999, 24.999, 24.999), 1.0)
        assert all(b == a or (b != -1 and (a == -1 or b < a)) for a, b in zip(theirs, easier, strict=True))
        counts.update(theirs)
    assert len(counts) > 1


def needed(name: str, package: str = "") -> Any:
    return pytest.importorskip(
        name, reason=f"reads the folder with {name}: pip install {package or name}", exc_type=ImportError
    )


@pytest.mark.filterwarnings("ignore")
def test_torchvision_reads_the_same_labels(root: Path, tmp_path: Path) -> None:
    datasets = needed("torchvision").datasets
    (tmp_path / "Kitti").mkdir()
    (tmp_path / "Kitti" / "raw").symlink_to(root)
    theirs, ours = datasets.Kitti(str(tmp_path), train=True), kitti.Dataset(root)
    assert len(theirs) == len(ours)
    frames = {frame_id: ours[frame_id] for frame_id in ours.ids}
    for index in range(len(theirs)):
        image, targets = theirs[index]
        frame = frames[Path(theirs.images[index]).stem]
        assert np.array_equal(np.asarray(image), frame.image)
        assert [target["type"] for target in targets] == [label.type for label in frame.labels]
        assert [target["location"] for target in targets] == [list(label.location_cam) for label in frame.labels]
        assert [target["bbox"] for target in targets] == [list(label.bbox) for label in frame.labels]
    assert len(datasets.Kitti(str(tmp_path), train=False)) == len(kitti.Dataset(root, "test"))


@pytest.mark.filterwarnings("ignore")
def test_pykitti_reads_calibrations_and_scans(root: Path) -> None:
    utils = needed("pykitti").utils
    for frame_id in kitti.Dataset(root).ids:
        frame = kitti.read_frame(root, frame_id)
        theirs = utils.read_calib_file(str(root / "training" / "calib" / f"{frame_id}.txt"))
        for key in ("P0", "P1", "P2", "P3", "R0_rect", "Tr_velo_to_cam", "Tr_imu_to_velo"):
            assert np.array_equal(theirs[key], getattr(frame.calib, key).ravel())
        scan = utils.load_velo_scan(str(root / "training" / "velodyne" / f"{frame_id}.bin"))
        assert np.array_equal(scan, frame.points_velo)


@pytest.mark.filterwarnings("ignore")
def test_open3d_finds_the_same_points_in_boxes(root: Path) -> None:
    o3d = needed("open3d")
    frame = next(frame for frame in kitti.Dataset(root) if not frame.labels[0].is_dont_care)
    box_velo = boxes.boxes_velo_from_cam(frame.labels[0].box_cam[None], frame.calib)[0]
    cloud = o3d.geometry.PointCloud(o3d.utility.Vector3dVector(frame.points_velo[:, :3].astype(np.float64)))
    # Turned exactly as the label's box is: about the cam frame's y axis, then into the velo frame.
    cosine, sine = np.cos(frame.labels[0].rotation_y), np.sin(frame.labels[0].rotation_y)
    turn = np.array([[cosine, 0.0, sine], [0.0, 1.0, 0.0], [-sine, 0.0, cosine]])
    length, width, height = box_velo[3:6]
    rotation = np.linalg.inv(frame.calib.cam_from_velo)[:3, :3] @ turn
    center = frame.calib.points_velo_from_cam(frame.labels[0].box_cam[None, :3] - [[0.0, height / 2, 0.0]])[0]
    box = o3d.geometry.OrientedBoundingBox(center, rotation, np.array([length, height, width]))
    theirs = len(box.get_point_indices_within_bounding_box(cloud.points))
    points_cam = frame.calib.points_cam_from_velo(frame.points_velo)
    ours = int(boxes.points_in_boxes(points_cam, frame.labels[0].box_cam[None]).sum())
    assert ours > 0
    assert abs(theirs - ours) <= 1
