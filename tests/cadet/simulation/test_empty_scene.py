"""The square of `Scene.empty`: level everywhere, and a road that one sees."""

from __future__ import annotations

import numpy as np

import cadet


def test_the_empty_scene_shows_a_road_with_lines_between_lawns() -> None:
    scene = cadet.Scene.empty(weather="cloudy_noon")
    frame, scan = scene.capture(), scene.scan(ideal=True)
    assert frame.meta is not None and frame.semantic is not None
    points_velo = scan.points_velo[np.isfinite(scan.range_m), :3].astype(float)
    world_from_velo = np.array(frame.meta["world_from_ego"]) @ np.array(frame.meta["ego_from_velo"])
    points_world = points_velo @ world_from_velo[:3, :3].T + world_from_velo[:3, 3]
    assert np.abs(points_world[:, 2]).max() < 1e-3
    points_cam = frame.calib.points_cam_from_velo(points_velo)
    height, width = frame.semantic.shape
    seen = cadet.kitti.points_in_image(points_cam, frame.calib, (width - 1, height - 1)) & (points_world[:, 0] < 30)
    u, v = np.rint(frame.calib.project(points_cam[seen])).astype(int).T
    kind, color = frame.semantic[v, u], frame.image[v, u].astype(float)
    # Two lanes of 3.5 m, the ego in the right one; lines at both edges and between the lanes.
    y_m = points_world[seen, 1]
    lawn = (y_m < -2.5) | (y_m > 6.0)
    edge = np.minimum(np.abs(y_m + 1.75), np.abs(y_m - 5.25))
    middle = np.abs(y_m - 1.75)
    lanes = (y_m > -1.75) & (y_m < 5.25) & (edge > 0.3) & (middle > 0.3)
    assert lawn.sum() > 1000 and lanes.sum() > 1000
    assert (kind[lawn] == cadet.Semantic.TERRAIN).all()
    assert (kind[lanes] == cadet.Semantic.ROAD).all()
    assert (kind[edge < 0.03] == cadet.Semantic.ROAD_MARKING).mean() > 0.9
    assert 0.2 < (kind[middle < 0.03] == cadet.Semantic.ROAD_MARKING).mean() < 0.5, "dashes of 3 m, gaps of 6 m"
    asphalt, grass, paint = (color[at].mean(axis=0) for at in (lanes, lawn, edge < 0.03))
    assert grass[1] > 1.2 * grass[0] and grass[1] > 1.2 * grass[2], "lawns are green"
    # An overcast sky is bluer than the sun, to which the camera is balanced.
    assert paint.mean() > 2 * asphalt.mean() and np.ptp(asphalt) < 0.3 * asphalt.mean()
    assert asphalt[0] < asphalt[1] < asphalt[2]


def test_an_ego_that_stands_from_the_start_rests_on_its_springs() -> None:
    """A body that rapier has dropped keeps the velocity that its springs give it."""
    scene = cadet.Scene.empty()
    scene.step(1.0)
    sample = scene.capture().sample
    assert sample is not None
    assert np.abs(sample.ego_velocity_world).max() < 0.002
    assert np.abs(sample.world_from_ego[:3, 3]).max() < 0.001
