"""How a scan is taken: turning while the world moves, beams that open, and which return is kept."""

from __future__ import annotations

from dataclasses import replace
from itertools import pairwise
from pathlib import Path

import numpy as np
import pytest
from numpy.typing import NDArray

import cadet
from cadet.sensors.sample import Sample, Wanted
from cadet.simulation.episode import request


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


def displacement(
    velocity: NDArray[np.float64], turn: NDArray[np.float64], pivot: NDArray[np.float64]
) -> NDArray[np.float64]:
    """Return the (4, 4) motion of a body whose pivot moves by `velocity` while it turns by the vector `turn`."""
    angle = float(np.linalg.norm(turn))
    x, y, z = turn / max(angle, 1e-300)
    cross = np.array([[0, -z, y], [z, 0, -x], [-y, x, 0]])
    moved = np.eye(4)
    moved[:3, :3] += np.sin(angle) * cross + (1 - np.cos(angle)) * cross @ cross
    moved[:3, 3] = pivot + velocity - moved[:3, :3] @ pivot
    return moved


@pytest.mark.parametrize("spin", ["cw", "ccw"])
def test_points_moved_back_by_their_times_are_what_single_rays_meet(street: cadet.Scene, spin: str) -> None:
    table = cadet.Lidar.hdl64e_uniform().beam_table()
    exact = replace(table, name="exact", range_noise_m=0.0, spin=spin, rate_hz=8.0, start_azimuth_deg=200.0)
    lidar = replace(cadet.Lidar.custom(exact), rolling=True)
    scan = street.scan(lidar)
    azimuth_deg = scan.column * 360.0 / table.num_columns
    sign = 1.0 if spin == "ccw" else -1.0
    turned = ((sign * (azimuth_deg - 200.0)) % 360.0 - (sign * -200.0) % 360.0) / 360.0
    np.testing.assert_allclose(scan.time_s, turned / 8.0, atol=1e-7)
    sample = Sample(street._native.capture(request(street._rig, 0, Wanted())), street._rig, {})
    world_from_velo, pivot = street.sensor_poses()["world_from_velo"], sample.world_from_ego[:3, 3]
    v, w = np.array(sample.ego_velocity_world), np.array(sample.ego_angular_velocity_world)
    picked = np.flatnonzero(scan.actor_id == 0)[::20]
    moves = np.array([displacement(v * t, w * t, pivot) for t in scan.time_s[picked].tolist()])
    then = moves @ world_from_velo
    origins_velo, directions_velo, ring, column = lidar.rays()
    beam = scan.ring[picked] * table.num_columns + scan.column[picked]
    np.testing.assert_array_equal(ring[beam], scan.ring[picked])
    origins = np.einsum("nij,nj->ni", then[:, :3, :3], origins_velo[beam]) + then[:, :3, 3]
    hits = street.cast_rays(origins, np.einsum("nij,nj->ni", then[:, :3, :3], directions_velo[beam]))
    # Windows return light or let it through: single rays know nothing of that; and actors move meanwhile.
    solid = (hits.actor_id == 0) & ~np.isin(scan.semantic[picked], [cadet.Semantic.BUILDING])
    assert solid.sum() > 1000
    assert (np.abs(hits.range_m - scan.range_m[picked])[solid] < 1e-4).mean() > 0.999
    points = np.einsum("nij,nj->ni", then[:, :3, :3], scan.points_velo[picked, :3].astype(float)) + then[:, :3, 3]
    apart = np.abs(np.linalg.norm(points - origins, axis=1) - scan.range_m[picked])
    assert apart.max() < 2e-3


def test_labels_of_a_turn_stand_where_its_points_are_and_fit_themselves(tmp_path: Path) -> None:
    rig = cadet.Rig.kitti()
    frames = []
    for lidar in (rig.lidar, replace(rig.lidar, rolling=True)):
        scene = cadet.Scene.empty(weather="clear_noon", rig=replace(rig, lidar=lidar))
        scene.move_ego(x_m=0.0, y_m=0.0, yaw_rad=0.0)
        scene.add("car", x_m=15.0, y_m=8.0, yaw_rad=-np.pi / 2, speed_mps=15.0, model_seed=1)
        scene.step(0.1)
        frames.append(scene.capture())
    still, turned = frames
    np.testing.assert_array_equal(still.image, turned.image)
    assert not np.array_equal(still.points_velo, turned.points_velo)
    cadet.kitti.write_frame(tmp_path, 0, turned)
    assert cadet.kitti.lint(tmp_path, strict=True) == []
    (before,), (after,) = still.labels, turned.labels
    x, _, z = before.location_cam
    # From the left the beam comes to the right, and the car with it; it is met before the image.
    late_s = 0.1 * np.arctan2(x, z) / (2 * np.pi)
    np.testing.assert_allclose(np.subtract(after.location_cam, before.location_cam), [15.0 * late_s, 0, 0], atol=0.02)
    assert late_s < -0.005


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


def test_dual_returns_are_the_strongest_and_the_last_together(street: cadet.Scene) -> None:
    def rows(returns: str) -> set[tuple[int, int, int, float]]:
        scan = street.scan(cadet.Lidar(returns=returns, divergence_mrad=3.0))
        return set(zip(*(values.tolist() for values in (scan.ring, scan.column, scan.echo, scan.range_m)), strict=True))

    strongest, last, first, dual, triple = map(rows, cadet.sensors.lidar.RETURN_MODES)
    assert dual == strongest | last and len(dual) > len(strongest) + 500
    # Where four quarters of a beam meet four surfaces, the weakest is left out.
    four = {(ring, column) for ring, column, echo, _ in last if echo == 4}
    triple, others = ({row for row in rows if row[:2] not in four} for rows in (triple, dual | first))
    assert triple >= others and {echo for _, _, echo, _ in triple} == {1, 2, 3} and len(four) < 50
    # A beam's echoes are numbered by range.
    echoes = sorted(triple)
    for (ring, column, echo, range_m), after in pairwise(echoes):
        assert after[:2] != (ring, column) or (after[2] == echo + 1 and after[3] > range_m)


def test_a_scan_tells_what_surfaces_returned_it(street: cadet.Scene) -> None:
    scan = street.scan(surfaces=True)
    plain = street.scan()
    assert plain.surfaces is None
    np.testing.assert_array_equal(scan.points_velo, plain.points_velo)
    surfaces = scan.surfaces
    assert surfaces is not None
    toward = -scan.points_velo[:, :3] / np.linalg.norm(scan.points_velo[:, :3], axis=1, keepdims=True)
    far = scan.range_m > 5.0
    # Points are seen from the sensor's origin, beams leave their lasers some centimeters from it.
    np.testing.assert_allclose((toward * surfaces.normal_velo).sum(axis=1)[far], surfaces.cos_incidence[far], atol=0.05)
    np.testing.assert_allclose(np.linalg.norm(surfaces.normal_velo, axis=1), 1.0, atol=1e-5)
    road = (scan.semantic == cadet.Semantic.ROAD) & (scan.range_m < 20.0)
    assert np.median(surfaces.normal_velo[road, 2]) > 0.998
    assert (surfaces.material[road] == cadet.MATERIALS.index("asphalt")).mean() > 0.9
    assert 0.1 < np.median(surfaces.reflectance[road]) < 0.4
    # What reads brighter is brighter: readings are compensated for range up to 18 m.
    bright = scan.points_velo[:, 3] > np.median(scan.points_velo[:, 3])
    near = scan.range_m < 18.0
    assert np.median(surfaces.reflectance[bright & near]) > 1.3 * np.median(surfaces.reflectance[~bright & near])


def test_what_the_air_returns_has_no_surface() -> None:
    scan = cadet.Scene.random(seed=4, weather="snow").scan(surfaces=True)
    in_air = scan.semantic == cadet.Semantic.SKY
    assert scan.surfaces is not None and in_air.sum() > 100
    assert (scan.surfaces.material[in_air] == -1).all() and np.isnan(scan.surfaces.normal_velo[in_air]).all()
    assert (scan.surfaces.material[~in_air] >= 0).all()
    with pytest.raises(cadet.CadetError, match="an ideal scan has none"):
        cadet.Scene.empty().scan(ideal=True, surfaces=True)
