"""The estimated ground plane against planes that are known."""

from __future__ import annotations

import numpy as np
import pytest
from numpy.typing import NDArray

from cadet import kitti
from cadet.errors import CadetError, NonFiniteError
from cadet.formats.kitti import estimate_plane
from real_kitti import ROOT, files, needs_kitti
from synthetic import make_calib

CALIB = make_calib()


def road_velo(plane: NDArray[np.float64], noise_m: float, seed: int = 0) -> NDArray[np.float64]:
    """Return 6000 points of a plane, a third of them replaced by walls, cars' flanks and a sidewalk 12 cm higher."""
    generator = np.random.default_rng(seed)
    n = 6000
    z = generator.uniform(3, 40, n)
    x = generator.uniform(-12, 12, n)
    y = -(plane[0] * x + plane[2] * z + plane[3]) / plane[1] + generator.normal(0, noise_m, n)
    y[x > 4] -= 0.12
    walls = generator.random(n) < 0.33
    y[walls] -= generator.uniform(0, 2.5, walls.sum())
    return CALIB.points_velo_from_cam(np.column_stack([x, y, z]))


def height_at(plane: NDArray[np.float64], z_m: float) -> float:
    return float(-(plane[2] * z_m + plane[3]) / plane[1])


def heights_m(plane: NDArray[np.float64]) -> NDArray[np.float64]:
    return np.array([height_at(plane, z) for z in (0.0, 5.0, 10.0)])


def test_far_ground_is_held_though_the_near_ground_bends() -> None:
    """A road that falls 2 % for 15 m and is level from there on: a plane through its near part is 0.6 m too low."""
    generator = np.random.default_rng(1)
    # As a LIDAR sees it: rings, each as far from the next as the square of the distance.
    z = 1.0 / generator.uniform(1 / 48, 1 / 3, 8000)
    x = generator.uniform(-4, 4, len(z))
    y = 1.65 + 0.02 * np.minimum(z, 15.0) + generator.normal(0, 0.01, len(z))
    got = estimate_plane(CALIB.points_velo_from_cam(np.column_stack([x, y, z])), CALIB)
    assert abs(height_at(got, 40.0) - 1.95) < 0.15
    # One plane can't hold both parts: it lies on the longer one.
    assert abs(height_at(got, 15.0) - 1.95) < 0.05


@pytest.mark.parametrize("tilt", [(0.0, 0.0), (0.03, -0.02), (-0.05, 0.06)])
@pytest.mark.parametrize("height_m", [1.2, 1.65, 2.1])
def test_a_known_plane_is_found(tilt: tuple[float, float], height_m: float) -> None:
    normal = np.array([tilt[0], -1.0, tilt[1]])
    plane = np.append(normal, height_m) / np.linalg.norm(normal)
    got = estimate_plane(road_velo(plane, 0.01), CALIB)
    assert np.abs(heights_m(got) - heights_m(plane)).max() < 0.02
    assert np.degrees(np.arccos(got[:3] @ plane[:3])) < 0.4
    assert got[1] < 0 and np.linalg.norm(got[:3]) == pytest.approx(1)


def test_a_seed_gives_one_plane_and_order_of_points_none() -> None:
    points_velo = road_velo(np.array([0.0, -1.0, 0.0, 1.65]), 0.02)
    assert np.array_equal(estimate_plane(points_velo, CALIB, seed=3), estimate_plane(points_velo, CALIB, seed=3))
    assert np.allclose(estimate_plane(points_velo[::-1], CALIB), estimate_plane(points_velo, CALIB), atol=1e-9)
    as_written = np.hstack([points_velo, np.zeros((len(points_velo), 1))]).astype(np.float32)
    assert np.allclose(estimate_plane(as_written, CALIB), estimate_plane(points_velo, CALIB), atol=1e-3)


def test_scans_without_a_road_are_refused() -> None:
    with pytest.raises(
        CadetError, match="expected at least 30 points of the ground 2 to 50 m ahead of the camera, got 0"
    ):
        estimate_plane(np.zeros((0, 4), np.float32), CALIB)
    wall = np.random.default_rng(0).uniform([10.0, -5.0, -1.7], [10.0, 5.0, 0.0], (500, 3))
    with pytest.raises(CadetError, match="no plane that a car could stand on"):
        estimate_plane(wall, CALIB)
    with pytest.raises(NonFiniteError, match="points_velo: not finite"):
        estimate_plane(np.full((50, 4), np.nan), CALIB)


@needs_kitti
def test_real_scans_give_their_plane_files() -> None:
    dataset = kitti.Dataset(ROOT)
    ids = [path.stem for path in files("training/planes/*.txt")]
    assert len(ids) >= 6
    for frame_id in ids:
        frame = dataset[frame_id]
        assert frame.plane is not None
        plane = frame.plane / np.linalg.norm(frame.plane[:3]) * (-1 if frame.plane[1] > 0 else 1)
        got = estimate_plane(frame.points_velo, frame.calib)
        assert np.abs(heights_m(got) - heights_m(plane)).max() < 0.06, frame_id
        # The label of a car at 40 m is as wrong as the plane under it.
        assert abs(height_at(got, 40.0) - height_at(plane, 40.0)) < 0.1, frame_id
        assert np.degrees(np.arccos(min(1.0, got[:3] @ plane[:3]))) < 1.5, frame_id
