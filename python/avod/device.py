"""The device that a network runs on, and the processes that share a training."""

from __future__ import annotations

import contextlib
import gc
import os
from collections.abc import Iterator
from dataclasses import dataclass
from typing import Any, Final

import torch
from torch import Tensor, distributed, nn
from torch.nn.parallel import DistributedDataParallel

from cadet.errors import CadetError

_KINDS: Final = ("cpu", "cuda", "mps", "xpu")
_COUNTED: Final = ("cuda", "xpu")
_BACKENDS: Final = {"cpu": "gloo", "cuda": "nccl", "xpu": "xccl"}


def resolve_device(name: str | torch.device | None) -> torch.device:
    """Find a device, and try it.

    Args:
        name: "cpu", "cuda", "mps" or "xpu", or one of several, such as "cuda:1"; None for a CUDA GPU if there is one,
            else the CPU.

    Raises:
        CadetError: another kind, such as "meta", or a device that this machine lacks.
    """
    if name is None:
        name = "cuda" if torch.cuda.is_available() else "cpu"
    try:
        device = torch.device(name)
        if device.type not in _KINDS:
            raise RuntimeError(f"expected {', '.join(_KINDS)}, or one of several such as cuda:1")
        torch.zeros(1, device=device).add(1.0).cpu()
    except (AssertionError, ImportError, RuntimeError, TypeError) as error:
        reason = (str(error).splitlines() or [type(error).__name__])[0]
        raise CadetError(f"device: {str(name)!r} cannot be used: {reason}") from None
    return device


def world_size() -> int:
    """Return how many processes `torchrun` has started for one training; 1 without it."""
    return int(os.environ.get("WORLD_SIZE", "1"))


def is_first_process() -> bool:
    """Say whether this process is the one that speaks for all that `torchrun` started."""
    return os.environ.get("RANK", "0") == "0"


def name_of_process(name: str) -> str:
    """Return the name of this process's own device: of several that `torchrun` started, each takes the next.

    Args:
        name: as for `resolve_device`.

    Raises:
        CadetError: one of several devices is named, and several processes would share it.
    """
    count = world_size()
    kind, _, index = name.partition(":")
    if count == 1 or kind not in _COUNTED:
        return name
    if index:
        raise CadetError(f"device: {name!r} is one device, for {count} processes: name the kind alone, {kind}")
    return f"{kind}:{int(os.environ.get('LOCAL_RANK', '0'))}"


@dataclass(frozen=True)
class Processes:
    """This process among the others of a training.

    Attributes:
        rank: this process, from 0.
        world_size: how many there are.
        device: where this one's network runs.
    """

    rank: int = 0
    world_size: int = 1
    device: torch.device = torch.device("cpu")

    @classmethod
    @contextlib.contextmanager
    def joined(cls, device: torch.device) -> Iterator[Processes]:
        """Join the others meanwhile, if `torchrun` started this process; else it is alone.

        Args:
            device: of this process; its kind decides how the processes talk to each other.

        Raises:
            CadetError: several processes on a kind of device that cannot share a training.
        """
        count = world_size()
        if count == 1:
            yield cls(device=device)
            return
        backend = _BACKENDS.get(device.type)
        if backend is None:
            raise CadetError(f"device: {device.type!r} cannot be shared by {count} processes")
        if device.type == "cuda":
            torch.cuda.set_device(device)
        is_ours = not distributed.is_initialized()
        if is_ours:
            distributed.init_process_group(backend)
        yield cls(distributed.get_rank(), count, device)
        # Not after an error: the others may wait for this process elsewhere, and it for them.
        if is_ours:
            # Wrapped networks hold the group in circles. What is not gone when Python ends takes the process down:
            # https://github.com/pytorch/pytorch/issues/190489.
            gc.collect()
            if backend == "gloo":
                # Gloo's threads may release the last tensors after Python has begun to end, which aborts the process.
                # A barrier holds none, and takes so long that those before it are gone.
                distributed.barrier()
            distributed.destroy_process_group()

    @property
    def is_first(self) -> bool:
        """Whether this process writes log and checkpoints."""
        return self.rank == 0

    def wrap(self, network: nn.Module) -> nn.Module:
        """Let gradients be averaged over all processes."""
        if self.world_size == 1:
            return network
        return DistributedDataParallel(network)

    def share_buffers(self, network: nn.Module) -> None:
        """Give all processes the first one's buffers, such as the batch statistics, as checkpoints hold them."""
        if self.world_size > 1:
            for buffer in network.buffers():
                distributed.broadcast(buffer, src=0)

    def mean(self, losses: dict[str, Tensor]) -> dict[str, Tensor]:
        """Average losses over all processes; all hand in the same names."""
        if self.world_size == 1 or not losses:
            return losses
        values = torch.stack([value.detach().to(self.device).float() for value in losses.values()])
        distributed.all_reduce(values)
        return dict(zip(losses, values / self.world_size, strict=True))

    def any(self, flag: bool) -> bool:
        """Say whether the flag is set in any process, so that all decide alike."""
        if self.world_size == 1:
            return flag
        value = torch.tensor(float(flag), device=self.device)
        distributed.all_reduce(value)
        return bool(value > 0.0)

    def gathered(self, value: Any) -> list[Any]:
        """Return every process's value, by rank."""
        if self.world_size == 1:
            return [value]
        values: list[Any] = [None] * self.world_size
        distributed.all_gather_object(values, value)
        return values
