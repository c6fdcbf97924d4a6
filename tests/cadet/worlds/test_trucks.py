"""Trucks, buses, trailers and motorbikes in the frames: labels about their points, and policies that leave them out."""

from __future__ import annotations

import numpy as np
import pytest

import cadet
from cadet.formats.kitti.boxes import points_in_boxes
from scans.sensed import objects_of, sense

LARGEST_HWL = {"Truck": (4.4, 3.1, 17.2), "Misc": (4.1, 2.8, 13.0)}
EXACT = cadet.SceneConfig(label=cadet.LabelConfig(boxes="exact"))
SEMANTIC = {"Truck": cadet.Semantic.TRUCK, "Misc": cadet.Semantic.OTHER_VEHICLE}


@pytest.mark.parametrize("kind", ["Truck", "Misc"])
def test_what_is_added_is_labeled_about_its_points(kind: str) -> None:
    models = set()
    for seed in range(8):
        scene = cadet.Scene.empty(config=EXACT)
        scene.move_ego(x_m=0.0, y_m=0.0, yaw_rad=0.0)
        scene.add(kind.lower(), x_m=24.0, y_m=2.0, yaw_rad=0.4 * seed, model_seed=seed)
        sensed = sense(scene)
        (label,) = sensed.frame.labels
        (meta,) = objects_of(sensed.frame)
        assert label.type == kind
        sizes = zip(label.dimensions_hwl, LARGEST_HWL[kind], strict=True)
        assert all(0.3 < size < most for size, most in sizes), label.dimensions_hwl
        cam_from_velo = sensed.frame.calib.cam_from_velo
        points = sensed.scan.points_velo[:, :3].astype(float) @ cam_from_velo[:3, :3].T + cam_from_velo[:3, 3]
        own = points[sensed.scan.actor_id == meta["actor_id"]]
        height, width, length = label.dimensions_hwl
        box = np.array([[*label.location_cam, length, width, height, label.rotation_y]])
        # Mirrors stick out.
        assert len(own) > 20 and points_in_boxes(own, box, 0.1).mean() > 0.96, (meta["model"], len(own))
        mine = sensed.frame.instance == meta["actor_id"]
        assert sensed.frame.semantic is not None and (sensed.frame.semantic[mine] == SEMANTIC[kind]).all()
        models.add(meta["model"])
    assert len(models) == 8


def test_the_papers_policy_has_neither() -> None:
    assert [district.vehicle_shares for district, _ in cadet.ResetPolicy.paper().districts] == [{"Car": 1.0}]
