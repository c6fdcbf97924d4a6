"""Episodes whose samples follow each other by time."""

from __future__ import annotations

import itertools
from collections import Counter
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

import cadet
from cadet.cli import run_cadet_gen
from cadet.generate import EXPORTERS, Settings, Summary, generate

SMALL = cadet.Rig(camera=cadet.Camera.kitti().resized(310, 94), lidar=cadet.Lidar.vlp16())


def test_samples_are_a_time_step_apart_and_agents_drive_on_between_them() -> None:
    policy = cadet.ResetPolicy.kitti().with_rig(SMALL).as_sequence(hz=10, length_s=1.0)
    assert policy.samples_per_episode == 10
    env = cadet.Environment(policy=policy)
    env.reset(seed=2)
    frames = [env.step() for _ in range(11)]
    assert env.episode == 1
    times = [frame.meta["time_s"] for frame in frames[:10] if frame.meta is not None]
    np.testing.assert_allclose(np.diff(times), 0.1, atol=1e-9)
    assert any(label.type != "DontCare" for label in frames[0].labels)
    moved = 0
    for before, after in itertools.pairwise(frames[:10]):
        places = {agent.id: agent for agent in after.agents}
        for agent in before.agents:
            if agent.id in places and agent.speed_mps > 3.0:
                step = places[agent.id].world_from_agent[:2, 3] - agent.world_from_agent[:2, 3]
                # By its velocity, to what a driver changes it by in a tenth of a second.
                np.testing.assert_allclose(step, np.array(agent.velocity_world[:2]) * 0.1, atol=0.08)
                moved += 1
    assert moved > 10


@pytest.mark.parametrize("dataset_format", EXPORTERS)
def test_formats_of_sequences_imply_one(dataset_format: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    given: list[Settings] = []

    def note(root: Path, settings: Settings, **_: object) -> Summary:
        given.append(settings)
        return Summary(1, 0, Counter())

    monkeypatch.setattr("cadet.cli.gen.generate", note)
    is_sequence = dataset_format in ("nuscenes", "kitti_tracking", "kitti_raw", "mcap")
    options = ["--hz", "10", "--length-s", "3"] if is_sequence else []
    monkeypatch.setattr("sys.argv", ["cadet-gen", str(tmp_path / "out"), "--format", dataset_format, *options])
    with pytest.raises(SystemExit) as ended:
        run_cadet_gen()
    assert ended.value.code == 0
    assert (given[0].policy.time_step_s, given[0].policy.samples_per_episode) == (
        (0.1, 30) if is_sequence else (None, 20)
    )


def test_kitti_folders_hold_sequences_too(tmp_path: Path) -> None:
    policy = cadet.ResetPolicy.kitti().with_rig(SMALL).as_sequence(hz=2, length_s=2)
    generate(tmp_path / "out", Settings(seed=5, num_frames=6, policy=policy), workers=1)
    frames = list(cadet.kitti.Dataset(tmp_path / "out"))
    metas = [frame.meta or {} for frame in frames]
    assert [(meta["episode"], meta["sample"]) for meta in metas] == [(0, 0), (0, 1), (0, 2), (0, 3), (1, 0), (1, 1)]
    assert np.diff([meta["time_s"] for meta in metas])[[0, 1, 2, 4]] == pytest.approx(0.5)
    assert cadet.kitti.lint(tmp_path / "out", strict=True) == []


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        (["--hz", "7", "--length-s", "3"], "--hz: expected a rate that divides the 60 steps of a second, got 7"),
        (["--length-s", "0.2"], "--length-s: expected at least 0.5 s for a sample, got 0.2"),
        (["--length-s", "long"], "Invalid value for '--length-s': 'long' is not a valid float."),
    ],
)
def test_rates_and_lengths_are_checked(
    arguments: list[str],
    message: str,
    tmp_path: Path,
    capsys: pytest.CaptureFixture[str],
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    monkeypatch.setattr("sys.argv", ["cadet-gen", str(tmp_path / "out"), *arguments])
    with pytest.raises(SystemExit) as ended:
        run_cadet_gen()
    assert ended.value.code == 2
    assert message in capsys.readouterr().err
    assert not (tmp_path / "out").exists()


def test_steps_that_physics_cannot_take_are_refused() -> None:
    with pytest.raises(cadet.CadetError, match=r"expected whole steps of 1/60 s, got 0\.11"):
        replace(cadet.ResetPolicy.kitti(), time_step_s=0.11)
