"""Short trainings for tests: every augmentation and every draw, on a network that is small enough."""

from __future__ import annotations

import dataclasses
from pathlib import Path
from typing import Any

import numpy as np
import torch
from numpy.typing import NDArray

from avod import Detector
from avod.config import Config
from avod.data.mixture import Folders
from avod.model.avod.network import AvodNetwork
from avod.model.layers import ShiftBatchNorm
from avod.train import Run, train, with_steps
from avod.train.checkpoint import load_network, read_checkpoint
from avod.train.log import read_log
from cadet.evaluation import box_iou_3d
from cadet.formats.kitti import Frame, Label, write_frame
from synthetic import make_frame

BASE = Path(__file__).parent / "overfit.toml"
TEXT = f"""base = "{BASE}"

[bev]
x_m = [-6.4, 6.4]
z_m = [6.4, 25.6]

[image]
size = [152, 48]

[second_stage]
dropout_keep = 0.5
hidden = [32]

[training]
steps = 8
flip = true
pca_jitter = true
checkpoint_steps = 3

[detection]
min_score = 0.0
"""


class Frozen(AvodNetwork):
    """A network in training whose normalization keeps to its averages, so that no frame changes another's maps."""

    def train(self, mode: bool = True) -> Frozen:
        super().train(mode)
        for module in self.modules():
            if isinstance(module, ShiftBatchNorm):
                module.eval()
        return self


def small_config(folder: Path, text: str = TEXT) -> Config:
    file = folder / "small.toml"
    file.write_text(text)
    return Config.named(str(file))


def write_set(root: Path, num_train: int = 3, num_val: int = 2) -> Path:
    frame = make_frame()
    for index in range(num_train + num_val):
        image = np.roll(frame.image, 40 * index, axis=1)
        changed = dataclasses.replace(frame, image=image, points_velo=frame.points_velo[index:])
        write_frame(root, index, changed, split="train" if index < num_train else "val")
    return root


def short_run(config: Config, data: Folders, out: Path, steps: int, **options: Any) -> Path:
    hooks = {name: options.pop(name) for name in ("on_step", "validate", "should_stop") if name in options}
    return train(with_steps(config, steps), Run(data=data, out=out, **options), **hooks)


class StopAfter:
    """Asks a training to stop after so many steps."""

    def __init__(self, steps: int) -> None:
        self.left = steps

    def __call__(self) -> bool:
        self.left -= 1
        return self.left == 0


def weights(path: Path) -> dict[str, torch.Tensor]:
    checkpoint = read_checkpoint(path)
    network = AvodNetwork(checkpoint.config)
    load_network(checkpoint, network)
    return dict(network.state_dict())


def compared(detector: Detector, frame: Frame) -> tuple[tuple[Label, ...], list[Label], NDArray[np.float64]]:
    """Detect objects in a frame: what was found, what is there, and the overlaps in 3D of both."""
    found = detector.detect_frame(frame)
    truths = [label for label in frame.labels if not label.is_dont_care]
    return found, truths, box_iou_3d(np.stack([x.box_cam for x in found]), np.stack([x.box_cam for x in truths]))


def assert_same_training(found: Path, expected: Path) -> None:
    """Compare the last checkpoints and the logs of two runs: bit for bit, but for the time."""
    one, other = (sorted((run / "checkpoints").iterdir())[-1] for run in (found, expected))
    assert one.name == other.name
    for name in ("model.safetensors", "optimizer.safetensors"):
        assert (one / name).read_bytes() == (other / name).read_bytes(), name
    rows = [
        [{k: v for k, v in row.items() if k != "seconds_per_step"} for row in read_log(run / "log.csv")]
        for run in (found, expected)
    ]
    assert rows[0] == rows[1]
