"""One dataset with several of KITTI's calibrations: each frame is whole in the image size and matrices of its own."""

from __future__ import annotations

import json
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

import cadet
from cadet import ResetPolicy, Rig
from cadet.formats.kitti.from_sample import calibration_of
from cadet.generate import Settings, generate

NUM_EPISODES = 6


@pytest.fixture(scope="module")
def root(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """One frame an episode, all calibrations equally likely."""
    out = tmp_path_factory.mktemp("calibrations") / "out"
    rigs = tuple((rig, 1.0) for rig, _ in Rig.every_kitti())
    policy = replace(ResetPolicy.kitti(), samples_per_episode=1, rigs=rigs)
    generate(out, Settings(seed=2, num_frames=NUM_EPISODES, policy=policy), workers=1)
    return out


def test_frames_of_all_sizes_are_whole_and_can_be_drawn(root: Path, tmp_path: Path) -> None:
    frames = list(cadet.kitti.Dataset(root))
    rigs = {str((frame.meta or {})["rig"]): frame for frame in frames}
    assert len(rigs) >= 3, "the draws of this seed show too few"
    assert len({frame.image_size for frame in frames}) == len(rigs)
    assert cadet.kitti.lint(root, strict=True) == []
    cadet.view(frames, tmp_path / "overview.png")
    cadet.view(frames[1], tmp_path / "sheet.png")


def test_files_say_what_the_manifest_and_the_rig_say(root: Path) -> None:
    presets = {rig.name: rig for rig, _ in Rig.every_kitti()}
    manifest = json.loads((root / "manifest.json").read_text())
    assert manifest["rig"]["name"] == "kitti"
    assert manifest["other_rigs"] == {name: rig.sha256() for name, rig in presets.items() if name != "kitti"}
    policy = replace(ResetPolicy.kitti(), rigs=tuple((rig, 1.0) for rig in presets.values()))
    for episode, frame in enumerate(cadet.kitti.Dataset(root)):
        assert frame.meta is not None
        spec = policy.draw(2, episode)
        rig = presets[frame.meta["rig"]]
        assert rig == spec.rig
        assert frame.image_size == (rig.camera.width, rig.camera.height)
        expected = calibration_of(rig)
        np.testing.assert_array_equal(frame.calib.P2, expected.P2)
        np.testing.assert_array_equal(frame.calib.P3, expected.P3)
        np.testing.assert_array_equal(frame.calib.R0_rect, expected.R0_rect)
        np.testing.assert_array_equal(frame.calib.Tr_velo_to_cam, expected.Tr_velo_to_cam)
        # The LIDAR's x axis points down by the mount's pitch and the load's.
        pitch_deg = rig.velo_roll_pitch_yaw_deg[1] + spec.car_pitch_deg
        assert np.degrees(-np.arcsin(frame.meta["ego_from_velo"][2][0])) == pytest.approx(pitch_deg, abs=1e-9)


def test_a_policys_rig_goes_into_environments_and_scenes() -> None:
    env = cadet.Environment(policy="paper", weather="clear_noon")
    env.reset(seed=3)
    frame = env.step()
    scene_frame = cadet.Scene.random(seed=3, policy="paper", weather="clear_noon").capture()
    assert frame.meta is not None and frame.meta["rig"] == "paper"
    np.testing.assert_array_equal(frame.points_velo, scene_frame.points_velo)
    np.testing.assert_array_equal(frame.calib.P2[:, 3], 0.0)
    np.testing.assert_array_equal(frame.calib.R0_rect, np.eye(3))
    assert {label.type for label in frame.labels} <= {"Car", "Pedestrian", "DontCare"}
