"""`cadet-gen` on the fake core, for tests that kill it. Workers import this file again, so they get the fake too."""

from __future__ import annotations

import sys

import fake_native

sys.modules["cadet._cadet"] = fake_native

if __name__ == "__main__":
    from cadet.cli import run_cadet_gen

    run_cadet_gen()
