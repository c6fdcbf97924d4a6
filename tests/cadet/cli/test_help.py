"""The page that `cadet` shows first, by task."""

from __future__ import annotations

import subprocess
import sys
from collections import Counter

from cadet.cli.tools import cadet


def test_every_command_has_one_task() -> None:
    named = Counter(name for names in cadet.tasks.values() for name in names)
    assert named == Counter(cadet.commands.keys())


def test_python_m_cadet_shows_the_page_with_whole_lines() -> None:
    page = subprocess.check_output([sys.executable, "-m", "cadet", "--help"], text=True, timeout=100)
    assert page.startswith("Usage: cadet [OPTIONS] COMMAND")
    assert [line[:-1] for line in page.splitlines() if line in {f"{task}:" for task in cadet.tasks}] == [*cadet.tasks]
    described = {line.split()[0] for line in page.splitlines() if line.startswith("  ") and line.split()}
    assert {*cadet.commands} <= described
    assert "..." not in page.split("Make:")[1]
