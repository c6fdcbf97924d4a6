"""`cadet-gen` on the fake core, for tests that kill it. Workers import this file again, so they get the fake too."""

from __future__ import annotations

import errno
import os
import sys

import fake_native

sys.modules["cadet._cadet"] = fake_native

if "readonly" in os.environ.get("CADET_FAKE", ""):
    from cadet import sink

    def _refuse(self: sink.LocalSink, name: str, data: object) -> None:
        raise OSError(errno.EROFS, os.strerror(errno.EROFS), str(self.root / name))

    sink.LocalSink.put = _refuse  # type: ignore[method-assign]

if __name__ == "__main__":
    from cadet.cli import run_cadet_gen

    run_cadet_gen()
