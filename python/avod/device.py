"""Where a network runs."""

from __future__ import annotations

from typing import Final

import torch

from cadet.errors import CadetError

_KINDS: Final = ("cpu", "cuda", "mps", "xpu")


def resolve_device(name: str | torch.device) -> torch.device:
    """Find a device, and try it.

    Args:
        name: "cpu", "cuda", "mps" or "xpu", or one of several, such as "cuda:1".

    Raises:
        CadetError: another kind, such as "meta", or a device that this machine lacks.
    """
    try:
        device = torch.device(name)
        if device.type not in _KINDS:
            raise RuntimeError(f"expected {', '.join(_KINDS)}, or one of several such as cuda:1")
        torch.zeros(1, device=device).add(1.0).cpu()
    except (AssertionError, ImportError, RuntimeError, TypeError) as error:
        reason = (str(error).splitlines() or [type(error).__name__])[0]
        raise CadetError(f"device: {str(name)!r} cannot be used: {reason}") from None
    return device
