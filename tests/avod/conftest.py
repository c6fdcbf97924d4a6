"""The detector's tests need torch, which what they share is imported after."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING

import pytest

from needs_torch import collect_ignore_glob, pytest_runtest_setup

if TYPE_CHECKING:
    from avod.config import Config

__all__ = ["collect_ignore_glob", "pytest_runtest_setup"]


@pytest.fixture(scope="module")
def folder(tmp_path_factory: pytest.TempPathFactory) -> Path:
    return tmp_path_factory.mktemp("folder")


@pytest.fixture(scope="module")
def config(folder: Path) -> Config:
    from detector.runs import small_config

    return small_config(folder)


@pytest.fixture(scope="module")
def data(folder: Path) -> Path:
    from detector.runs import write_set

    return write_set(folder / "set")
