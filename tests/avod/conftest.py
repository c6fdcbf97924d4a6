"""The detector's tests need torch; without it the whole folder is left out, and the report's header says so."""

from __future__ import annotations

import importlib.util
from collections.abc import Iterator

import pytest

HAS_TORCH = all(importlib.util.find_spec(name) is not None for name in ("torch", "safetensors"))

collect_ignore_glob = [] if HAS_TORCH else ["test_*.py"]


@pytest.fixture(autouse=True)
def _one_thread() -> Iterator[None]:
    """Run on one thread: small tensors gain nothing from more, and the machine is shared."""
    import torch

    threads = torch.get_num_threads()
    torch.set_num_threads(1)
    yield
    torch.set_num_threads(threads)
