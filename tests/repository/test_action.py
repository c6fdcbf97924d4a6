"""The GitHub Action: its shell steps make the dataset of a recipe once, and what the cache holds is left as it is."""

from __future__ import annotations

import os
import re
import shutil
import subprocess
import sys
import zipfile
from collections.abc import Mapping
from pathlib import Path

import pytest
import yaml

import cadet
from cadet.generate import Recipe, generate
from composite_action import Outputs, Run
from gen_process import tree

ROOT = Path(__file__).parents[2]
ACTION = yaml.safe_load((ROOT / "action.yml").read_text(encoding="utf-8"))
RECIPE = """
seed = 4
num_frames = 2
lidar = "vlp16"
image_size = [64, 32]
"""


class Cache:
    """Stands in for actions/cache: folders by key, and how often one was saved."""

    def __init__(self, folder: Path) -> None:
        self.folder = folder
        self.num_saved = 0

    def restore(self, given: Mapping[str, str]) -> Outputs:
        stored = self.folder / given["key"]
        if stored.is_dir():
            shutil.copytree(stored, given["path"])
        return {"cache-primary-key": given["key"], **({"cache-hit": "true"} if stored.is_dir() else {})}

    def save(self, given: Mapping[str, str]) -> Outputs:
        self.num_saved += 1
        shutil.copytree(given["path"], self.folder / given["key"])
        return {}


@pytest.fixture(scope="module")
def wheel(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """Return the wheel that `make wheel` builds, from what is compiled already."""
    folder = tmp_path_factory.mktemp("wheels")
    maturin = Path(sys.executable).with_name("maturin")
    command: list[str | Path] = [maturin, "build", "--release", "--locked", "--quiet", "--out", folder]
    subprocess.run(command, cwd=ROOT, env={**os.environ, "PYO3_PYTHON": sys.executable}, check=True)
    (path,) = folder.iterdir()
    return path


class Job:
    """Runs of the action, each on a runner that holds nothing yet, beside one cache."""

    def __init__(self, folder: Path, wheel: Path) -> None:
        self.folder, self.wheel = folder, wheel
        self.cache = Cache(folder / "cache")

    def run(self, recipe: str, **files: str) -> Run:
        """Begin a run in a workspace that holds files, by name without `.toml`."""
        runner = self.folder / "runner"
        shutil.rmtree(runner, ignore_errors=True)
        for name in ("workspace", "temp"):
            (runner / name).mkdir(parents=True)
        for name, text in files.items():
            (runner / "workspace" / f"{name}.toml").write_text(text)
        return Run(
            ROOT / "action.yml",
            runner / "workspace",
            runner / "temp",
            {"recipe": recipe, "out": "data/set", "package": str(self.wheel)},
            {
                "actions/setup-python": lambda given: {"python-path": sys.executable},
                "actions/cache/restore": self.cache.restore,
                "actions/cache/save": self.cache.save,
            },
        )


@pytest.fixture
def job(tmp_path: Path, wheel: Path, monkeypatch: pytest.MonkeyPatch) -> Job:
    # What the package needs is there.
    monkeypatch.setenv("PIP_NO_DEPS", "1")
    monkeypatch.setenv("PIP_NO_COMPILE", "1")
    # The workflow's own modules are not the action's.
    monkeypatch.setenv("PYTHONPATH", str(tmp_path / "modules"))
    (tmp_path / "modules" / "cadet").mkdir(parents=True)
    (tmp_path / "modules" / "cadet" / "__init__.py").write_text("raise ImportError('the workflow has its own')")
    return Job(tmp_path, wheel)


def test_a_dataset_is_made_once_and_then_comes_from_the_cache(job: Job, tmp_path: Path) -> None:
    run = job.run(RECIPE)
    outputs = run.outputs()
    made = Path(outputs["path"])
    assert made == run.workspace / "data" / "set" and outputs["cache-hit"] == "false"
    assert (run.temp / "cadet" / "cadet" / "_cadet.abi3.so").is_file(), "the wheel is what ran"
    recipe = Recipe.from_toml(RECIPE)
    generate(tmp_path / "alike", recipe.settings, workers=1)
    first = tree(made)
    assert first == tree(tmp_path / "alike")

    run = job.run("mine.toml", mine=f"# The same, as a file.\n{RECIPE}")
    outputs = run.outputs()
    assert outputs["cache-hit"] == "true" and job.cache.num_saved == 1
    assert "2 frames (2 were there: it was complete)" in run.said
    assert tree(Path(outputs["path"])) == first

    outputs = job.run(RECIPE.replace("seed = 4", "seed = 5")).outputs()
    assert outputs["cache-hit"] == "false" and job.cache.num_saved == 2
    assert tree(Path(outputs["path"])) != first


def test_the_wheel_is_small_and_holds_the_package_alone(wheel: Path) -> None:
    assert wheel.stat().st_size < 15e6
    with zipfile.ZipFile(wheel) as archive:
        folders = {name.split("/", 1)[0] for name in archive.namelist()}
    info = f"cadet_sim-{cadet.__version__}.dist-info"
    assert {"cadet", "avod", info} <= folders <= {"cadet", "avod", info, "cadet_sim.libs"}


def test_a_recipe_that_is_none_ends_in_a_line(job: Job) -> None:
    run = job.run("frames = 2")
    with pytest.raises(subprocess.CalledProcessError):
        run.outputs()
    assert "recipe.toml: frames: unknown key" in run.said and "Traceback" not in run.said


def test_the_pages_workflow_fits_the_action() -> None:
    page = (ROOT / "docs" / "datasets.md").read_text(encoding="utf-8")
    (block,) = re.findall(r"^```yaml\n(.*?)^```$", page, re.MULTILINE | re.DOTALL)
    made, used = yaml.safe_load(block)
    assert set(made["with"]) <= set(ACTION["inputs"])
    assert Recipe.from_toml(made["with"]["recipe"]).settings.num_frames == 200
    (output,) = re.findall(rf"steps\.{made['id']}\.outputs\.(\w+)", used["run"])
    assert output in ACTION["outputs"]
    assert f"`{ACTION['inputs']['out']['default']}`" in page


def test_every_input_is_used() -> None:
    steps = yaml.safe_dump(ACTION["runs"]["steps"])
    assert ACTION["runs"]["using"] == "composite"
    assert [name for name in ACTION["inputs"] if f"${{{{ inputs.{name} }}}}" not in steps] == []
