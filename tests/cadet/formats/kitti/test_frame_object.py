from __future__ import annotations

import copy
from dataclasses import replace
from typing import Any

import numpy as np
import pytest

import cadet
from cadet import CadetError, Frame, kitti
from synthetic import make_frame


@pytest.fixture(scope="module")
def generated() -> tuple[Frame, dict[int, cadet.Agent]]:
    """Capture a car that drives, one that it hides, and the agents as the scene itself knows them."""
    scene = cadet.Scene.empty(config=cadet.SceneConfig(label=cadet.LabelConfig(boxes="exact")))
    scene.add("car", x_m=16.0, y_m=1.0, yaw_rad=0.5, speed_mps=3.0)
    scene.add("car", x_m=24.0, y_m=0.5, yaw_rad=1.5)
    scene.add("pedestrian", x_m=60.0, y_m=14.0)
    scene.step(0.5)
    return scene.capture(), {agent.id: agent for agent in scene.agents}


def test_objects_are_what_the_scene_knows_of_them(generated: tuple[Frame, dict[int, cadet.Agent]]) -> None:
    frame, agents = generated
    objects = frame.objects
    assert tuple(one.label for one in objects) == frame.labels
    assert len(objects) == 3 and {one.id for one in objects} == set(agents)
    world_from_cam = np.linalg.inv(frame.calib.cam_from_velo)
    assert frame.meta is not None
    world_from_cam = np.array(frame.meta["world_from_ego"]) @ np.array(frame.meta["ego_from_velo"]) @ world_from_cam
    for one in objects:
        assert one.id is not None and one.visible_fraction is not None and frame.instance is not None
        agent = agents[one.id]
        assert (one.type, one.model) == (agent.type, agent.model)
        assert one.velocity_world == pytest.approx(agent.velocity_world, abs=1e-5)
        place_world = world_from_cam @ [*one.box_cam[:3], 1.0]
        assert place_world[:3] == pytest.approx(agent.position_world, abs=0.02)
        assert one.box_cam[3:6] == pytest.approx(agent.size_lwh, abs=1e-5)
        assert 0.0 < one.visible_fraction <= 1.0
        assert (frame.instance == one.id).any()
    fractions = [one.visible_fraction or 0.0 for one in sorted(objects, key=lambda one: one.id or 0)]
    assert fractions[0] > 0.9 > fractions[1], "the second stands behind the first"
    (driving,) = [one.velocity_world for one in objects if one.id == 1]
    assert driving is not None and np.hypot(*driving[:2]) == pytest.approx(3.0, abs=0.01)


def test_an_object_without_a_label_keeps_its_class(generated: tuple[Frame, dict[int, cadet.Agent]]) -> None:
    frame, _ = generated
    regions = [kitti.Label.in_image("DontCare", label.bbox) for label in frame.labels]
    found = replace(frame, labels=tuple(regions)).objects
    assert [one.type for one in found] == [one.type for one in frame.objects]
    assert not any(one.is_labeled for one in found)


def test_of_kittis_own_frames_only_the_label_is_known() -> None:
    frame = make_frame(meta=None)
    found = frame.objects
    assert [one.label for one in found] == [label for label in frame.labels if not label.is_dont_care]
    np.testing.assert_array_equal([one.box_cam for one in found], [one.label.box_cam for one in found])
    assert all(one.is_labeled and (one.id, one.velocity_world, one.num_points) == (None,) * 3 for one in found)


def _changed(meta: dict[str, Any], name: str, value: object) -> dict[str, Any]:
    changed = copy.deepcopy(meta)
    changed["objects"][1][name] = value
    return changed


@pytest.mark.parametrize(
    ("name", "value", "message"),
    [
        ("velocity_world", [1.0, 2.0], r"velocity_world: expected 3 numbers, got \[1.0, 2.0\]"),
        ("velocity_world", [1.0, 2.0, "3"], "velocity_world: expected 3 numbers"),
        ("num_points", None, "num_points: expected a number, got None"),
        ("type", 3, "type: expected a string, got 3"),
    ],
)
def test_what_is_wrong_in_a_meta_is_named(
    generated: tuple[Frame, dict[int, cadet.Agent]], name: str, value: object, message: str
) -> None:
    frame, _ = generated
    assert frame.meta is not None
    with pytest.raises(CadetError, match=rf"^meta\.objects\[1\]\.{message}"):
        _ = replace(frame, meta=_changed(frame.meta, name, value)).objects


def test_labels_that_were_filtered_are_no_longer_the_metas(generated: tuple[Frame, dict[int, cadet.Agent]]) -> None:
    frame, _ = generated
    with pytest.raises(CadetError, match=r"^objects: 1 labels, and 3 in meta: filter frame\.objects"):
        _ = replace(frame, labels=frame.labels[:1]).objects
