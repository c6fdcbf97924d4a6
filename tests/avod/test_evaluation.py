"""What the packaged detector is worth with a sensor masked, and everything as JSON."""

from __future__ import annotations

import json
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
import torch
from click.testing import CliRunner

import avod
import cadet
from avod.cli.commands import avod as command
from avod.evaluate import ablation_table, analyze_detector, without
from cadet.errors import CadetError
from cadet.formats.kitti import Label, write_frame


@pytest.fixture(scope="module")
def frames() -> list[cadet.Frame]:
    environment = cadet.Environment()
    environment.reset(seed=100_003)
    return [environment.step() for _ in range(4)]


@pytest.fixture(scope="module")
def detector() -> avod.Detector:
    return avod.Detector("tiny_car")


def detect(detector: avod.Detector, frame: cadet.Frame, image: np.ndarray | None = None) -> tuple[Label, ...]:
    return detector.detect_frame(frame if image is None else replace(frame, image=image))


def test_a_masked_image_changes_nothing_whatever_it_shows(detector: avod.Detector, frames: list[cadet.Frame]) -> None:
    blind = without(detector, has_image=False, has_lidar=True)
    noise = np.random.default_rng(0).integers(0, 256, frames[0].image.shape, np.uint8)
    assert any(len(detect(blind, frame)) > 0 for frame in frames)
    for frame in frames:
        assert detect(blind, frame) == detect(blind, frame, noise)
    assert any(detect(detector, frame) != detect(detector, frame, noise) for frame in frames)
    assert any(detect(detector, frame) != detect(blind, frame) for frame in frames)


def test_masked_lidar_maps_change_nothing_whatever_they_hold(
    detector: avod.Detector, frames: list[cadet.Frame]
) -> None:
    from avod.data.build import build_sample

    deaf = without(detector, has_image=True, has_lidar=False)
    frame = frames[0]
    sample = build_sample(frame.points_velo, frame.image, frame.calib, frame.plane, detector.config)
    empty = replace(sample, bev=sample.bev * 0.0)
    (masked, nothing), (seen, unseen) = ([d.run([s])[0] for s in (sample, empty)] for d in (deaf, detector))
    # What the first stage says of its anchors; how high proposals stand is still measured by the LIDAR.
    assert torch.equal(masked.anchor_logits, nothing.anchor_logits)
    assert torch.equal(masked.anchor_offsets, nothing.anchor_offsets)
    assert not torch.equal(seen.anchor_logits, unseen.anchor_logits)


def test_masking_leaves_the_detector_as_it_was(detector: avod.Detector, frames: list[cadet.Frame]) -> None:
    before, config = detect(detector, frames[0]), detector.network.config
    blind = without(detector, has_image=False, has_lidar=True)
    # One network, which both only read: what a detector is told to do differently is not written into it.
    blind.configure({"detection": {"min_score": 0.9}, "rpn": {"proposals": 3}})
    assert blind.network is detector.network and detector.network.config is config
    assert detect(detector, frames[0]) == before != detect(blind, frames[0])
    with pytest.raises(CadetError, match="nothing to detect in"):
        without(detector, has_image=False, has_lidar=False)


def test_the_command_writes_everything_as_json(
    detector: avod.Detector, frames: list[cadet.Frame], tmp_path: Path
) -> None:
    frames = frames[:2]
    for number, frame in enumerate(frames):
        write_frame(tmp_path, number, frame, split="val")
    arguments = ["eval", "--checkpoint", "tiny_car", "--data", str(tmp_path)]
    result = CliRunner().invoke(command, [*arguments, "--ablate", "--json"], catch_exceptions=False)
    data = json.loads(result.stdout)
    ids = tuple(f"{number:06d}" for number in range(len(frames)))
    analysis = analyze_detector(detector, tmp_path, ids, parts=("errors", "centers"))
    assert data["errors"] == json.loads(analysis.to_json())["errors"]
    assert {"operating_points", "by", "confusion", "centers", "curves"} <= set(data)
    assert list(data["ablation"]) == ["both", "image masked", "LIDAR masked"]
    assert data["ablation"]["both"] == {"ap": data["ap"], "centers": data["centers"]}
    shown = CliRunner().invoke(command, [*arguments, "--ablate", "--details"], catch_exceptions=False).stdout
    masked = ablation_table({"both": analysis}, ("Car",))
    assert [line.split() for line in shown.splitlines() if line.lstrip().startswith("both ")] == [
        " ".join(masked.rows[1]).split()
    ]
    for text in ("image masked ", "LIDAR masked ", "AP by occlusion", "Car: found minus true"):
        assert text in shown
