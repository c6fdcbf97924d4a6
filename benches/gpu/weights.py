"""A checkpoint's weights for sending: `weights.py split CHECKPOINT DIR`, and back by `weights.py join DIR CHECKPOINT`.

Matrices are rounded to float16; what else there is, such as the normalizations' averages, stays float32. DIR holds
`checkpoint.json` and `model.0`, `model.1`, ..., each of 15 MiB at most.
"""

from __future__ import annotations

import shutil
import sys
from pathlib import Path

import torch
from safetensors.torch import load, load_file, save

from avod.train.checkpoint import read_checkpoint

PART_BYTES = 15 * 2**20


def split(checkpoint: Path, folder: Path) -> None:
    """Write a checkpoint's parts into a folder; old parts there are removed.

    Raises:
        CadetError: no checkpoint there.
    """
    path = read_checkpoint(checkpoint).path
    tensors = load_file(path / "model.safetensors")
    data = save({name: value.half() if value.dim() > 1 else value for name, value in tensors.items()})
    folder.mkdir(parents=True, exist_ok=True)
    for old in folder.glob("model.*"):
        old.unlink()
    for number, start in enumerate(range(0, len(data), PART_BYTES)):
        (folder / f"model.{number}").write_bytes(data[start : start + PART_BYTES])
    shutil.copy(path / "checkpoint.json", folder)


def join(folder: Path, checkpoint: Path) -> None:
    """Make a checkpoint of its parts."""
    parts = sorted(folder.glob("model.*"), key=lambda part: int(part.suffix[1:]))
    tensors = load(b"".join(part.read_bytes() for part in parts))
    checkpoint.mkdir(parents=True, exist_ok=True)
    whole = save({name: value.to(torch.float32) for name, value in tensors.items()})
    (checkpoint / "model.safetensors").write_bytes(whole)
    shutil.copy(folder / "checkpoint.json", checkpoint)


if __name__ == "__main__":
    if len(sys.argv) != 4 or sys.argv[1] not in ("split", "join"):
        sys.exit(__doc__)
    {"split": split, "join": join}[sys.argv[1]](Path(sys.argv[2]), Path(sys.argv[3]))
