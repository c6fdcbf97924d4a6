"""`cadet-gen --format webdataset`: KITTI's bytes in shards, whatever workers, kills, and damage."""

from __future__ import annotations

import gc
import json
import os
import shutil
import signal
import tarfile
from collections.abc import Callable
from functools import partial, partialmethod
from pathlib import Path
from typing import Any

import pytest

from cadet import ResetPolicy
from cadet._util.sink import LocalSink
from cadet.errors import CadetError
from cadet.formats.convert import convert
from cadet.generate import Settings
from cadet.generate.folder import open_folder
from gen_process import FINE, SIZE, flip, run, start, tree, wait_for, write_whole
from small_runs import make, small_settings

SHARDS = ("-n", 10, "--seed", 3, *SIZE, "--format", "webdataset", "--shard-size", 2)


@pytest.fixture(scope="module")
def as_kitti(tmp_path_factory: pytest.TempPathFactory) -> Path:
    return write_whole(tmp_path_factory)


@pytest.fixture(scope="module")
def shards(tmp_path_factory: pytest.TempPathFactory) -> Path:
    out = tmp_path_factory.mktemp("shards") / "out"
    done = run(out, *SHARDS, "--workers", 1)
    assert (done.returncode, done.stdout) == (FINE, "")
    return out


def members(path: Path) -> dict[str, bytes]:
    """Return an archive's files as the standard library reads them."""
    with tarfile.open(path, "r:") as tar:
        return {info.name: tar.extractfile(info).read() for info in tar}  # type: ignore[union-attr]


def test_shards_hold_the_bytes_of_kittis_files_in_its_splits(shards: Path, as_kitti: Path) -> None:
    found: dict[str, bytes] = {}
    for split, num_samples in (("train", 6), ("val", 4)):
        ids: list[str] = []
        paths = sorted((shards / split).glob("*.tar"))
        assert [path.name for path in paths] == [f"{k:06d}.tar" for k in range(-(-num_samples // 2))]
        for path in paths:
            files = members(path)
            in_shard = list(dict.fromkeys(name[:6] for name in files))
            assert len(in_shard) == 2 or path == paths[-1]
            ids += in_shard
            found |= files
        assert ids == (as_kitti / "ImageSets" / f"{split}.txt").read_text().split()
    expected = {
        f"{path.stem}.{path.parent.name}{path.suffix}": path.read_bytes()
        for path in (as_kitti / "training").glob("*/*")
    }
    assert found == expected
    for path in (as_kitti / "ImageSets").iterdir():
        assert (shards / "ImageSets" / path.name).read_bytes() == path.read_bytes()
    names = {"ImageSets", "train", "val", "README.md", "run.json", "manifest.json"}
    assert {path.name for path in shards.iterdir()} == names


def test_converting_the_folder_gives_the_same_shards_and_back(shards: Path, as_kitti: Path, tmp_path: Path) -> None:
    of_run = ("run.json", "manifest.json", "croissant.json", "README.md")

    def without_run(root: Path) -> dict[str, str]:
        return {name: digest for name, digest in tree(root).items() if name not in of_run}

    convert(as_kitti, tmp_path / "shards", "webdataset", shard_size=2)
    assert tree(tmp_path / "shards") == without_run(shards)
    convert(shards, tmp_path / "kitti", "kitti")
    assert tree(tmp_path / "kitti") == without_run(as_kitti)
    assert (tmp_path / "kitti" / "testing" / "calib").is_dir()


def test_headers_hold_nothing_of_the_machine(shards: Path) -> None:
    with tarfile.open(shards / "train" / "000000.tar", "r:") as tar:
        for info in tar:
            assert (info.mtime, info.uid, info.gid, info.uname, info.gname, info.mode) == (0, 0, 0, "", "", 0o644)
            assert info.isreg() and not info.pax_headers


def test_the_index_says_where_the_standard_library_finds_the_data(shards: Path) -> None:
    for path in shards.glob("*/*.tar"):
        with tarfile.open(path, "r:") as tar:
            expected = [(info.name.split(".", 1)[1], str(info.offset_data), str(info.size), info.name) for info in tar]
        head, *lines = path.with_suffix(".idx").read_text().splitlines()
        assert head == f"v1.2 {len(lines)}"
        fields = [line.split(" ") for line in lines]
        assert [tuple(line[k : k + 4]) for line in fields for k in range(0, len(line), 4)] == expected


def test_the_manifest_names_every_member(shards: Path, as_kitti: Path) -> None:
    ours, theirs = (json.loads((root / "manifest.json").read_text()) for root in (shards, as_kitti))
    assert ours["counts"] == theirs["counts"]
    assert ours["shard_size"] == 2
    in_shards = {name.rpartition("/")[2]: digest for name, digest in ours["sha256"].items() if ".tar/" in name}
    in_folders = {
        f"{name[-10:].partition('.')[0]}": digest for name, digest in theirs["sha256"].items() if "image_2" in name
    }
    assert {name[:6]: digest for name, digest in in_shards.items() if "image_2" in name} == in_folders


@pytest.mark.filterwarnings("ignore::pytest.PytestUnraisableExceptionWarning")
def test_the_webdataset_library_reads_them(shards: Path) -> None:
    webdataset = pytest.importorskip("webdataset", reason="needs webdataset")
    pattern = str(shards / "train" / "{000000..000002}.tar")
    samples = list(webdataset.WebDataset(pattern, shardshuffle=False, empty_check=False))
    gc.collect()  # It leaves files open.
    assert [sample["__key__"] for sample in samples] == (shards / "ImageSets" / "train.txt").read_text().split()
    expected = members(shards / "train" / "000000.tar")
    for sample in samples[:2]:
        files = {f"{sample['__key__']}.{kind}": data for kind, data in sample.items() if not kind.startswith("__")}
        assert files == {name: data for name, data in expected.items() if name.startswith(sample["__key__"])}


write = partial(make, format="webdataset", shard_size=2)


def test_any_order_of_episodes_gives_the_same_bytes(shards: Path, tmp_path: Path) -> None:
    write(tmp_path / "out", 10, episodes=(2, 0, 1))
    assert tree(tmp_path / "out") == tree(shards)


def test_a_larger_n_adds_to_the_last_shard_alone(shards: Path, tmp_path: Path) -> None:
    out = tmp_path / "out"
    write(out, 3)
    before = tree(out)
    write(out, 10)
    after = tree(out)
    assert after == tree(shards)
    assert after["train/000000.tar"] == before["train/000000.tar"]
    assert after["train/000001.tar"] != before["train/000001.tar"]
    with pytest.raises(CadetError, match="has frames up to 000009 already"):
        write(out, 3)


def test_after_kill_9_two_workers_write_the_same_shards(shards: Path, tmp_path: Path) -> None:
    out = tmp_path / "out"
    with start(out, *SHARDS, "--workers", 2, fault="slow=0.5") as process:
        wait_for(out / "train" / "000000.tar", process)
        os.killpg(process.pid, signal.SIGKILL)
    assert not (out / "manifest.json").exists()
    # What is being written lies in `.partial`.
    for path in out.glob("[!.]*/*.tar"):
        assert path.read_bytes() == (shards / path.relative_to(out)).read_bytes()
    assert run(out, *SHARDS, "--resume", "--workers", 2).returncode == FINE
    assert tree(out) == tree(shards)


class _KilledError(Exception):
    pass


def test_wherever_a_run_is_killed_resuming_gives_the_same_shards(
    shards: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """At every write of shards and indexes, before and after it, and at some of the samples'."""
    puts: list[str] = []
    put = LocalSink.put

    def counted(self: LocalSink, name: str, data: Any, *, dies_at: int | None = None, is_done: bool = False) -> None:
        puts.append(name)
        dies = len(puts) - 1 == dies_at
        if not dies or is_done:
            put(self, name, data)
        if dies:
            raise _KilledError(name)

    monkeypatch.setattr(LocalSink, "put", counted)
    write(tmp_path / "undisturbed", 5)
    expected = tree(tmp_path / "undisturbed")
    moments = [k for k, name in enumerate(puts) if ".staged" not in name or k % 23 == 5]
    assert len(moments) > 8
    for number, moment in enumerate(moments):
        for is_done in (False, True):
            out = tmp_path / f"{number}{is_done}"
            puts.clear()
            monkeypatch.setattr(LocalSink, "put", partialmethod(counted, dies_at=moment, is_done=is_done))
            with pytest.raises(_KilledError):
                write(out, 5)
            monkeypatch.setattr(LocalSink, "put", put)
            if not (out / "run.json").exists():
                continue
            write(out, 5)
            assert tree(out) == expected, (moment, is_done)


@pytest.mark.parametrize(
    "damage",
    [
        lambda train: (train / "000000.tar").unlink(),
        lambda train: (train / "000001.idx").unlink(),
        lambda train: (train / "000001.idx").write_text("v1.2 0\n"),
        lambda train: (train / "000001.idx").write_bytes((train / "000000.idx").read_bytes()),
        lambda train: (train / "000001.tar").write_bytes((train / "000000.tar").read_bytes()),
        lambda train: flip(train / "000002.tar", 600),  # in a member
        lambda train: flip(train / "000002.tar", 10),  # in a header
        lambda train: (train / "000002.tar").write_bytes((train / "000002.tar").read_bytes()[:5000]),
        lambda train: (train / "000002.tar").write_bytes((train / "000002.tar").read_bytes()[:-1024]),
        lambda train: shutil.rmtree(train),
    ],
)
def test_resuming_mends_what_is_damaged(shards: Path, tmp_path: Path, damage: Callable[[Path], object]) -> None:
    out = tmp_path / "out"
    shutil.copytree(shards, out)
    damage(out / "train")
    write(out, 10)
    assert tree(out) == tree(shards)


def test_another_size_of_shards_is_another_run(shards: Path) -> None:
    settings = small_settings(10, format="webdataset", shard_size=9)
    with pytest.raises(CadetError, match="shard_size was 2, now 9"), open_folder(shards, settings, resume=True):
        pass


def test_formats_without_shards_have_no_size_of_them() -> None:
    with pytest.raises(CadetError, match=r"^Settings\.shard_size: the format kitti has no shards$"):
        Settings(policy=ResetPolicy.kitti(), shard_size=9)


@pytest.mark.parametrize(("val_fraction", "test_fraction"), [(0.2, 0), (0.5, 1 / 3), (0, 0.25), (0, 0), (0.25, 0.25)])
def test_ranks_count_the_samples_of_each_split(val_fraction: float, test_fraction: float) -> None:
    settings = Settings(
        policy=ResetPolicy.kitti(),
        num_frames=1234,
        val_fraction=val_fraction,
        test_fraction=test_fraction,
        format="webdataset",
    )
    ranks: dict[str, list[int]] = {"train": [], "val": [], "test": []}
    for place in settings.places():
        ranks[place.split].append(place.rank)
    assert sum(map(len, ranks.values())) == 1234
    for found in ranks.values():
        assert found == list(range(len(found)))


def test_a_store_of_objects_is_refused_before_anything_is_made() -> None:
    pytest.importorskip("s3fs", reason="needs s3fs")
    with pytest.raises(CadetError, match=r"^s3://bucket/set: shards are packed in a folder; copy them to a store"):
        small_settings(8, format="webdataset").open("s3://bucket/set")
