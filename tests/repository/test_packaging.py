"""What the package says of itself in several places."""

from __future__ import annotations

import os
import re
import signal
import subprocess
import sys
import tarfile
from pathlib import Path

import pytest

if sys.version_info >= (3, 11):
    import tomllib
else:
    import tomli as tomllib

import cadet
from cadet._util.operating_system import ENDING_SIGNALS, FolderInUseError, locked_folder, num_processors

ROOT = Path(__file__).parents[2]


def test_the_citation_has_the_packages_version() -> None:
    cargo = tomllib.loads((ROOT / "Cargo.toml").read_text())
    found = re.search(r"^version: (\S+)$", (ROOT / "CITATION.cff").read_text(), re.MULTILINE)
    assert found is not None and found[1] == cargo["workspace"]["package"]["version"]


def test_what_the_package_lists_is_public() -> None:
    assert dir(cadet) == sorted(cadet.__all__)
    assert all(hasattr(cadet, name) for name in cadet.__all__)


def test_the_source_distribution_holds_all_that_is_built(tmp_path: Path) -> None:
    maturin = Path(sys.executable).with_name("maturin")
    subprocess.run([maturin, "sdist", "--out", tmp_path], cwd=ROOT, check=True, capture_output=True)
    (path,) = tmp_path.iterdir()
    with tarfile.open(path) as archive:
        packed = {name.partition("/")[2] for name in archive.getnames()}
    built = {"Cargo.lock", "Cargo.toml", "pyproject.toml"}
    for folder in ("crates", "python"):
        files = (one.relative_to(ROOT) for one in (ROOT / folder).rglob("*") if one.is_file())
        built |= {str(one) for one in files if one.suffix not in (".pyc", ".so") and "cadet_bench" not in one.parts}
    assert built <= packed


def test_every_extra_that_is_named_exists() -> None:
    extras = tomllib.loads((ROOT / "pyproject.toml").read_text())["project"]["optional-dependencies"]
    pages = [*(ROOT / "python").rglob("*.py"), *(ROOT / "docs").rglob("*.md"), ROOT / "README.md"]
    named = {name for page in pages for name in re.findall(r"cadet-sim\[(\w+)\]", page.read_text(encoding="utf-8"))}
    assert {"avod", "gym", "view"} <= named <= set(extras)


def test_every_exception_to_the_lint_is_of_files_that_exist() -> None:
    ruff = tomllib.loads((ROOT / "pyproject.toml").read_text())["tool"]["ruff"]
    patterns = [name if "/" in name else f"python/**/{name}" for name in ruff["lint"]["per-file-ignores"]]
    assert patterns and [pattern for pattern in patterns if not any(ROOT.glob(pattern))] == []


def test_the_workflow_tests_every_python_that_the_package_names() -> None:
    project = tomllib.loads((ROOT / "pyproject.toml").read_text())["project"]
    named = re.findall(r"Programming Language :: Python :: (3\.\d+)", "\n".join(project["classifiers"]))
    workflow = (ROOT / ".github" / "workflows" / "test.yml").read_text()
    (tested,) = re.findall(r"^ +python: \[(.*)\]$", workflow, re.MULTILINE)
    assert re.findall(r'"(\S+?)"', tested) == named and project["requires-python"] == f">={named[0]}"


def test_the_workflow_checks_golden_frames_where_they_are_promised() -> None:
    """README: identical bytes are guaranteed on Linux on x86-64 alone."""
    workflow = (ROOT / ".github" / "workflows" / "wheels.yml").read_text()
    golden = dict(re.findall(r"\{name: (\S+),.*golden: (\w+)\}", workflow))
    assert {name for name, is_checked in golden.items() if is_checked == "true"} == {"linux-x86_64"}
    assert {name.split("-")[0] for name in golden} == {"linux", "macos", "windows"} and "linux-aarch64" in golden
    test = re.search(r"(tests/\S+)::(\w+)", workflow)
    assert test is not None and f"def {test[2]}(" in (ROOT / test[1]).read_text()


def test_processors_and_signals_are_the_systems(monkeypatch: pytest.MonkeyPatch) -> None:
    assert ENDING_SIGNALS == (signal.SIGTERM, signal.SIGHUP)
    assert num_processors() == len(os.sched_getaffinity(0))
    monkeypatch.setattr(sys, "platform", "darwin")
    monkeypatch.setattr(os, "cpu_count", lambda: 7)
    assert num_processors() == 7


def test_a_folder_is_held_by_one_at_a_time(tmp_path: Path) -> None:
    lock = tmp_path / "lock"
    with locked_folder(tmp_path, lock), pytest.raises(FolderInUseError), locked_folder(tmp_path, lock):
        pass
    with locked_folder(tmp_path, lock):
        pass
    assert list(tmp_path.iterdir()) == [], "the folder itself is locked"
