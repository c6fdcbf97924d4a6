"""The code of README and docs, run as a reader would: in one folder, page by page, from top to bottom.

Fenced `python` and `sh` blocks are run, `toml` blocks parsed. A block that a comment `<!-- not run: REASON -->` stands
right before is left out. Python blocks of a page share their names. The folder holds what the pages speak of: `out` and
`set` (KITTI folders), `results` for `out`, `DIR` (own meshes), `bins` (own props), `run` (a checkpoint), `mine.toml`,
`town.xodr`, and other programs' `result.pkl`, `results_nusc.json` and `scenes`.
"""

from __future__ import annotations

import os
import pickle
import re
import shutil
import subprocess
import sys
from collections import Counter
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any

if sys.version_info >= (3, 11):
    import tomllib
else:
    import tomli as tomllib

import numpy as np
import pytest

import cadet
from cadet import kitti
from foreign_results import nuscenes_result, openpcdet_frames, write_results, write_tables
from mesh_files.obj_meshes import CAR, assets_folder
from small_runs import ROAD
from synthetic import make_frame

ROOT = Path(__file__).parents[2]
PAGES = ["README.md", "CONTRIBUTING.md", *sorted(f"docs/{path.name}" for path in (ROOT / "docs").glob("*.md"))]
LANGUAGES = ("python", "sh", "toml")

WAGON = CAR.replace("mine", "wagon")

_NUM_TRAIN, _NUM_VAL = 14, 2
_FENCE = re.compile(
    r"(?:<!-- not run: (?P<reason>[^\n]+) -->\n)?^```(?P<language>\w+)\n(?P<code>.*?)^```$", re.M | re.S
)
_NEEDS_TORCH = re.compile(r"\bavod\b")


@dataclass(frozen=True)
class Block:
    """A fenced block of a page."""

    language: str
    code: str
    line: int
    reason: str | None
    """Why it is not run; None if it is."""


def blocks_of(page: str) -> list[Block]:
    text = (ROOT / page).read_text(encoding="utf-8")
    return [
        Block(found["language"], found["code"], text.count("\n", 0, found.start("code")), found["reason"])
        for found in _FENCE.finditer(text)
    ]


@pytest.fixture(scope="module")
def folder(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """Make the folder that the pages' code runs in."""
    root = tmp_path_factory.mktemp("docs")
    frame = make_frame()
    for number in range(_NUM_TRAIN + _NUM_VAL):
        kitti.write_frame(
            root / "out", number, make_frame(seed=number), split="train" if number < _NUM_TRAIN else "val"
        )
    shutil.copytree(root / "out", root / "set")
    (root / "results").mkdir()
    labels = [replace(label, score=0.9) for label in frame.labels if not label.is_dont_care]
    for number in range(_NUM_TRAIN + _NUM_VAL):
        (root / "results" / f"{number:06d}.txt").write_text(kitti.text_from_labels(labels))
    assets_folder(root / "DIR", WAGON)
    (root / "mine.toml").write_text(cadet.Lidar.vlp16().to_toml())
    (root / "town.xodr").write_text(ROAD.xodr)
    (root / "result.pkl").write_bytes(pickle.dumps(openpcdet_frames()))
    (root / "scenes" / "v1.0-trainval").mkdir(parents=True)
    write_tables(root / "scenes" / "v1.0-trainval")
    write_results(root, nuscenes_result())
    (root / "bins").mkdir()
    (bin_file,) = (block.code for block in blocks_of("docs/props.md") if block.code.startswith("# bins/paper-bin.toml"))
    (root / "bins" / "paper-bin.toml").write_text(bin_file)
    shutil.copytree(ROOT / "python" / "avod" / "checkpoints" / "tiny_car", root / "run")
    _write_commands(root / "bin")
    return root


def _write_commands(folder: Path) -> None:
    """Write the three commands, so that those of these sources are run."""
    folder.mkdir()
    for command, module in (("cadet", "cadet"), ("cadet-gen", "cadet"), ("avod", "avod")):
        path = folder / command
        function = f"run_{command.replace('-', '_')}"
        # Workers import the script, as they do an installed one.
        called = f'if __name__ == "__main__":\n    {function}()\n'
        path.write_text(f"#!{sys.executable}\nfrom {module}.cli import {function}\n\n{called}")
        path.chmod(0o755)


def test_the_pages_have_code_that_is_run() -> None:
    found = [block for page in PAGES for block in blocks_of(page) if block.language in LANGUAGES]
    assert len([block for block in found if block.reason is None]) >= 8
    fences = sum(
        (ROOT / page).read_text(encoding="utf-8").count(f"\n```{name}\n") for page in PAGES for name in LANGUAGES
    )
    assert len(found) == fences, "every fenced block is found"


@pytest.mark.timeout(600)  # The tutorial generates 60 frames and detects in 20.
@pytest.mark.parametrize("page", PAGES)
def test_the_code_of_a_page_runs(page: str, folder: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.chdir(folder)
    names: dict[str, Any] = {"cadet": cadet, "np": np}
    for block in blocks_of(page):
        if block.reason is not None:
            continue
        if _NEEDS_TORCH.search(block.code):
            pytest.importorskip("torch", reason="needs torch")
        if block.language == "python":
            # The page's own line numbers, for what goes wrong.
            exec(compile("\n" * block.line + block.code, page, "exec"), names)
        elif block.language == "sh":
            _run_shell(block, page, folder)
        elif block.language == "toml":
            tomllib.loads(block.code)
    if page == "docs/tutorial.md":
        _check_counts((ROOT / page).read_text(encoding="utf-8"), folder / "first")


def _check_counts(page: str, written: Path) -> None:
    (line,) = re.findall(r"^60 frames in first at [\d.]+/s: (.*)$", page, re.M)
    stated = {name: int(count) for count, name in (part.split() for part in line.split(", "))}
    types = [
        text.split()[0] for path in written.glob("training/label_2/*.txt") for text in path.read_text().splitlines()
    ]
    assert dict(Counter(types)) == stated


def _run_shell(block: Block, page: str, folder: Path) -> None:
    path = os.pathsep.join([str(ROOT / "python"), os.environ.get("PYTHONPATH", "")])
    env = {**os.environ, "PATH": f"{folder / 'bin'}{os.pathsep}{os.environ['PATH']}", "PYTHONPATH": path}
    done = subprocess.run(
        ["bash", "-euc", block.code], cwd=folder, env=env, capture_output=True, text=True, check=False
    )
    assert done.returncode == 0, f"{page}:{block.line}: {done.stderr[-2000:]}"


def test_the_table_of_a_sensor_is_one() -> None:
    table = next(block.code for block in blocks_of("docs/lidars.md") if block.language == "toml")
    assert cadet.Lidar.custom(cadet.BeamTable.from_toml(table)).rays()[0].shape == (3 * 1800, 3)


def test_the_labels_page_states_the_annotators_habits_as_the_core_has_them() -> None:
    page = " ".join((ROOT / "docs/labels.md").read_text(encoding="utf-8").split())
    crates = ROOT / "crates"
    annotation = (crates / "cadet_assets/src/annotation/mod.rs").read_text(encoding="utf-8")
    farthest = re.findall(r"const (\w+)_FARTHEST_M: \(f64, f64\) = \(([\d.]+), ([\d.]+)\);", annotation)
    assert len(farthest) == 8
    for name, mean, sd in farthest:
        stated = rf"\b{float(mean):g} m \((standard deviation )?{float(sd):g}\) for"
        assert re.search(stated, page), name
    (least,) = re.findall(r"const LEAST_POINTS: \(usize, usize\) = \((\d+), (\d+)\);", annotation)
    assert "It needs {} to {} returns".format(*least) in page
    visible = (crates / "cadet_sensors/src/label/config.rs").read_text(encoding="utf-8")
    numbers = [re.findall(rf"const {name}: f64 = ([\d.]+);", visible)[0] for name in ("FROM_M", "MORE_PER_M", "MOST")]
    assert "grows beyond {:g} m by {} a meter, up to {}".format(float(numbers[0]), *numbers[1:]) in page
