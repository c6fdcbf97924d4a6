"""The detector's tests need torch; without it the whole folder is left out, and the report's header says so.

CI may not leave it out: `make test` installs torch, and `make test-core` does not come here.
"""

from __future__ import annotations

import importlib.util
from collections.abc import Iterator

import pytest

from in_ci import is_ci

HAS_TORCH = all(importlib.util.find_spec(name) is not None for name in ("torch", "safetensors"))

if is_ci() and not HAS_TORCH:
    raise pytest.UsageError("tests/avod: CI needs torch and safetensors (pip install 'cadet-sim[avod]')")

collect_ignore_glob = [] if HAS_TORCH else ["test_*.py"]


@pytest.fixture(scope="session", autouse=True)
def _one_thread() -> Iterator[None]:
    """Run on one thread: small tensors gain nothing from more, and the number of threads changes the last bits.

    Of the whole session, so that fixtures of a module, such as a training that others are compared with, see it too.
    """
    import torch

    threads = torch.get_num_threads()
    torch.set_num_threads(1)
    yield
    torch.set_num_threads(threads)
