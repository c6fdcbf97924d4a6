"""What a training keeps of itself: which files, written whole, and what they say of where they come from."""

from __future__ import annotations

import dataclasses
import json
import subprocess
from pathlib import Path

import pytest
import torch

from avod.config import Config
from avod.train import checkpoint as checkpoint_module
from avod.train.checkpoint import checkpoints, read_checkpoint
from avod.train.settings import commit
from cadet import __version__
from cadet.errors import CadetError
from detector.runs import StopAfter, assert_same_training, short_run, small_config, weights


@pytest.fixture(scope="module")
def config(folder: Path) -> Config:
    config = small_config(folder)
    return dataclasses.replace(config, training=dataclasses.replace(config.training, checkpoint_steps=1))


def files_of(run: Path) -> dict[str, list[str]]:
    return {path.name: sorted(file.name for file in path.iterdir()) for path in (run / "checkpoints").iterdir()}


def test_only_the_newest_checkpoint_holds_what_only_training_needs(config: Config, data: Path, tmp_path: Path) -> None:
    old = ["checkpoint.json", "model.safetensors"]
    short_run(config, data, tmp_path / "all", 3)
    assert files_of(tmp_path / "all") == {
        "000000001": old, "000000002": old, "000000003": [*old, "optimizer.safetensors"]
    }  # fmt: skip
    short_run(config, data, tmp_path / "two", 6, keep=2, should_stop=StopAfter(4))
    assert files_of(tmp_path / "two") == {"000000003": old, "000000004": [*old, "optimizer.safetensors"]}
    # What is kept can be changed when the training goes on.
    short_run(config, data, tmp_path / "two", 6, keep=1, resume=True)
    assert list(files_of(tmp_path / "two")) == ["000000006"]
    short_run(config, data, tmp_path / "whole", 6)
    assert_same_training(tmp_path / "two", tmp_path / "whole")


def test_a_checkpoint_says_where_it_comes_from(config: Config, data: Path, tmp_path: Path) -> None:
    last = short_run(config, data, tmp_path, 1, seed=3)
    settings = json.loads((last / "checkpoint.json").read_text())
    assert settings["data"] == str(data) and settings["split"] == "train" and settings["seed"] == 3
    assert settings["made_with"]["cadet"] == __version__ and settings["made_with"]["torch"] == torch.__version__
    record = json.loads((tmp_path / "run.json").read_text())
    assert record["num_used"] == 3 and record["made_with"] == settings["made_with"]


def test_the_commit_is_that_of_the_packages_own_working_copy(tmp_path: Path) -> None:
    def git(*arguments: str) -> str:
        identity = ("-c", "user.name=a", "-c", "user.email=a@b")
        command = ["git", "-C", str(tmp_path), *identity, *arguments]
        return subprocess.run(command, check=True, capture_output=True, text=True).stdout.strip()

    package = tmp_path / "package"
    package.mkdir()
    (package / "__init__.py").write_text("")
    assert commit(package) is None
    git("init", "-q")
    commit.cache_clear()
    assert commit(package) is None, "an untracked folder, such as an environment's, is not of this commit"
    git("add", ".")
    git("commit", "-q", "-m", "first")
    commit.cache_clear()
    assert commit(package) == git("rev-parse", "HEAD")
    (package / "__init__.py").write_text("changed = True\n")
    commit.cache_clear()
    assert commit(package) == git("rev-parse", "HEAD") + "+changes"
    commit.cache_clear()


@pytest.mark.parametrize("file", ["model.safetensors", "optimizer.safetensors", "checkpoint.json"])
def test_a_training_that_dies_while_it_writes_keeps_its_last_checkpoint(
    config: Config, data: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch, file: str
) -> None:
    out = tmp_path / "run"
    first = short_run(config, data, out, 3, should_stop=StopAfter(1))

    class DiedError(Exception):
        pass

    def die(path: Path, content: bytes) -> None:
        path.write_bytes(content[: len(content) // 2])
        if path.name == file:
            raise DiedError

    with monkeypatch.context() as patch:
        patch.setattr(checkpoint_module, "_write", die)
        with pytest.raises(DiedError):
            short_run(config, data, out, 3, resume=True)
    assert checkpoints(out / "checkpoints") == [first] and (first / "optimizer.safetensors").is_file()
    assert any(path.name.endswith(".partial") for path in (out / "checkpoints").iterdir())
    short_run(config, data, out, 3, resume=True)
    assert sorted(files_of(out)) == ["000000001", "000000002", "000000003"], "what was half written is gone"
    short_run(config, data, tmp_path / "whole", 3)
    assert_same_training(out, tmp_path / "whole")


def test_pending_sums_that_are_no_numbers_are_refused(config: Config, data: Path, tmp_path: Path) -> None:
    last = short_run(config, data, tmp_path, 2, should_stop=StopAfter(1))
    settings = last / "checkpoint.json"
    table = json.loads(settings.read_text())
    assert table["pending"]["count"] == 1
    for wrong in ([1.0], {"count": "one"}, {"count": None}):
        settings.write_text(json.dumps(table | {"pending": wrong}))
        with pytest.raises(CadetError, match=r"checkpoint\.json: pending: expected finite numbers by name"):
            read_checkpoint(last)


def test_checkpoints_from_before_load(config: Config, data: Path, tmp_path: Path) -> None:
    last = short_run(config, data, tmp_path, 1)
    expected = weights(last)
    table = json.loads((last / "checkpoint.json").read_text())
    for name in ("data", "split", "pending"):
        table.pop(name)
    del table["made_with"]["commit"], table["config"]["detection"]["suppression"]
    (last / "checkpoint.json").write_text(json.dumps(table))
    assert read_checkpoint(last).config == dataclasses.replace(
        config, training=dataclasses.replace(config.training, steps=1)
    )
    assert all(torch.equal(tensor, expected[name]) for name, tensor in weights(last).items())
