"""Labels do not depend on how large the image is written: pixel limits scale with it."""

from __future__ import annotations

from dataclasses import replace

import pytest

import cadet

SIZES = {"full": (1242, 375), "half": (621, 188), "quarter": (310, 94)}


def labeled(camera: cadet.Camera) -> tuple[int, int]:
    """Count cars and DontCare regions along two rows of cars, seen by a camera."""
    rig = cadet.Rig(camera=camera, lidar=cadet.Lidar.vlp16())
    num_cars = num_dont_care = 0
    for seed in range(4):
        scene = cadet.Scene.empty(rig=rig)
        scene.move_ego(x_m=0.0, y_m=0.0, yaw_rad=0.0)
        for index in range(24):
            x, y = 10.0 + 2.7 * index, (-1.0) ** index * (3.0 + 0.5 * index)
            scene.add("car", x_m=x, y_m=y, yaw_rad=0.2 * index, model_seed=100 * seed + index)
        types = [label.type for label in scene.capture().labels]
        num_cars += types.count("Car")
        num_dont_care += types.count("DontCare")
    return num_cars, num_dont_care


@pytest.fixture(scope="module")
def counts() -> dict[str, tuple[int, int]]:
    return {scale: labeled(cadet.Camera.kitti().resized(*size)) for scale, size in SIZES.items()}


def test_as_many_objects_are_labeled_at_every_size(counts: dict[str, tuple[int, int]]) -> None:
    full, _ = counts["full"]
    assert full >= 15
    for scale in ("half", "quarter"):
        assert counts[scale][0] == pytest.approx(full, rel=0.1), counts
    # A camera that was a quarter as large from the start has no limits to scale: it labels what 15 rows hold.
    unscaled = replace(cadet.Camera.kitti().resized(*SIZES["quarter"]), image_scale=(1.0, 1.0))
    assert labeled(unscaled)[0] < 0.9 * full


def test_limits_follow_rows_and_area() -> None:
    camera = cadet.Camera.kitti().resized(621, 375)
    assert camera.image_scale == (0.5, 1.0)
    label = cadet.SceneConfig().scaled(camera.image_scale).label
    assert (label.min_height_px, label.dontcare_min_pixels) == (15.0, 4.0)
    back = camera.resized(1242, 375)
    assert back == cadet.Camera.kitti()
    assert cadet.SceneConfig().scaled(back.image_scale) == cadet.SceneConfig()
