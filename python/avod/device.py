"""Where a network runs."""

from __future__ import annotations

import os
from typing import Final

import torch

from cadet.errors import CadetError

_KINDS: Final = ("cpu", "cuda", "mps", "xpu")
_COUNTED: Final = ("cuda", "xpu")


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
