"""Training, detection, and evaluation read the same kinds of data: folders, shards, and the simulator."""

from __future__ import annotations

import json
from pathlib import Path
from typing import Any

import pytest
from click.testing import CliRunner, Result

from avod.cli.commands import avod
from avod.data import simulated
from cadet.errors import CadetError
from cadet.formats.convert import convert
from cadet.formats.kitti import write_frame
from cadet.simulation.simulation import Simulation
from detector.runs import short_run, small_config, write_set

COUNT = 2
KINDS = ("folder", "shards", "named shards", "simulation")


@pytest.fixture(scope="module")
def data(tmp_path_factory: pytest.TempPathFactory) -> dict[str, str]:
    """Return names of one set of frames, and of a folder with a simulation's first frames."""
    folder = tmp_path_factory.mktemp("frames")
    convert(write_set(folder / "set", 3, COUNT), folder / "shards", "webdataset", shard_size=1)
    town = folder / "town.toml"
    town.write_text('seed = 3\nlidar = "vlp16"\nimage_size = [310, 94]\nsamples_per_episode = 2\n')
    with Simulation.read(town).stream(workers=0) as frames:
        for number, frame in zip(range(COUNT), frames, strict=False):
            write_frame(folder / "simulated", number, frame, split="val")
    return {
        "folder": str(folder / "set"),
        "shards": str(folder / "shards"),
        "named shards": str(folder / "shards" / "val" / "{000000..000001}.tar"),
        "simulation": f"sim:{town}",
        "simulation's folder": str(folder / "simulated"),
    }


@pytest.fixture(scope="module")
def run(data: dict[str, str], tmp_path_factory: pytest.TempPathFactory) -> Path:
    folder = tmp_path_factory.mktemp("run")
    short_run(small_config(folder), data["folder"], folder / "run", 1)
    return folder / "run"


def call(command: str, run: Path, data: str, *arguments: object) -> Result:
    options = ("--checkpoint", run, "--data", data, "--workers", 1, "--score-threshold", 0.0, *arguments)
    done = CliRunner().invoke(avod, [command, *map(str, options)], catch_exceptions=False)
    assert done.exit_code == 0, done.output
    return done


@pytest.mark.parametrize("kind", KINDS)
def test_what_trains_is_detected_in_and_evaluated(
    data: dict[str, str], run: Path, tmp_path: Path, kind: str, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(simulated, "BLOCK", 2)
    short_run(small_config(tmp_path), data[kind], tmp_path / "trained", 1)
    folder = data["simulation's folder" if kind == "simulation" else "folder"]
    split = () if kind in ("named shards", "simulation") else ("--split", "val")
    found: list[Any] = []
    expected: list[Any] = []
    for name, values, options in ((data[kind], found, split), (folder, expected, ("--split", "val"))):
        out = tmp_path / str(len(values)) / name.replace("/", "_")
        call("predict", run, name, "--frames", COUNT, "--out", out, *options)
        values += [(path.name, path.read_bytes()) for path in sorted(out.iterdir())]
        values.append(json.loads(call("eval", run, name, "--frames", COUNT, "--json", *options).stdout))
    assert len(found) == COUNT + 1 and any(text for _, text in found[:COUNT])
    assert found == expected


@pytest.mark.parametrize("kind", ["named shards", "simulation"])
def test_what_has_no_splits_refuses_one(data: dict[str, str], run: Path, kind: str) -> None:
    with pytest.raises(CadetError, match="--split: shards that --data names are all read, and a simulation has no"):
        call("eval", run, data[kind], "--frames", 1, "--split", "train")


def test_a_simulation_has_no_end(data: dict[str, str], run: Path) -> None:
    with pytest.raises(CadetError, match=r"town\.toml: a simulation has no end: say by --frames how many"):
        call("eval", run, data["simulation"])
