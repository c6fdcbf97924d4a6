"""Checkpoints of the detector as a target: settings and weights, damaged one at a time."""

from __future__ import annotations

import importlib.util
import random
import tempfile
from pathlib import Path

from fuzz.mutations import damage_bytes, damage_text
from fuzz.target import Input, Target

_SETTINGS, _WEIGHTS = "checkpoint.json", "model.safetensors"
_SEPARATOR = b"\f\f\f"


def checkpoint_targets() -> tuple[Target, ...]:
    """Return the target; none where torch is not installed."""
    if importlib.util.find_spec("torch") is None:
        return ()
    settings, weights = _checkpoint()

    def make(rng: random.Random) -> bytes:
        if rng.random() < 0.5:
            return damage_text(rng, settings.decode()).encode("utf-8", "surrogatepass") + _SEPARATOR + weights
        return settings + _SEPARATOR + damage_bytes(rng, weights)

    return (Target("checkpoints", make, _read),)


def _checkpoint() -> tuple[bytes, bytes]:
    import torch

    from avod.model.avod.network import AvodNetwork
    from avod.train.checkpoint import save_checkpoint
    from detector.runs import small_config

    # Children are forked from here: no thread of a pool may hold a lock.
    torch.set_num_threads(1)
    with tempfile.TemporaryDirectory() as folder:
        config = small_config(Path(folder))
        path = save_checkpoint(Path(folder), AvodNetwork(config), None, config, step=3, seed=0)
        return (path / _SETTINGS).read_bytes(), (path / _WEIGHTS).read_bytes()


def _read(value: Input) -> object:
    from avod.train.checkpoint import read_checkpoint, trained_network

    assert isinstance(value, bytes)
    settings, _, weights = value.partition(_SEPARATOR)
    with tempfile.TemporaryDirectory() as folder:
        (Path(folder) / _SETTINGS).write_bytes(settings)
        (Path(folder) / _WEIGHTS).write_bytes(weights)
        return trained_network(read_checkpoint(folder))
