"""The detector that comes with the package, on worlds that it was not trained on."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
from click.testing import CliRunner

import avod
import cadet
from avod.cli.commands import avod as command
from avod.config import Config
from avod.train.checkpoint import packaged_checkpoints
from cadet.errors import MissingFileError
from cadet.evaluation import box_iou_3d
from cadet.formats.kitti import labels_from_text, write_frame

_NAMES = ("center_all", "tiny_car")
_SEEDS = range(100_001, 100_011)


@pytest.fixture(scope="module")
def frames() -> list[cadet.Frame]:
    """Drive for eight frames through each of ten worlds."""
    driven = []
    for seed in _SEEDS:
        environment = cadet.Environment()
        environment.reset(seed=seed)
        driven += [environment.step() for _ in range(8)]
    return driven


@pytest.mark.parametrize("name", _NAMES)
def test_every_packaged_checkpoint_loads_and_is_small(name: str) -> None:
    assert packaged_checkpoints() == _NAMES
    detector = avod.Detector(name)
    assert detector.config == Config.named(name)
    folder = Path(avod.__file__).parent / "checkpoints" / name
    assert sorted(path.name for path in folder.iterdir()) == ["checkpoint.json", "model.safetensors"]
    assert sum(path.stat().st_size for path in folder.iterdir()) < 5_000_000


@pytest.mark.parametrize("name", _NAMES)
def test_it_finds_the_cars_that_are_plain_to_see(frames: list[cadet.Frame], name: str) -> None:
    detector = avod.Detector(name)
    num_plain = num_found = num_wrong = 0
    for frame in frames:
        found = detector.detect_frame(frame)
        sure = [label for label in found if label.type == "Car" and (label.score or 0.0) > 0.5]
        cars = [label for label in frame.labels if label.type in ("Car", "Van")]
        overlap = box_iou_3d(boxes_of(sure), boxes_of(cars))
        plain = [k for k, car in enumerate(cars) if car.type == "Car" and is_plain(car)]
        num_plain += len(plain)
        num_found += sum(bool((overlap[:, k] > 0.5).any()) for k in plain)
        num_wrong += sum(not bool((row > 0.1).any()) for row in overlap)
    assert num_plain >= 20
    assert num_found >= 0.6 * num_plain
    # Cars that are hidden too well for a label count as wrong, too.
    assert num_wrong <= 0.25 * len(frames)


def test_it_works_by_name_from_the_command_line(frames: list[cadet.Frame], tmp_path: Path) -> None:
    frame = max(frames, key=lambda frame: sum(label.type == "Car" and is_plain(label) for label in frame.labels))
    write_frame(tmp_path, 7, frame)
    arguments = ["predict", "--checkpoint", "tiny_car", "--data", str(tmp_path), "--out", str(tmp_path / "found")]
    result = CliRunner().invoke(command, arguments, catch_exceptions=False)
    assert result.exit_code == 0, result.output
    detected = avod.Detector("tiny_car").detect_frame(frame)
    written = labels_from_text((tmp_path / "found" / "000007.txt").read_text())
    assert len(written) == len(detected) > 0


def test_an_unknown_name_lists_what_there_is() -> None:
    with pytest.raises(
        MissingFileError, match=r"^tiny_cra: not a checkpoint: expected a folder .*, or one of center_all, tiny_car$"
    ):
        avod.Detector("tiny_cra")


def boxes_of(labels: list[cadet.kitti.Label]) -> np.ndarray:
    return np.array([label.box_cam for label in labels]).reshape(-1, 7)


def is_plain(car: cadet.kitti.Label) -> bool:
    """Whether it is as KITTI's Easy demands, and within the detector's reach."""
    return car.bbox[3] - car.bbox[1] >= 40 and car.occluded == 0 and car.truncated <= 0.15
