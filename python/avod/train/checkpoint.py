"""Checkpoints: a folder of tensors (safetensors) and settings (JSON). Loading one never runs code.

000002000/checkpoint.json         format, step, seed, configuration, versions
000002000/model.safetensors       weights and moving averages
000002000/optimizer.safetensors   Adam's averages by parameter; may be left out where nothing is trained on
"""

from __future__ import annotations

import json
import os
import shutil
from dataclasses import dataclass
from pathlib import Path
from typing import Any, Final

import torch
from safetensors import SafetensorError
from safetensors.torch import load_file, save_file
from torch import Tensor, nn

from avod.config import Config
from avod.config_file import config_from_table, table_from_config
from avod.model.network import AvodNetwork
from cadet import __version__
from cadet.errors import CadetError, MissingFileError
from cadet.plain_text import json_from_text

_FORMAT: Final = "avod-checkpoint"
_FORMAT_VERSION: Final = 1
_SETTINGS: Final = "checkpoint.json"
_MODEL: Final = "model.safetensors"
_OPTIMIZER: Final = "optimizer.safetensors"
_PACKAGED: Final = Path(__file__).parents[1] / "checkpoints"
_AVERAGES: Final = ("exp_avg", "exp_avg_sq")


@dataclass(frozen=True)
class Checkpoint:
    """The settings of a checkpoint.

    Attributes:
        path: its folder.
        step: how many steps were trained.
        seed: of the training.
        config: of the detector and its training.
    """

    path: Path
    step: int
    seed: int
    config: Config


def save_checkpoint(
    folder: Path, network: nn.Module, optimizer: torch.optim.Optimizer | None, config: Config, *, step: int, seed: int
) -> Path:
    """Write a checkpoint under a folder, whole or not at all, and return its path.

    What random numbers and frames come next follows from seed and step, so these two are all there is to keep of them.
    """
    path = folder / f"{step:09d}"
    aside = folder / f".{path.name}.{os.getpid()}.partial"
    shutil.rmtree(aside, ignore_errors=True)
    aside.mkdir(parents=True)
    settings = {
        "format": _FORMAT,
        "version": _FORMAT_VERSION,
        "step": step,
        "seed": seed,
        "config": table_from_config(config),
        "made_with": {"cadet": __version__, "torch": torch.__version__},
    }
    save_file({name: tensor.contiguous() for name, tensor in network.state_dict().items()}, aside / _MODEL)
    if optimizer is not None:
        save_file(_optimizer_tensors(network, optimizer), aside / _OPTIMIZER)
    (aside / _SETTINGS).write_text(json.dumps(settings, indent=1) + "\n", encoding="utf-8")
    if path.exists():
        shutil.rmtree(path)
    aside.replace(path)
    return path


def read_checkpoint(path: str | Path) -> Checkpoint:
    """Read the settings of a checkpoint.

    Args:
        path: its folder, a training's folder, whose last checkpoint is meant, or the name of one of the package's.

    Raises:
        MissingFileError: no checkpoint there.
        CadetError: damaged settings, or those of another format.
    """
    path = _resolve(Path(path))
    settings = json_from_text((path / _SETTINGS).read_bytes(), str(path / _SETTINGS))
    if not isinstance(settings, dict) or settings.get("format") != _FORMAT:
        raise CadetError(f"{path / _SETTINGS}: no avod checkpoint")
    if settings.get("version") != _FORMAT_VERSION:
        raise CadetError(f"{path / _SETTINGS}: version {settings.get('version')!r}, expected {_FORMAT_VERSION}")
    step, seed = (_count(settings, key, path) for key in ("step", "seed"))
    return Checkpoint(path, step, seed, config_from_table(settings.get("config"), f"{path / _SETTINGS}: config"))


def packaged_checkpoints() -> tuple[str, ...]:
    """List the checkpoints that come with the package."""
    return tuple(sorted(path.parent.name for path in _PACKAGED.glob(f"*/{_SETTINGS}")))


def checkpoints(folder: Path) -> list[Path]:
    """List the checkpoints under a folder, the oldest first."""
    return sorted(path.parent for path in folder.glob(f"*/{_SETTINGS}") if path.parent.name.isdecimal())


def keep_best(path: Path, kept: Path) -> None:
    """Copy a checkpoint to a place of its own, replacing what was there, without what only training needs."""
    aside = kept.with_name(f".{kept.name}.{os.getpid()}.partial")
    shutil.rmtree(aside, ignore_errors=True)
    shutil.copytree(path, aside, ignore=shutil.ignore_patterns(_OPTIMIZER))
    shutil.rmtree(kept, ignore_errors=True)
    aside.replace(kept)


def load_network(checkpoint: Checkpoint, network: AvodNetwork) -> None:
    """Take a checkpoint's weights over.

    Raises:
        MissingFileError: no weights there.
        CadetError: damaged weights, or those of another configuration; the first that differs is named.
    """
    file = checkpoint.path / _MODEL
    tensors, wanted = _load(file), network.state_dict()
    for name, tensor in wanted.items():
        if name not in tensors:
            raise CadetError(f"{file}: {name} is missing: these are weights of another configuration")
        if tensors[name].shape != tensor.shape:
            shapes = f"{tuple(tensors[name].shape)}, expected {tuple(tensor.shape)}"
            raise CadetError(f"{file}: {name} is {shapes}: these are weights of another configuration")
        if not bool(torch.isfinite(tensors[name]).all()):
            raise CadetError(f"{file}: {name} holds NaN or infinity")
    unknown = sorted(set(tensors) - set(wanted))
    if unknown:
        raise CadetError(f"{file}: {unknown[0]} is not in the network: these are weights of another configuration")
    network.load_state_dict(tensors)


def load_optimizer(checkpoint: Checkpoint, network: nn.Module, optimizer: torch.optim.Optimizer) -> None:
    """Take a checkpoint's averages of gradients over.

    Raises:
        MissingFileError: the checkpoint has none, so nothing can go on from it.
        CadetError: damaged ones, or those of another configuration.
    """
    file = checkpoint.path / _OPTIMIZER
    if not file.is_file():
        raise MissingFileError(f"{file}: no such file: take this checkpoint's weights with --init instead")
    tensors = _load(file)
    for name, parameter in network.named_parameters():
        averages = {key: tensors.get(f"{key}.{name}") for key in _AVERAGES}
        if any(value is None or value.shape != parameter.shape for value in averages.values()):
            raise CadetError(f"{file}: {name} does not fit: this is a checkpoint of another configuration")
        # Copied into the parameter's own device and memory format.
        state: dict[str, Any] = {
            key: torch.empty_like(parameter).detach().copy_(value)
            for key, value in averages.items()
            if value is not None
        }
        optimizer.state[parameter] = {"step": tensors["step"].clone(), **state}


def _optimizer_tensors(network: nn.Module, optimizer: torch.optim.Optimizer) -> dict[str, Tensor]:
    tensors: dict[str, Tensor] = {"step": torch.tensor(0.0)}
    for name, parameter in network.named_parameters():
        state = optimizer.state.get(parameter, {})
        for key in _AVERAGES:
            tensors[f"{key}.{name}"] = state.get(key, torch.zeros_like(parameter)).detach().contiguous()
        tensors["step"] = torch.as_tensor(state.get("step", tensors["step"])).float().cpu().clone()
    return tensors


def _load(file: Path) -> dict[str, Tensor]:
    if not file.is_file():
        raise MissingFileError(f"{file}: no such file")
    try:
        return load_file(file)
    except SafetensorError as error:
        raise CadetError(f"{file}: damaged: {error}") from None


def _resolve(path: Path) -> Path:
    if (path / _SETTINGS).is_file():
        return path
    for folder in (path, path / "checkpoints"):
        found = checkpoints(folder)
        if found:
            return found[-1]
    if str(path) in packaged_checkpoints():
        return _PACKAGED / path
    raise MissingFileError(
        f"{path}: no checkpoint: expected a folder with {_SETTINGS}, or one of {', '.join(packaged_checkpoints())}"
    )


def _count(settings: dict[str, Any], key: str, path: Path) -> int:
    value = settings.get(key)
    if not isinstance(value, int) or isinstance(value, bool) or value < 0:
        raise CadetError(f"{path / _SETTINGS}: {key}: expected a whole number of at least 0, got {value!r}")
    return value
