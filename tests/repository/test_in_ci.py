"""CI's skips: what is allowed stays a skip, all else fails, and at home nothing does."""

from __future__ import annotations

import os
import subprocess
import sys
from pathlib import Path

import pytest

SUPPORT = Path(__file__).parents[1] / "support"
MODULE = """
import pytest

def test_a_library():
    pytest.importorskip("no_such_library", reason="needs no_such_library")

@pytest.mark.skipif(True, reason="needs real KITTI frames in ../shared/kitti")
def test_files(): ...

@pytest.mark.xfail(reason="known")
def test_known():
    assert False
"""


@pytest.mark.parametrize(
    ("ci", "counts"), [("true", "1 failed, 1 skipped, 1 xfailed, 1 error"), ("", "3 skipped, 1 xfailed")]
)
def test_in_ci_skips_without_leave_fail(tmp_path: Path, ci: str, counts: str) -> None:
    (tmp_path / "test_some.py").write_text(MODULE)
    (tmp_path / "test_whole.py").write_text("import pytest\npytest.skip('not today', allow_module_level=True)\n")
    done = subprocess.run(
        [sys.executable, "-m", "pytest", "-p", "in_ci", "-q", "--continue-on-collection-errors", tmp_path],
        cwd=tmp_path,
        env={**os.environ, "CI": ci, "PYTHONPATH": str(SUPPORT), "PYTEST_ADDOPTS": ""},
        capture_output=True,
        text=True,
        timeout=110,
        check=False,
    )
    assert done.stdout.splitlines()[-1].startswith(f"{counts} in "), done.stdout
    if ci:
        assert "needs no_such_library: CI may not skip for this" in done.stdout
        assert "not today: CI may not skip for this" in done.stdout
