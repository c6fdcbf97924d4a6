"""`cadet-gen --format parquet`: what pyarrow and Hugging Face's `datasets` read, against the seed's KITTI folder."""

from __future__ import annotations

import json
import shutil
import sys
from collections.abc import Callable
from dataclasses import asdict
from functools import partial
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from cadet import kitti
from cadet.cli import run_cadet_gen
from cadet.errors import CadetError
from cadet.formats.kitti.calib import KEYS
from cadet.formats.parquet import parquet_format, rows
from cadet.formats.parquet.parquet_format import ParquetShard
from gen_process import FINE, SIZE, flip, run, tree
from small_runs import make

NUM_FRAMES = 10
write = partial(make, num_frames=NUM_FRAMES, format="parquet", shard_size=5)


@pytest.fixture(scope="module")
def as_kitti(tmp_path_factory: pytest.TempPathFactory) -> Path:
    out = tmp_path_factory.mktemp("kitti") / "out"
    make(out, NUM_FRAMES)
    return out


@pytest.fixture(scope="module")
def out(tmp_path_factory: pytest.TempPathFactory) -> Path:
    pytest.importorskip("pyarrow", reason="needs pyarrow")
    out = tmp_path_factory.mktemp("parquet") / "out"
    write(out)
    return out


def rows_of(path: Path) -> list[dict[str, Any]]:
    import pyarrow.parquet as pq

    found: list[dict[str, Any]] = pq.read_table(path).to_pylist()
    return found


def test_shards_hold_the_frames_of_each_split_in_order(out: Path, as_kitti: Path) -> None:
    sizes = {path.name: len(rows_of(path)) for path in sorted((out / "data").iterdir())}
    assert sizes == {"train-00000.parquet": 5, "train-00001.parquet": 1, "validation-00000.parquet": 4}
    for split, name in (("train", "train"), ("val", "validation")):
        ids = [row["id"] for path in sorted((out / "data").glob(f"{name}-*")) for row in rows_of(path)]
        assert ids == (as_kitti / "ImageSets" / f"{split}.txt").read_text().split()
    folders = {"data", "ImageSets", "README.md", "manifest.json", "run.json"}
    assert {path.name for path in out.iterdir()} == folders


def test_rows_are_the_frames_of_the_same_seeds_folder(out: Path, as_kitti: Path) -> None:
    found = [row for path in (out / "data").iterdir() for row in rows_of(path)]
    assert len(found) == NUM_FRAMES
    for row in found:
        frame = kitti.read_frame(as_kitti, row["id"])
        files = as_kitti / "training"
        assert row["image"] == {"bytes": (files / "image_2" / f"{row['id']}.png").read_bytes(), "path": None}
        assert row["points_velo"] == (files / "velodyne" / f"{row['id']}.bin").read_bytes()
        points_velo = np.frombuffer(row["points_velo"], "<f4").reshape(-1, 4)
        np.testing.assert_array_equal(points_velo, frame.points_velo)
        labels = [
            {name: list(v) if isinstance(v, tuple) else v for name, v in asdict(one).items()} for one in frame.labels
        ]
        assert [{**label, "score": None} for label in row["labels"]] == labels and labels
        for key in KEYS:
            np.testing.assert_array_equal(np.array(row["calib"][key]), getattr(frame.calib, key))
        assert frame.plane is not None and row["plane"] == frame.plane.tolist()
        assert frame.meta is not None and json.loads(row["meta"]) == frame.meta
        assert {name: row[name] for name in rows.FACTS} == {name: frame.meta[name] for name in rows.FACTS}


def test_the_manifest_has_the_hashes_of_the_folders_files(out: Path, as_kitti: Path) -> None:
    ours, theirs = (json.loads((root / "manifest.json").read_text())["sha256"] for root in (out, as_kitti))
    of_shards = {name.rpartition("/")[2]: digest for name, digest in ours.items() if ".parquet/" in name}
    named = {tuple(name.removeprefix("training/").split("/")): digest for name, digest in theirs.items()}
    expected = {f"{name[:6]}.{kind}{name[6:]}": digest for (kind, name), digest in named.items() if kind != "ImageSets"}
    assert of_shards == expected


@pytest.mark.parametrize("num_rows", [1, 3])
def test_files_come_back_byte_for_byte_from_any_place(
    num_rows: int, as_kitti: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    pytest.importorskip("pyarrow", reason="needs pyarrow")
    monkeypatch.setattr(parquet_format, "_ROWS_AT_ONCE", num_rows)
    write(tmp_path / "out", shard_size=6)
    shard = ParquetShard(tmp_path / "out" / "data" / "train-00000.parquet")
    assert len(shard.members) == 6 * len(rows.KINDS)
    for name in reversed(shard.members):
        frame_id, kind, suffix = name.split(".")
        assert shard.read(name) == (as_kitti / "training" / kind / f"{frame_id}.{suffix}").read_bytes()
    with pytest.raises(KeyError):
        shard.read("000099.image_2.png")


def test_neither_workers_nor_the_order_of_episodes_nor_stops_change_a_byte(out: Path, tmp_path: Path) -> None:
    write(tmp_path / "other", episodes=(2, 0, 1))
    assert tree(tmp_path / "other") == tree(out)
    options = (*SIZE, "--seed", 3, "--format", "parquet", "--shard-size", 5, "--workers", 2)
    assert run(tmp_path / "two", "-n", 9, *options).returncode == FINE
    first = tmp_path / "two" / "data" / "train-00000.parquet"
    written_ns = first.stat().st_mtime_ns
    write(tmp_path / "two")
    assert tree(tmp_path / "two") == tree(out)
    assert first.stat().st_mtime_ns == written_ns


@pytest.mark.parametrize(
    "damage",
    [
        lambda data: (data / "train-00000.parquet").unlink(),
        lambda data: shutil.rmtree(data),
        lambda data: shutil.copy(data / "validation-00000.parquet", data / "train-00000.parquet"),
        lambda data: (data / "train-00000.parquet").write_bytes((data / "train-00000.parquet").read_bytes()[:-9]),
        lambda data: flip(data / "train-00000.parquet", 1000),  # in an image
        lambda data: flip(data / "train-00000.parquet", -3),  # in the last mark
        lambda data: flip(data / "train-00000.parquet", -700),  # in the columns' types
    ],
)
def test_resuming_mends_what_is_damaged(out: Path, tmp_path: Path, damage: Callable[[Path], object]) -> None:
    shutil.copytree(out, tmp_path / "out")
    damage(tmp_path / "out" / "data")
    write(tmp_path / "out")
    assert tree(tmp_path / "out") == tree(out)


def test_a_file_with_other_columns_is_not_taken_for_ours(out: Path, tmp_path: Path) -> None:
    import pyarrow.parquet as pq

    table = pq.read_table(out / "data" / "train-00000.parquet")
    pq.write_table(table.drop_columns("plane"), tmp_path / "less.parquet")
    with pytest.raises(CadetError, match=r"^less\.parquet: .*other columns"):
        ParquetShard(tmp_path / "less.parquet")


def test_the_card_is_one_that_the_hub_reads(out: Path) -> None:
    hub = pytest.importorskip("huggingface_hub", reason="needs huggingface_hub")
    card = hub.DatasetCard.load(out / "README.md", ignore_metadata_errors=False)
    (config,) = card.data.configs
    assert [one["split"] for one in config["data_files"]] == ["train", "validation"]
    assert card.data.license == "other" and card.data.size_categories == ["n<1K"]
    columns = [line.split("`")[1] for line in card.text.splitlines() if line.startswith("| `")]
    assert columns == list(rows.schema().names)
    assert str(out) not in card.content


def test_datasets_loads_the_folder(out: Path, as_kitti: Path, tmp_path: Path) -> None:
    datasets = pytest.importorskip("datasets", reason="needs datasets")
    loaded = datasets.load_dataset(str(out), cache_dir=str(tmp_path))
    assert {split: len(one) for split, one in loaded.items()} == {"train": 6, "validation": 4}
    for split in loaded.values():
        assert split.column_names == list(rows.COLUMNS)
        assert isinstance(split.features["image"], datasets.Image)
        for row in split:
            frame = kitti.read_frame(as_kitti, row["id"])
            np.testing.assert_array_equal(np.asarray(row["image"]), frame.image)
            assert [label["type"] for label in row["labels"]] == [label.type for label in frame.labels]
            assert row["district"] == (frame.meta or {})["district"]
    by_hand = datasets.load_dataset(
        "parquet", data_files={"train": str(out / "data" / "train-*")}, cache_dir=str(tmp_path)
    )
    assert by_hand["train"].features == loaded["train"].features


def test_datasets_loads_tar_shards_by_their_card(as_kitti: Path, tmp_path: Path) -> None:
    datasets = pytest.importorskip("datasets", reason="needs datasets")
    make(tmp_path / "out", NUM_FRAMES, format="webdataset", shard_size=5)
    loaded = datasets.load_dataset(str(tmp_path / "out"), cache_dir=str(tmp_path / "cache"))
    assert {split: len(one) for split, one in loaded.items()} == {"train": 6, "validation": 4}
    row = loaded["validation"][0]
    frame = kitti.read_frame(as_kitti, row["__key__"])
    np.testing.assert_array_equal(np.asarray(row["image_2.png"]), frame.image)


def test_without_pyarrow_one_line_says_what_to_install(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    monkeypatch.setitem(sys.modules, "pyarrow", None)
    monkeypatch.setattr("sys.argv", ["cadet-gen", str(tmp_path / "out"), "--format", "parquet"])
    rows.schema.cache_clear()
    with pytest.raises(SystemExit) as ended:
        run_cadet_gen()
    assert ended.value.code == 2
    assert "--format parquet needs pyarrow: pip install 'cadet-sim[parquet]'" in capsys.readouterr().err
    assert not (tmp_path / "out").exists()
