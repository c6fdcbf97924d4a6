"""What `make build` says: one line, and all that the build tool said if it fails."""

from __future__ import annotations

import re
import shutil
import subprocess
import sys
from pathlib import Path

import pytest

ROOT = Path(__file__).parents[2]

needs_tools = pytest.mark.skipif(
    not all(shutil.which(tool) for tool in ("make", "cargo", "rustc", "cc")), reason="make checks for Rust and a linker"
)


def make_build(folder: Path, *, exit_code: int) -> subprocess.CompletedProcess[str]:
    """Run `make build` in an environment whose maturin only talks, and ends with an exit code."""
    programs = folder / "venv" / "bin"
    programs.mkdir(parents=True)
    (programs / "python").symlink_to(sys.executable)
    maturin = programs / "maturin"
    maturin.write_text(f'#!/bin/sh\necho "   Compiling cadet_core"\necho "error: of rustc" >&2\nexit {exit_code}\n')
    maturin.chmod(0o755)
    command = ["make", "--silent", "--no-print-directory", "build", f"VENV={programs.parent}"]
    return subprocess.run(command, cwd=ROOT, capture_output=True, text=True, check=False)


@needs_tools
def test_a_build_says_one_line(tmp_path: Path) -> None:
    result = make_build(tmp_path, exit_code=0)
    assert result.returncode == 0
    assert re.fullmatch(r"Building the Rust core \(.*\) \.\.\. done in \d+ s\n", result.stdout)
    assert result.stderr == ""


@needs_tools
def test_a_build_that_fails_shows_all_that_was_said(tmp_path: Path) -> None:
    result = make_build(tmp_path, exit_code=3)
    assert result.returncode == 2, "make's own for a recipe that failed"
    assert re.fullmatch(r"Building the Rust core \(.*\) \.\.\. failed after \d+ s\n", result.stdout)
    assert "   Compiling cadet_core\nerror: of rustc\n" in result.stderr
