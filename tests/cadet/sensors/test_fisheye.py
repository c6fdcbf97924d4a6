"""The equidistant fisheye against rays that are cast at f times their angle, and where it does not fit."""

from __future__ import annotations

import math
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from numpy.typing import NDArray

import cadet
from cadet import Camera, MountedCamera, Pose, Rig, Scene
from cadet.generate import Settings, generate
from cadet.sensors.sample import MORE_MAPS, Maps

SIDE = 300
LENS = Camera.fisheye(SIDE, SIDE)
POSE = Pose.of_camera((0.5, 0.9, 1.1), yaw_deg=70, pitch_deg=15)
FISH = MountedCamera(name="fish", camera=LENS, pose=POSE)


def directions() -> tuple[NDArray[np.float64], NDArray[np.float64]]:
    """Return (H, W, 3) unit vectors of the pixels in the camera's frame, and (H, W) angles to its axis."""
    v, u = (places - (SIDE - 1) / 2 for places in np.mgrid[:SIDE, :SIDE])
    radius = np.hypot(u, v)
    angle = radius * math.radians(190.0) / SIDE
    sideways = np.sin(angle) / np.maximum(radius, 1e-9)
    return np.stack([u * sideways, v * sideways, np.cos(angle)], axis=-1), angle


@pytest.fixture(scope="module")
def street() -> Scene:
    scene = Scene.random(seed=11, weather="clear_noon", rig=Rig.kitti().with_sensors(FISH))
    scene.step(2.0)
    return scene


def maps_of(frame: cadet.Frame) -> Maps:
    assert frame.sample is not None
    maps = frame.sample.maps("fish")
    assert maps is not None
    return maps


def test_what_lies_at_an_angle_is_seen_at_f_times_it(street: Scene) -> None:
    frame = street.capture(more_maps=["normals"])
    maps, (rays, angle) = maps_of(frame), directions()
    assert frame.sample is not None and maps.normals is not None
    pose = frame.sample.world_from_ego @ frame.sample.rig.ego_from_sensor("fish")
    inside = angle < math.radians(94.5)
    v, u = (places[::29] for places in np.nonzero(inside))
    hits = street.cast_rays(np.tile(pose[:3, 3], (len(v), 1)), rays[v, u] @ pose[:3, :3].T)
    depth = maps.depth[v, u].astype(np.float64)
    is_hit = np.isfinite(hits.range_m) & np.isfinite(depth)
    assert is_hit.mean() < 0.9 and (np.isfinite(hits.range_m) == np.isfinite(depth)).mean() > 0.97
    off = np.full(len(v), np.inf)
    off[is_hit] = np.abs(depth[is_hit] / hits.range_m[is_hit] - 1.0)
    # The nearest sample of a cube's side lies up to half a pixel beside the ray.
    assert is_hit.sum() > 1000 and np.median(off[is_hit]) < 0.003 and (off[is_hit] < 0.05).mean() > 0.9
    for low, high in ((0, 40), (50, 80), (86, 95)):
        ring = is_hit & (np.degrees(angle[v, u]) >= low) & (np.degrees(angle[v, u]) < high)
        assert ring.sum() > 50
        assert (off[ring] < 0.05).mean() > 0.85, (low, high)
        assert (maps.instance[v, u] == hits.actor_id)[ring].mean() > 0.95
        same = ring & (off < 0.002)
        turned = maps.normals[v, u][same] @ pose[:3, :3].T
        assert (np.abs(turned - hits.normal_world[same]).max(axis=1) < 1e-3).mean() > 0.9


def test_the_image_ends_at_95_degrees(street: Scene) -> None:
    frame = street.capture(more_maps=["radiance"])
    maps, (_, angle) = maps_of(frame), directions()
    beyond = angle > math.radians(95.0)
    assert beyond.mean() == pytest.approx(1 - math.pi / 4, abs=0.01)
    assert (
        (maps.instance[beyond] == -1).all()
        and np.isinf(maps.depth[beyond]).all()
        and (maps.semantic[beyond] == 0).all()
    )
    assert maps.radiance is not None
    image = frame.images["fish"]
    # Light that the lens scatters, and noise.
    assert image[beyond].mean() < 8 and image[~beyond].mean() > 50
    assert (maps.radiance[~beyond] > 0.0).all()


def test_flow_is_that_of_the_motion_by_the_closed_form(street: Scene) -> None:
    flow_s = 1 / 60
    maps, (rays, angle) = maps_of(street.capture(more_maps=MORE_MAPS, flow_s=flow_s)), directions()
    ego_now = street.capture().sample
    street.step(flow_s)
    ego_then = street.capture().sample
    assert ego_now is not None and ego_then is not None and maps.optical_flow is not None
    ego_from_fish = ego_now.rig.ego_from_sensor("fish")
    then_from_now = np.linalg.inv(ego_then.world_from_ego @ ego_from_fish) @ ego_now.world_from_ego @ ego_from_fish
    is_static = (maps.instance == 0) & (angle < math.radians(90.0)) & (maps.depth > 1.5)
    points = rays[is_static] * maps.depth[is_static][:, None]
    moved = points @ then_from_now[:3, :3].T + then_from_now[:3, 3]
    across = np.hypot(moved[:, 0], moved[:, 1])
    radius = np.arctan2(across, moved[:, 2]) * SIDE / math.radians(190.0)
    pixel = moved[:, :2] * (radius / across)[:, None]
    v, u = (places[is_static] - (SIDE - 1) / 2 for places in np.mgrid[:SIDE, :SIDE])
    flow = maps.optical_flow[is_static]
    assert np.percentile(np.abs(flow).max(axis=1), 90) > 0.5
    assert np.percentile(np.abs(flow - (pixel - np.c_[u, v])), 95) < 0.05


def test_labels_of_a_fisheye_are_round_what_it_sees_and_where_the_others_have_it() -> None:
    """Beside the instances of its own maps, and the labels of the pinhole camera."""
    # Boxes are upright in the camera's frame: those of a camera that looks down would lean.
    level = replace(FISH, pose=Pose.of_camera((0.5, 0.9, 1.1), yaw_deg=70))
    exact = cadet.SceneConfig(label=cadet.LabelConfig(boxes="exact"))
    scene = Scene.empty(rig=Rig.kitti().with_sensors(level), config=exact)
    scene.move_ego(x_m=0.0, y_m=0.0, yaw_rad=0.0)
    # Ahead, to the left, and behind: on several sides of the cube.
    for x_m, y_m in ((12.0, 3.5), (1.0, 7.0), (-5.0, 9.0), (16.0, 9.0)):
        scene.add("car", x_m=x_m, y_m=y_m, yaw_rad=0.4)
    frame = scene.capture()
    assert frame.sample is not None
    maps, seen = maps_of(frame), frame.sample._sightings("fish")
    assert seen is not None
    labels = [one for one in seen if one.is_labeled]
    assert len(labels) >= 3
    for one in labels:
        v, u = np.nonzero(maps.instance == one.actor_id)
        left, top, right, bottom = one.bbox
        assert left - 1.5 < u.min() and u.max() < right + 1.5 and top - 1.5 < v.min() and v.max() < bottom + 1.5
        # A box round a box is wider than the car in it.
        assert (u.max() - u.min()) * (v.max() - v.min()) > 0.55 * (right - left) * (bottom - top)
        assert one.occlusion_level == 0 and one.visible_fraction > 0.8
    # The same middles in the world as the pinhole camera's.
    world_from_ego = frame.sample.world_from_ego

    def middles(camera: str | None) -> dict[int, NDArray[np.float64]]:
        assert frame.sample is not None
        pose = world_from_ego @ frame.sample.rig.ego_from_sensor(camera or "image_2")
        found = frame.sample._sightings(camera)
        assert found is not None
        up = {one.actor_id: np.array(one.location_cam) - (0.0, one.size_lwh[2] / 2, 0.0) for one in found}
        return {actor: pose[:3, :3] @ at + pose[:3, 3] for actor, at in up.items()}

    of_fish, of_pinhole = middles("fish"), middles(None)
    both = of_fish.keys() & of_pinhole.keys()
    assert len(both) >= 2
    for actor in both:
        np.testing.assert_allclose(of_fish[actor], of_pinhole[actor], atol=1e-6)


def test_what_stands_before_an_actor_hides_it_from_a_fisheye() -> None:
    def fraction(others: tuple[tuple[float, float], ...]) -> float:
        scene = Scene.empty(rig=Rig.kitti().with_sensors(FISH))
        scene.move_ego(x_m=0.0, y_m=0.0, yaw_rad=0.0)
        car = scene.add("car", x_m=1.0, y_m=14.0, yaw_rad=0.0)
        for x_m, y_m in others:
            scene.add("car", x_m=x_m, y_m=y_m, yaw_rad=0.0)
        sample = scene.capture().sample
        assert sample is not None
        found = sample._sightings("fish")
        assert found is not None
        return next((one.visible_fraction for one in found if one.actor_id == car), 0.0)

    assert fraction(()) > 0.99
    assert 0.1 < fraction(((3.0, 7.0),)) < 0.9


def test_a_fisheye_has_images_maps_and_labels_in_a_folder(street: Scene, tmp_path: Path) -> None:
    frame = street.capture()
    assert "fish" in frame.images and list(frame.camera_labels) == ["image_2", "fish"]
    of = Rig.kitti().with_image_size(310, 94).with_sensors(FISH)
    policy = cadet.ResetPolicy.kitti().with_rig(of)
    generate(tmp_path / "out", Settings(seed=1, num_frames=1, policy=policy, write=("cameras", "depth")), workers=1)
    folder = tmp_path / "out" / "training" / "cameras" / "fish"
    assert sorted(path.name for path in folder.iterdir()) == ["depth", "image_2", "label_2"]
    assert cadet.kitti.lint(tmp_path / "out") == []
    (folder / "depth" / "000000.png").write_bytes((folder / "image_2" / "000000.png").read_bytes())
    found = {(one.file, one.rule) for one in cadet.kitti.lint(tmp_path / "out")}
    assert found == {("cameras/fish/depth/000000.png", "damaged-file")}


def test_where_a_fisheye_does_not_fit_it_is_refused(tmp_path: Path) -> None:
    with pytest.raises(cadet.CadetError, match=r"Rig.camera: expected a pinhole camera, which"):
        Rig(camera=LENS)
    for name, value in (
        ("rolling_shutter_s", 0.01),
        ("motion_blur_s", 0.01),
        ("distortion", (0.1, 0.0, 0.0, 0.0, 0.0)),
    ):
        options: dict[str, Any] = {name: value}
        with pytest.raises(cadet.CadetError, match=f"Camera.{name}: a fisheye has none"):
            replace(LENS, **options)
    with pytest.raises(cadet.CadetError, match=r"Camera.model: expected pinhole or fisheye, got 'wide'"):
        replace(LENS, model="wide")
    with pytest.raises(cadet.CadetError, match=r"Camera.fov_deg: expected a number from 1 to 190, got 200"):
        Camera.fisheye(640, 480, fov_deg=200)
    policy = cadet.ResetPolicy.kitti().with_rig(Rig.nuscenes().with_sensors(FISH)).as_sequence()
    with pytest.raises(
        cadet.CadetError, match="cannot write the sensor 'fish' of the rig nuscenes: nuScenes has no fish"
    ):
        Settings(policy=policy, format="nuscenes")
    of = Rig.kitti().with_sensors(FISH)
    (tmp_path / "rig.toml").write_text(of.to_toml())
    assert Rig.read(tmp_path / "rig.toml") == of and 'model = "fisheye"' in of.to_toml()
    assert of.to_dict()["more"]["fish"]["camera"]["model"] == "fisheye"
