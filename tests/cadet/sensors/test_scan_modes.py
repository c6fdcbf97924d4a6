"""How a scan is taken: turning while the world moves, beams that open, and which return is kept."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from numpy.typing import NDArray

import cadet


def beams(scan: cadet.Scan) -> NDArray[np.int64]:
    return scan.ring.astype(np.int64) * 10_000 + scan.column


@pytest.fixture(scope="module")
def street() -> cadet.Scene:
    """A street in which the ego and others drive."""
    scene = cadet.Scene.random(seed=2, weather="clear_noon")
    scene.step(5.0)
    meta = scene.capture().meta
    assert meta is not None
    assert meta["ego_speed_mps"] > 6.0
    return scene


def test_where_nothing_moves_a_turn_is_the_scan_of_an_instant() -> None:
    scene = cadet.Scene.empty()
    scene.move_ego(x_m=0.0, y_m=0.0, yaw_rad=0.3)
    for k in range(6):
        scene.add("car", x_m=8.0 + 7.0 * k, y_m=4.0 - 2.0 * k, yaw_rad=0.2 * k, model_seed=k)
    scene.add("pedestrian", x_m=6.0, y_m=-3.0, yaw_rad=1.0)
    still, turned = scene.scan(), scene.scan(cadet.Lidar(rolling=True))
    both, i, j = np.intersect1d(beams(still), beams(turned), return_indices=True)
    assert len(both) > 0.999 * max(len(still.ring), len(turned.ring)) > 20_000
    # The ego stands on its springs, which are never quite at rest: a tenth of a millimeter.
    apart = np.abs(still.points_velo[i, :3] - turned.points_velo[j, :3]).max(axis=1) > 3e-3
    assert apart.mean() < 2e-3
    assert (still.actor_id[i] != turned.actor_id[j]).mean() < 1e-3


def test_a_turn_of_a_driving_car_is_the_ideal_scan_of_each_firings_pose(street: cadet.Scene) -> None:
    """Static points, taken back by the ego's motion, lie on the surfaces that single rays meet."""
    meta = street.capture().meta
    assert meta is not None
    turned, still = street.scan(cadet.Lidar(rolling=True)), street.scan()
    assert 0.95 < len(turned.ring) / len(still.ring) < 1.05
    static = turned.actor_id == 0
    azimuth = np.arctan2(turned.points_velo[:, 1], turned.points_velo[:, 0]).astype(np.float64)
    time_s = 0.1 * azimuth / (2 * np.pi)
    # Straight ahead both agree; behind, a turn apart in time, the ego has moved by half of a turn's way.
    speed = meta["ego_speed_mps"]
    both, i, j = np.intersect1d(beams(still), beams(turned), return_indices=True)
    same = (still.actor_id[i] == 0) & static[j]
    shift = np.abs(still.range_m[i] - turned.range_m[j])
    medians_m = []
    for center, low, high in ((0.0, 0.0, 0.06), (np.pi, 0.1 * 0.05 * speed, 0.05 * speed + 1.0)):
        # Upright walls along the road don't show the motion; the median over a sector of far points does.
        near = np.abs(np.angle(np.exp(1j * (azimuth[j] - center)))) < 0.1
        chosen = same & near & (turned.points_velo[j, 2] > -1.2)
        assert chosen.sum() > 20
        medians_m.append(np.median(shift[chosen]))
        assert low <= medians_m[-1] <= high
    assert medians_m[1] > 3 * medians_m[0]
    # Every static point, moved back to the instant, is met by a ray from the instant's sensor pose through it.
    poses = street.sensor_poses()["world_from_velo"]
    pick = np.flatnonzero(static & (turned.range_m < 30))[::50]
    forward = poses[:3, 0]
    # Each laser's own error taken off.
    offsets_m = np.array([laser.range_offset_m for laser in cadet.Lidar().beam_table().rings])
    points_velo = turned.points_velo[pick, :3] * (1.0 - offsets_m[turned.ring[pick]] / turned.range_m[pick])[:, None]
    points_world = points_velo @ poses[:3, :3].T + poses[:3, 3]
    points_world = points_world + forward * (speed * time_s[pick])[:, None]
    origins_world = poses[:3, 3] + forward * (speed * time_s[pick])[:, None]
    hits = street.cast_rays(origins_world, points_world - origins_world)
    error = np.abs(hits.range_m - np.linalg.norm(points_world - origins_world, axis=1))
    # Yaw, springs and slopes are left out of this reckoning, and noise is 1.2 cm.
    assert np.median(error) < 0.03
    assert (error < 0.1).mean() > 0.8


def test_labels_stand_at_the_instant_of_the_image() -> None:
    rig = cadet.Rig.kitti()
    frames = []
    for lidar in (rig.lidar, replace(rig.lidar, rolling=True)):
        frames.append(cadet.Scene.random(seed=3, weather="clear_noon", rig=replace(rig, lidar=lidar)).capture())
    assert frames[0].labels == frames[1].labels
    np.testing.assert_array_equal(frames[0].image, frames[1].image)
    assert not np.array_equal(frames[0].points_velo, frames[1].points_velo)


def test_beams_that_open_report_the_strongest_or_the_last_surface(street: cadet.Scene) -> None:
    lines = street.scan()
    strongest = street.scan(cadet.Lidar.hdl64e_kitti(divergence_mrad=3.0))
    last = street.scan(cadet.Lidar.hdl64e_kitti(divergence_mrad=3.0, returns="last"))
    both, i, j = np.intersect1d(beams(lines), beams(strongest), return_indices=True)
    same = np.abs(lines.range_m[i] - strongest.range_m[j]) < 1e-9
    assert 0.75 < same.mean() < 0.99
    # The last return is never nearer than the strongest, but for the noise of mixed echoes.
    both, i, j = np.intersect1d(beams(strongest), beams(last), return_indices=True)
    farther = last.range_m[j] - strongest.range_m[i]
    assert len(both) > 100_000
    assert (farther > -0.1).mean() > 0.9999
    assert 0.003 < (farther > 1.0).mean() < 0.1
    # Without divergence every beam has one echo.
    plain = street.scan(cadet.Lidar.hdl64e_kitti(returns="last"))
    np.testing.assert_array_equal(plain.points_velo, lines.points_velo)
