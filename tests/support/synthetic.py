"""Frames made by hand for tests of readers, writers and figures: a flat road, a few boxes, exact labels."""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import NDArray

from cadet.formats.kitti import Calibration, Label, boxes
from cadet.formats.kitti.frame import Frame

IMAGE_SIZE = (620, 190)
DONT_CARE = Label("DontCare", -1, -1, -10, (300.0, 80.0, 320.0, 95.0), (-1, -1, -1), (-1000, -1000, -1000), -10)


def make_calib() -> Calibration:
    """Make a calibration like KITTI's at half its size, slightly rotated, camera 2 6 cm right of camera 0."""
    projections = {
        name: np.array([[360.0, 0.0, 309.5, baseline], [0.0, 360.0, 90.0, 0.1], [0.0, 0.0, 1.0, 0.003]])
        for name, baseline in (("P0", 0.0), ("P1", -190.0), ("P2", 23.0), ("P3", -167.0))
    }
    roll = 0.01
    rectify = np.array([[np.cos(roll), -np.sin(roll), 0.0], [np.sin(roll), np.cos(roll), 0.0], [0.0, 0.0, 1.0]])
    axes = np.array([[0.0, -1.0, 0.0], [0.0, 0.0, -1.0], [1.0, 0.0, 0.0]])
    velo = np.hstack([rectify.T @ axes, [[0.0], [-0.08], [-0.27]]])
    imu = np.hstack([np.eye(3), [[-0.81], [0.32], [-0.8]]])
    return Calibration(
        P0=projections["P0"],
        P1=projections["P1"],
        P2=projections["P2"],
        P3=projections["P3"],
        R0_rect=rectify,
        Tr_velo_to_cam=velo,
        Tr_imu_to_velo=imu,
    )


def make_label(kind: str, box_cam: tuple[float, ...], calib: Calibration, occluded: int = 0) -> Label:
    """Make the label that the definitions give a box [x, y, z, l, w, h, rotation_y]."""
    x, y, z, length, width, height, rotation_y = box_cam
    stacked = np.array([box_cam])
    whole = boxes.project_boxes(stacked, calib)
    left, top, right, bottom = boxes.clip_boxes_img(whole, IMAGE_SIZE)[0].tolist()
    return Label(
        type=kind,
        truncated=float(boxes.truncation(stacked, calib, IMAGE_SIZE)[0]),
        occluded=occluded,
        alpha=float(boxes.alpha_from_boxes(stacked)[0]),
        bbox=(left, top, right, bottom),
        dimensions_hwl=(height, width, length),
        location_cam=(x, y, z),
        rotation_y=rotation_y,
    )


def make_labels(calib: Calibration) -> tuple[Label, ...]:
    """Label a car ahead, one cut off by the image's right edge, a pedestrian behind the first, and a region."""
    return (
        make_label("Car", (-2.0, 1.65, 14.0, 4.1, 1.7, 1.5, 1.5), calib),
        make_label("Car", (5.6, 1.65, 7.5, 3.9, 1.6, 1.4, -1.62), calib),
        make_label("Pedestrian", (-2.4, 1.65, 21.0, 0.8, 0.6, 1.8, 0.3), calib, occluded=2),
        DONT_CARE,
    )


def make_points(labels: tuple[Label, ...], calib: Calibration, seed: int = 0) -> NDArray[np.float32]:
    """Scatter returns over the road and the boxes' corners and centers, the road's first."""
    rng = np.random.default_rng(3 + seed)
    road_cam = np.stack([rng.uniform(-20, 20, 4000), np.full(4000, 1.65), rng.uniform(3, 60, 4000)], axis=1)
    stacked = np.stack([label.box_cam for label in labels if not label.is_dont_care])
    corners = boxes.corners_cam(stacked)
    mix = rng.dirichlet(np.ones(8), (len(stacked), 200))
    points_velo = calib.points_velo_from_cam(np.concatenate([road_cam, (mix @ corners).reshape(-1, 3)]))
    intensity = rng.integers(0, 100, len(points_velo)) / 100.0
    return np.hstack([points_velo.round(3), intensity[:, None]]).astype(np.float32)


def make_frame(*, has_maps: bool = False, seed: int = 0, **changes: Any) -> Frame:
    """Make a frame; `changes` replace fields of it, `has_maps` adds depth, instance and semantic.

    Frames of several seeds have images and scans that do not look like each other's.
    """
    calib = make_calib()
    labels = make_labels(calib)
    width, height = IMAGE_SIZE
    rng = np.random.default_rng(5)
    shade = np.linspace(200, 60, height).astype(np.uint8)[:, None, None]
    image = np.clip(shade + rng.integers(0, 20, (height, width, 3)), 0, 255).astype(np.uint8)
    if seed:
        tiles = np.random.default_rng(seed).integers(0, 2, (-(-height // 10), -(-width // 10)), np.uint8)
        image //= 1 + np.kron(tiles, np.ones((10, 10), np.uint8))[:height, :width, None]
    fields: dict[str, Any] = {
        "image": image,
        "points_velo": make_points(labels, calib, seed),
        "labels": labels,
        "calib": calib,
        "plane": np.array([0.0, -1.0, 0.0, 1.65]),
        "meta": {"episode": seed, "sample": 3, "weather": "clear_noon"},
    }
    if has_maps:
        fields |= _maps(labels, calib)
    return Frame(**(fields | changes))


def _maps(labels: tuple[Label, ...], calib: Calibration) -> dict[str, Any]:
    """Draw the road and, as flat boards at their centers' depth, the objects."""
    width, height = IMAGE_SIZE
    rows = np.arange(height, dtype=np.float64)[:, None] - calib.P2[1, 2]
    depth = np.where(rows > 0, 360.0 * 1.65 / np.maximum(rows, 1e-9), np.inf) * np.ones((1, width))
    instance = np.where(np.isfinite(depth), 0, -1)
    for actor_id, label in enumerate(labels, start=1):
        if not label.is_dont_care:
            left, top, right, bottom = (round(x) for x in label.bbox)
            window = (slice(top, bottom + 1), slice(left, right + 1))
            is_nearer = depth[window] > label.location_cam[2]
            depth[window] = np.where(is_nearer, label.location_cam[2], depth[window])
            instance[window] = np.where(is_nearer, actor_id, instance[window])
    return {
        "depth": depth.astype(np.float32),
        "instance": instance.astype(np.int32),
        "semantic": (instance + 1).astype(np.uint8),
    }
