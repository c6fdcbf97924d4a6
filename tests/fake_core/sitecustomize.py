"""Puts the fake core into every Python process that has this folder on its path: `cadet-gen` and its workers."""

from __future__ import annotations

import errno
import importlib.util
import os
import sys
from collections.abc import Sequence
from importlib.abc import MetaPathFinder
from importlib.machinery import ModuleSpec
from pathlib import Path
from types import ModuleType

FAKE = Path(__file__).parents[1] / "fake_native.py"


class _FakeCore(MetaPathFinder):
    def find_spec(
        self, fullname: str, path: Sequence[str] | None, target: ModuleType | None = None
    ) -> ModuleSpec | None:
        return importlib.util.spec_from_file_location(fullname, FAKE) if fullname == "cadet._cadet" else None


sys.meta_path.insert(0, _FakeCore())

if "readonly" in os.environ.get("CADET_FAKE", ""):
    from cadet import sink

    def _refuse(self: sink.LocalSink, name: str, data: object) -> None:
        raise OSError(errno.EROFS, os.strerror(errno.EROFS), str(self.root / name))

    sink.LocalSink.put = _refuse  # type: ignore[method-assign]
