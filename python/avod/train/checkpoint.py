"""Checkpoints: a folder of tensors (safetensors) and settings (JSON). Loading one never runs code.

000002000/checkpoint.json         format, step, seed, configuration, data, versions, sums of the log's next row
000002000/model.safetensors       weights and moving averages; with `average_decay` the weights' averages too
000002000/optimizer.safetensors   Adam's averages by parameter, and with `average_decay` the last step's weights; a
                                  training keeps them in its newest checkpoint alone
"""

from __future__ import annotations

import json
import math
import os
import shutil
from collections.abc import Mapping
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any, Final, TypeVar

import torch
from safetensors import SafetensorError, safe_open
from safetensors.torch import load_file, save
from torch import Tensor, nn

from avod.config import Config
from avod.config.tables import config_from_table, table_from_config
from avod.data.order import seeded
from avod.model.making import abstract_network, make_network
from avod.model.network import AnyNetwork
from avod.train.settings import made_with
from cadet._util.plain_text import json_from_text
from cadet._util.summary import summary
from cadet._util.user_files import names_file
from cadet.errors import CadetError, MissingFileError

_FORMAT: Final = "avod-checkpoint"
_FORMAT_VERSION: Final = 1
_SETTINGS: Final = "checkpoint.json"
_MODEL: Final = "model.safetensors"
_OPTIMIZER: Final = "optimizer.safetensors"
_PACKAGED: Final = Path(__file__).parents[1] / "checkpoints"
_AVERAGES: Final = ("exp_avg", "exp_avg_sq")
_MEANS: Final = "exp_avg."
_WEIGHTS: Final = "weights."
_FLOAT32: Final = "F32"

T = TypeVar("T")


@dataclass(frozen=True)
class Checkpoint:
    """The settings of a checkpoint.

    Attributes:
        path: its folder.
        step: how many steps were trained.
        seed: of the training.
        config: of the detector and its training.
        pending: the sums of the log's next row, by term, and "count", the steps in them; empty if none are.
    """

    path: Path
    step: int
    seed: int
    config: Config
    pending: Mapping[str, float] = field(default_factory=dict)

    def __repr__(self) -> str:
        classes = self.config.class_names
        return summary(self, path=str(self.path), step=self.step, seed=self.seed, classes=classes)


def save_checkpoint(
    folder: Path,
    network: nn.Module,
    optimizer: torch.optim.Optimizer | None,
    config: Config,
    *,
    step: int,
    seed: int,
    average: nn.Module | None = None,
    notes: Mapping[str, Any] | None = None,
    name: str | None = None,
) -> Path:
    """Write a checkpoint under a folder, whole or not at all, and return its path.

    What random numbers and frames come next follows from seed and step, so these two are all there is to keep of them.

    Args:
        folder: of all checkpoints of the training.
        network: its weights and moving averages are written, or those of `average`.
        optimizer: its averages are written; None for a checkpoint that nothing goes on from.
        config: of the detector and its training.
        step: how many steps are done.
        seed: of the training.
        average: the network whose weights are averages; the network's own then go with the optimizer's averages.
        notes: what else is written into the settings: data, split, the log's pending sums.
        name: of the checkpoint's folder; by default its step, of nine digits.
    """
    path = folder / (name or f"{step:09d}")
    aside, old = (folder / f".{path.name}.{os.getpid()}.{kind}" for kind in ("partial", "old"))
    shutil.rmtree(aside, ignore_errors=True)
    aside.mkdir(parents=True)
    settings = {
        "format": _FORMAT,
        "version": _FORMAT_VERSION,
        "step": step,
        "seed": seed,
        "config": table_from_config(config),
        "made_with": made_with(),
        **(notes or {}),
    }
    # Not save_file, whose files nobody but their owner may read.
    _write(aside / _MODEL, save(_weights(network if average is None else average)))
    if optimizer is not None:
        own = {} if average is None else _weights(network, _WEIGHTS)
        _write(aside / _OPTIMIZER, save(_optimizer_tensors(network, optimizer) | own))
    _write(aside / _SETTINGS, (json.dumps(settings, indent=1) + "\n").encode())
    if path.exists():
        path.replace(old)
    aside.replace(path)
    shutil.rmtree(old, ignore_errors=True)
    return path


def forget_old(folder: Path, keep: int | None) -> None:
    """Remove what only the newest checkpoint needs from the older ones, and all but the newest `keep`.

    Called after a checkpoint is written whole, so that there is always one from which training can go on.
    """
    written = checkpoints(folder)
    for path in written[:-1]:
        (path / _OPTIMIZER).unlink(missing_ok=True)
    for path in [] if keep is None else written[:-keep]:
        # Gone at once, or a reader would find half of it.
        aside = path.with_name(f".{path.name}.{os.getpid()}.old")
        path.replace(aside)
        shutil.rmtree(aside, ignore_errors=True)


def remove_partial(folder: Path) -> None:
    """Remove what a training that was killed had begun to write, or to remove."""
    for kind in ("partial", "old"):
        for path in folder.glob(f".*.{kind}"):
            shutil.rmtree(path, ignore_errors=True)


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
        raise CadetError(f"{path / _SETTINGS}: not an avod checkpoint")
    if settings.get("version") != _FORMAT_VERSION:
        raise CadetError(f"{path / _SETTINGS}: version {settings.get('version')!r}, expected {_FORMAT_VERSION}")
    step, seed = (_count(settings, key, path) for key in ("step", "seed"))
    config = config_from_table(settings.get("config"), f"{path / _SETTINGS}: config")
    return Checkpoint(path, step, seed, config, _pending(settings, path))


def packaged_checkpoints() -> tuple[str, ...]:
    """List the checkpoints that come with the package."""
    return tuple(sorted(path.parent.name for path in _PACKAGED.glob(f"*/{_SETTINGS}")))


def checkpoints(folder: Path) -> list[Path]:
    """List the checkpoints under a folder, the oldest first."""
    return sorted(path.parent for path in folder.glob(f"*/{_SETTINGS}") if path.parent.name.isdecimal())


def keep_checkpoint(path: Path, kept: Path, *, has_optimizer: bool = False) -> None:
    """Copy a checkpoint to a place of its own, replacing what was there.

    Args:
        path: of the checkpoint.
        kept: of the copy.
        has_optimizer: copy what only training needs, too.
    """
    aside = kept.with_name(f".{kept.name}.{os.getpid()}.partial")
    shutil.rmtree(aside, ignore_errors=True)
    shutil.copytree(path, aside, ignore=None if has_optimizer else shutil.ignore_patterns(_OPTIMIZER))
    shutil.rmtree(kept, ignore_errors=True)
    aside.replace(kept)


def trained_network(checkpoint: Checkpoint) -> AnyNetwork:
    """Make the network of a checkpoint. The file's shapes are compared first, so that it bounds the memory.

    Raises:
        MissingFileError: no weights there.
        CadetError: damaged weights, or those of another configuration; the first that differs is named.
    """
    file = checkpoint.path / _MODEL
    _check_weights(file, _shapes(file), abstract_network(checkpoint.config).state_dict())
    with seeded(torch.device("cpu"), checkpoint.seed):
        network = make_network(checkpoint.config)
    load_network(checkpoint, network)
    return network


def load_network(checkpoint: Checkpoint, network: AnyNetwork, part: str = "") -> None:
    """Load a checkpoint's weights, or those whose names begin with that of a part, such as "refinement.".

    Raises:
        MissingFileError: no weights there.
        CadetError: damaged weights, or those of another configuration; the first that differs is named.
    """
    file = checkpoint.path / _MODEL
    _check_weights(file, _of_part(_shapes(file), part), _of_part(network.state_dict(), part))
    tensors = _of_part(_load(file), part)
    for name, tensor in tensors.items():
        if not bool(torch.isfinite(tensor).all()):
            raise CadetError(f"{file}: {name} holds NaN or infinity")
    network.load_state_dict(tensors, strict=not part)


def load_optimizer(checkpoint: Checkpoint, network: nn.Module, optimizer: torch.optim.Optimizer) -> None:
    """Load a checkpoint's averages of gradients, and the last step's weights if its own are averages.

    Raises:
        MissingFileError: the checkpoint has none, so nothing can go on from it.
        CadetError: damaged ones, those of another configuration, or numbers that Adam cannot have left.
    """
    file = checkpoint.path / _OPTIMIZER
    if not file.is_file():
        raise MissingFileError(
            f"{file}: no such file: of a training only the newest checkpoint can be resumed; "
            "take this checkpoint's weights with --init instead"
        )
    shapes, parameters = _shapes(file), dict(network.named_parameters())
    wanted = {f"{key}.{name}": tuple(value.shape) for name, value in parameters.items() for key in _AVERAGES}
    for name, shape in (wanted | {"step": ()}).items():
        if shapes.get(name) != (shape, _FLOAT32):
            raise CadetError(f"{file}: {name} does not fit: this is a checkpoint of another configuration")
    own = {name.removeprefix(_WEIGHTS): shape for name, shape in shapes.items() if name.startswith(_WEIGHTS)}
    if own:
        _check_weights(file, own, network.state_dict())
    tensors = _load(file)
    for name, value in tensors.items():
        if not bool(torch.isfinite(value).all()):
            raise CadetError(f"{file}: {name} holds NaN or infinity")
        if not name.startswith((_MEANS, _WEIGHTS)) and bool((value < 0.0).any()):
            raise CadetError(f"{file}: {name} holds a negative number")
    for name, parameter in parameters.items():
        # Copied into the parameter's own device and memory format.
        state: dict[str, Any] = {
            key: torch.empty_like(parameter).detach().copy_(tensors[f"{key}.{name}"]) for key in _AVERAGES
        }
        optimizer.state[parameter] = {"step": tensors["step"].clone(), **state}
    if own:
        network.load_state_dict({name: tensors[_WEIGHTS + name] for name in own})


def _of_part(values: Mapping[str, T], part: str) -> dict[str, T]:
    return {name: value for name, value in values.items() if name.startswith(part)}


def _weights(network: nn.Module, prefix: str = "") -> dict[str, Tensor]:
    return {prefix + name: tensor.contiguous() for name, tensor in network.state_dict().items()}


def _optimizer_tensors(network: nn.Module, optimizer: torch.optim.Optimizer) -> dict[str, Tensor]:
    tensors: dict[str, Tensor] = {"step": torch.tensor(0.0)}
    for name, parameter in network.named_parameters():
        state = optimizer.state.get(parameter, {})
        for key in _AVERAGES:
            tensors[f"{key}.{name}"] = state.get(key, torch.zeros_like(parameter)).detach().contiguous()
        tensors["step"] = torch.as_tensor(state.get("step", tensors["step"])).float().cpu().clone()
    return tensors


def _check_weights(file: Path, shapes: dict[str, tuple[tuple[int, ...], str]], wanted: Mapping[str, Tensor]) -> None:
    other = "these are weights of another configuration"
    for name, tensor in wanted.items():
        if name not in shapes:
            raise CadetError(f"{file}: {name} is missing: {other}")
        shape, kind = shapes[name]
        if shape != tuple(tensor.shape):
            raise CadetError(f"{file}: {name} is {shape}, expected {tuple(tensor.shape)}: {other}")
        if kind != _FLOAT32:
            raise CadetError(f"{file}: {name} is of type {kind}, expected {_FLOAT32}")
    unknown = sorted(set(shapes) - set(wanted))
    if unknown:
        raise CadetError(f"{file}: {unknown[0]} is not in the network: {other}")


def _shapes(file: Path) -> dict[str, tuple[tuple[int, ...], str]]:
    """Read the shape and type of each tensor of a file, and nothing more of it."""
    if not file.is_file():
        raise MissingFileError(f"{file}: no such file")
    try:
        with safe_open(file, framework="pt") as tensors:
            slices = {name: tensors.get_slice(name) for name in tensors.keys()}  # noqa: SIM118 - no mapping
            return {name: (tuple(part.get_shape()), str(part.get_dtype())) for name, part in slices.items()}
    except SafetensorError as error:
        raise CadetError(f"{file}: damaged: {error}") from None


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
        f"{path}: not a checkpoint: expected a folder with {_SETTINGS}, or one of {', '.join(packaged_checkpoints())}"
    )


def _write(path: Path, data: bytes) -> None:
    with names_file(path), path.open("wb") as file:
        file.write(data)
        file.flush()
        # On the disk before it is renamed: else a loss of power leaves an empty file under the final name.
        os.fsync(file.fileno())


def _pending(settings: dict[str, Any], path: Path) -> dict[str, float]:
    values = settings.get("pending", {})
    if not isinstance(values, dict) or not all(
        isinstance(value, int | float) and math.isfinite(value) for value in values.values()
    ):
        raise CadetError(f"{path / _SETTINGS}: pending: expected finite numbers by name")
    return {str(name): float(value) for name, value in values.items()}


def _count(settings: dict[str, Any], key: str, path: Path) -> int:
    value = settings.get(key)
    if not isinstance(value, int) or isinstance(value, bool) or not 0 <= value < 2**63:
        raise CadetError(f"{path / _SETTINGS}: {key}: expected a whole number from 0 to 2**63 - 1, got {value!r:.40}")
    return value
