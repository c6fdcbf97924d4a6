"""A user's meshes of people and cyclists: labeled, seen by both sensors, and inside their boxes."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

import cadet
from cadet.formats.kitti.boxes import points_in_boxes
from mesh_files.obj_meshes import CAR, Block, assets_folder, obj_of
from scans.sensed import objects_of, sense

SIZES_LWH = {"Pedestrian": (0.4, 0.6, 1.8), "Person_sitting": (0.8, 0.6, 1.3), "Cyclist": (1.8, 0.6, 1.7)}


def people_folder(root: Path, more: str = "") -> Path:
    """Write a folder with somebody of each class: legs or wheels, and a trunk as large as the box."""
    text = more
    for kind in SIZES_LWH:
        text += f'[[actor]]\nname = "own-{kind}"\nclass = "{kind}"\nmesh = "meshes/{kind}.obj"\n'
    folder = assets_folder(root, text)
    for kind, (length, width, height) in SIZES_LWH.items():
        x, y = length / 2, width / 2
        blocks: list[Block] = [
            ("Tyre", (-x, -0.05, 0.0), (x, 0.05, 0.7)),
            ("Body", (-x, -y, 0.7), (x, y, height)),
        ]
        (folder / "meshes" / f"{kind}.obj").write_text(obj_of(blocks))
    return folder


@pytest.mark.parametrize("boxes", ["kitti", "exact"])
def test_people_of_meshes_are_labeled_and_their_points_lie_in_their_boxes(boxes: str, tmp_path: Path) -> None:
    config = cadet.SceneConfig(label=cadet.LabelConfig(boxes=boxes))  # type: ignore[arg-type]
    scene = cadet.Scene.empty(weather="clear_noon", config=config, assets=people_folder(tmp_path / "own"))
    scene.move_ego(x_m=0.0, y_m=0.0, yaw_rad=0.0)
    ids = {
        scene.add(kind, x_m=9.0 + k, y_m=3.0 - 3.0 * k, yaw_rad=0.5, model=f"own-{kind}"): kind
        for k, kind in enumerate(SIZES_LWH)
    }
    sensed = sense(scene)
    frame, scan = sensed.frame, sensed.scan
    assert frame.semantic is not None and frame.instance is not None
    cam_from_velo = frame.calib.cam_from_velo
    points_cam = scan.points_velo[:, :3].astype(float) @ cam_from_velo[:3, :3].T + cam_from_velo[:3, 3]
    found = set()
    for label, meta in zip(frame.labels, objects_of(frame), strict=True):
        if label.type == "DontCare":
            continue
        actor = meta["actor_id"]
        kind = ids[actor]
        assert (label.type, meta["model"], label.occluded) == (kind, f"own-{kind}", 0)
        length, width, height = SIZES_LWH[kind]
        assert meta["dimensions_hwl"] == pytest.approx((height, width, length), abs=1e-3)
        semantic = cadet.Semantic.CYCLIST if kind == "Cyclist" else cadet.Semantic.PERSON
        pixels = frame.semantic[frame.instance == actor]
        assert len(pixels) > 500 and (pixels == semantic).all()
        own = scan.actor_id == actor
        h, w, l = label.dimensions_hwl
        box = np.array([[*label.location_cam, l, w, h, label.rotation_y]])
        # Lasers measure up to 6 cm too short or too long.
        assert own.sum() > 100 and points_in_boxes(points_cam[own], box, 0.1).mean() > 0.98
        # Of a person who is built in it is 0.37; tires, below the trunk, are darker.
        trunk = own & (points_cam[:, 1] < label.location_cam[1] - 0.7)
        assert 0.3 < np.median(scan.points_velo[trunk, 3]) < 0.45
        found.add(kind)
    assert found == set(SIZES_LWH)


def test_people_of_meshes_move_as_the_user_wants_and_join_no_traffic(tmp_path: Path) -> None:
    own = cadet.Assets.read(people_folder(tmp_path / "own", f"share = 1.0\n{CAR}"))
    assert [actor.type for actor in own.actors] == ["Car", *SIZES_LWH]
    town = cadet.Scene.random(seed=2, assets=own)
    assert {agent.model for agent in town.agents if agent.type in SIZES_LWH}.isdisjoint(f"own-{k}" for k in SIZES_LWH)
    assert "mine" in {agent.model for agent in town.agents}

    scene = cadet.Scene.empty(assets=cadet.Assets(tuple(actor for actor in own.actors if actor.type != "Car")))
    scene.move_ego(x_m=-40.0, y_m=0.0)
    scene.add("pedestrian", x_m=9.0, y_m=3.0, yaw_rad=0.0, speed_mps=1.5, model="own-Pedestrian")
    scene.add("cyclist", path=[(0.0, 0.0, -6.0), (4.0, 0.0, 14.0)], model="own-Cyclist")
    scene.step(2.0)
    assert [agent.position_world for agent in scene.agents] == [
        pytest.approx((12.0, 3.0, 0.0), abs=1e-6),
        pytest.approx((0.0, 4.0, 0.0), abs=1e-6),
    ]
    with pytest.raises(cadet.CadetError, match=r"model .own-Cyclist. is a Cyclist, not a Pedestrian"):
        scene.add("pedestrian", x_m=20.0, y_m=0.0, model="own-Cyclist")
