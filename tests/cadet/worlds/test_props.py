"""Folders of props: what is read, and what a dataset records of them."""

from __future__ import annotations

import json
import pickle
import shutil
from pathlib import Path

import pytest

from cadet import Assets, CadetError, MissingFileError, Props, ResetPolicy, Simulation
from gen_process import FAILED, FINE, SIZE, run

BIN = """levels_m = [20, 40, 90]
parts = [{ of = "steel", block = "1, 1, 1", at = "0, 0, 0.5" }]
place = [{ where = "yard", weight = 1 }]
"""


def props_folder(root: Path, **files: str) -> Path:
    root.mkdir()
    for name, text in (files or {"own_bin": BIN}).items():
        (root / f"{name.replace('_', '-')}.toml").write_text(text)
    return root


def test_a_folder_is_read_by_name_and_hashed_by_its_texts(tmp_path: Path) -> None:
    props = Props.read(props_folder(tmp_path / "one", own_bin=BIN, a_bench=BIN))
    (tmp_path / "one" / "notes.txt").write_text("no prop")
    assert [name for name, _ in props.files] == ["a-bench.toml", "own-bin.toml"]
    assert props == Props.read(tmp_path / "one") == pickle.loads(pickle.dumps(props))
    other = Props.read(props_folder(tmp_path / "two", own_bin=BIN + "# changed\n", a_bench=BIN))
    hashes = [[entry["sha256"] for entry in read.to_list()] for read in (props, other)]
    assert hashes[0][0] == hashes[1][0] != hashes[1][1]
    assert "own-bin" in repr(props)


def test_props_stand_beside_vehicles_or_alone(tmp_path: Path) -> None:
    props = Props.read(props_folder(tmp_path / "own"))
    policy = ResetPolicy.kitti().with_props(props)
    assert policy.assets == Assets(props=props)
    assert policy.to_dict()["assets"] == {"props": props.to_list()}
    with pytest.raises(CadetError, match="expected at least one actor"):
        Assets()
    with pytest.raises(CadetError, match=r"assets\.props"):
        Assets(props="own")  # type: ignore[arg-type]
    (tmp_path / "mine.toml").write_text('props = "own"')
    assert Simulation.read(tmp_path / "mine.toml").policy.assets == Assets(props=props)


def test_missing_folders_and_files_are_named(tmp_path: Path) -> None:
    with pytest.raises(MissingFileError, match="no such folder"):
        Props.read(tmp_path / "none")
    (tmp_path / "empty").mkdir()
    with pytest.raises(MissingFileError, match=r"no \.toml file in it"):
        Props.read(tmp_path / "empty")
    (tmp_path / "empty" / "bin.toml").write_bytes(b"\xff")
    with pytest.raises(CadetError, match="UTF-8"):
        Props.read(tmp_path / "empty")
    for files in ("bin", ("bin",), (("bin.toml", 3),)):
        with pytest.raises(CadetError, match=r"props\.files"):
            Props(files)  # type: ignore[arg-type]


def test_a_run_goes_on_with_the_same_props_only(tmp_path: Path) -> None:
    own, out = props_folder(tmp_path / "own"), tmp_path / "out"
    arguments = (out, "-n", 2, *SIZE, "--seed", 3, "--workers", 1)
    assert run(*arguments, "--props", own).returncode == FINE
    for name in ("run.json", "manifest.json"):
        text = (out / name).read_text()
        assert json.loads(text)["policy"]["assets"] == {"props": Props.read(own).to_list()}
        assert str(tmp_path) not in text
    moved = tmp_path / "moved"
    shutil.move(own, moved)
    assert run(*arguments, "--resume", "--props", moved).returncode == FINE, "where they lie does not matter"
    without = run(*arguments, "--resume")
    assert without.returncode == FAILED
    assert "was begun with other settings: policy.assets was " in without.stderr
    (moved / "own-bin.toml").write_text(BIN.replace("steel", "wood"))
    changed = run(*arguments, "--resume", "--props", moved)
    assert changed.returncode == FAILED
    assert "policy.assets.props was" in changed.stderr
