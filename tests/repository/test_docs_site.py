"""The documentation's site: its menu, and the strict build."""

from __future__ import annotations

import os
import re
import subprocess
import sys
from pathlib import Path

import pytest

import cadet

ROOT = Path(__file__).parents[2]


def test_every_page_is_in_the_menu_once() -> None:
    menu = re.findall(r"^\s+- [^:]*: (?!https:)(\S+\.md)$", (ROOT / "mkdocs.yml").read_text(), re.MULTILINE)
    pages = [path.relative_to(ROOT / "docs").as_posix() for path in (ROOT / "docs").rglob("*.md")]
    assert sorted(menu) == sorted(pages)


def test_the_reference_has_every_public_name() -> None:
    pages = "\n".join(path.read_text() for path in (ROOT / "docs" / "reference").glob("*.md"))
    listed = set(re.findall(r"^::: cadet\.(.+)$", pages, re.MULTILINE))
    # Errors stand in a module, and submodules by what is in them.
    errors = {name for name in cadet.__all__ if name.endswith(("Error", "Warning"))}
    missing = set(cadet.__all__) - errors - {"__version__", "bev", "generate", "kitti", "weather_names"} - listed
    assert not missing
    assert {f"kitti.{name}" for name in cadet.kitti.__all__} - {
        "kitti.TYPES",
        *(f"kitti.{name}" for name in ("Calibration", "Frame", "FrameObject", "Label")),
    } <= listed | {f"kitti.{name}" for name in UNLISTED}


UNLISTED = ("encode_frame", "encode_meta", "frame_from_sample", "read_image_set", "write_image_set")
"""What serves writers of formats alone."""


@pytest.mark.timeout(300)
def test_the_site_builds_without_a_warning(tmp_path: Path) -> None:
    for module in ("mkdocs", "material", "mkdocstrings"):
        pytest.importorskip(module, reason="needs mkdocs, the extra docs")
    done = subprocess.run(
        [sys.executable, "-m", "mkdocs", "build", "--strict", "-d", str(tmp_path / "site")],
        cwd=ROOT,
        env={**os.environ, "NO_MKDOCS_2_WARNING": "1"},
        capture_output=True,
        text=True,
        check=False,
    )
    assert done.returncode == 0, done.stderr[-3000:]
    reference = (tmp_path / "site" / "reference" / "scenes" / "index.html").read_text()
    # Not the names alone: what the docstrings say, and its table of arguments.
    assert "Let physics run, rounded to whole steps" in reference and "model_seed" in reference
