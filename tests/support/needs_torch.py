"""Hooks of folders whose tests need torch: without it a folder is left out, and the report's header says so.

CI may not leave it out: `make test` installs torch, and `make test-core` does not come here.
"""

from __future__ import annotations

import importlib.util

import pytest

from in_ci import is_ci

HAS_TORCH = all(importlib.util.find_spec(name) is not None for name in ("torch", "safetensors"))

if is_ci() and not HAS_TORCH:
    raise pytest.UsageError("CI needs torch and safetensors (pip install 'cadet-sim[avod]')")

collect_ignore_glob = [] if HAS_TORCH else ["**/test_*.py"]


@pytest.hookimpl(tryfirst=True)
def pytest_runtest_setup() -> None:
    """Run on one thread: small tensors gain nothing from more, and the number of threads changes the last bits.

    Before a module's fixtures too, such as a training that others are compared with, and whatever a test has set.
    """
    import torch

    torch.set_num_threads(1)
