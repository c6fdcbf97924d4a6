"""`cadet convert`: there and back again without a changed byte, and what it refuses."""

from __future__ import annotations

import shutil
from pathlib import Path

import pytest
from click.testing import CliRunner

from cadet import kitti
from cadet.cli.tools import cadet as command
from cadet.errors import CadetError, KittiFormatError, MissingFileError
from cadet.formats.convert import convert
from cadet.formats.webdataset import ArchiveError, open_dataset
from gen_process import tree
from synthetic import make_frame


@pytest.fixture(scope="module")
def folder(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """Return seven frames: three to train in an order of their own, two to validate, one in no list, one test frame."""
    root = tmp_path_factory.mktemp("convert") / "kitti"
    frame = make_frame(has_maps=True)
    for number in range(7):
        kitti.write_frame(root, number, frame, split=None)
    lists = {"train": "000004\n000000\n000002", "val": "000001\n000003\n", "trainval": "000000\n", "tiny": "000002\n"}
    (root / "ImageSets").mkdir()
    for name, text in {**lists, "test": "000006\n"}.items():
        (root / "ImageSets" / f"{name}.txt").write_text(text)
    for path in (root / "training").glob("*/000006.*"):
        if path.parent.name in ("image_2", "velodyne", "calib"):
            (root / "testing" / path.parent.name).mkdir(parents=True)
            path.rename(root / "testing" / path.parent.name / path.name)
        else:
            path.unlink()
    # No byte of a file is looked at: not even what no reader would take.
    (root / "training" / "label_2" / "000001.txt").write_bytes(b"no label\r\n\xff\0")
    (root / "training" / "velodyne" / "000003.bin").write_bytes(b"")
    (root / "training" / "image_2" / "000004.png").write_bytes(b"\x89PNG" + bytes(513))
    return root


def test_there_and_back_again_no_byte_has_changed(folder: Path, tmp_path: Path) -> None:
    done = convert(folder, tmp_path / "shards", "webdataset", shard_size=2)
    assert (done.num_frames, done.left_out) == (7, ())
    found = sorted(str(path.relative_to(tmp_path / "shards")) for path in (tmp_path / "shards").glob("*/*.tar"))
    assert found == [
        "test/000000.tar", "train/000000.tar", "train/000001.tar", "unlisted/000000.tar", "val/000000.tar"
    ]  # fmt: skip
    assert open_dataset(tmp_path / "shards", "train").ids == ("000004", "000000", "000002")
    assert convert(tmp_path / "shards", tmp_path / "kitti", "kitti").num_frames == 7
    assert tree(tmp_path / "kitti") == tree(folder)


def test_shards_of_another_size_are_those_of_the_folder(folder: Path, tmp_path: Path) -> None:
    convert(folder, tmp_path / "by_two", "webdataset", shard_size=2)
    convert(folder, tmp_path / "by_three", "webdataset", shard_size=3)
    convert(tmp_path / "by_two", tmp_path / "again", "webdataset", shard_size=3)
    assert tree(tmp_path / "again") == tree(tmp_path / "by_three")
    assert tree(tmp_path / "again") != tree(tmp_path / "by_two")


def test_frames_are_the_same_in_either_format(folder: Path, tmp_path: Path) -> None:
    convert(folder, tmp_path / "shards", "webdataset")
    shards = open_dataset(tmp_path / "shards", "unlisted")
    ours, theirs = shards["000005"], kitti.read_frame(folder, 5)
    assert kitti.encode_frame(ours) == kitti.encode_frame(theirs)
    assert ours.depth is not None and ours.instance is not None
    assert shards.read_labels("000005") == theirs.labels
    # KITTI's own test frames have no labels, and nobody misses them.
    assert open_dataset(tmp_path / "shards", "test")[0].labels == ()
    with pytest.raises(KittiFormatError) as refused:
        open_dataset(tmp_path / "shards", "val")["000001"]
    assert "000000.tar/000001." in str(refused.value)


def test_a_pattern_names_frames_without_a_split(folder: Path, tmp_path: Path) -> None:
    convert(folder, tmp_path / "shards", "webdataset", shard_size=2)
    convert(f"{tmp_path}/shards/train/{{000000..000001}}.tar", tmp_path / "some", "kitti")
    assert kitti.Dataset(tmp_path / "some").ids == ("000000", "000002", "000004")
    assert not (tmp_path / "some" / "ImageSets").exists()


def test_lists_are_made_where_there_are_none(folder: Path, tmp_path: Path) -> None:
    convert(folder, tmp_path / "shards", "webdataset")
    shutil.rmtree(tmp_path / "shards" / "ImageSets")
    convert(tmp_path / "shards", tmp_path / "kitti", "kitti")
    for name, ids in {"train": [4, 0, 2], "val": [1, 3], "test": [6], "trainval": [0, 1, 2, 3, 4]}.items():
        assert (tmp_path / "kitti" / "ImageSets" / f"{name}.txt").read_text().split() == [f"{i:06d}" for i in ids]


def test_what_is_no_frames_is_named(folder: Path, tmp_path: Path) -> None:
    shutil.copytree(folder, tmp_path / "kitti")
    (tmp_path / "kitti" / "notes.txt").touch()
    (tmp_path / "kitti" / "training" / "prev_2").mkdir()
    (tmp_path / "kitti" / "training" / "prev_2" / "000000_01.png").touch()
    (tmp_path / "kitti" / "run.json").touch()
    arguments = ["convert", str(tmp_path / "kitti"), str(tmp_path / "out"), "--to", "webdataset"]
    done = CliRunner().invoke(command, arguments, catch_exceptions=False)
    assert done.stderr.splitlines() == [
        "left out, as no frame's: notes.txt, training/prev_2/000000_01.png",
        f"7 frames in {tmp_path / 'out'}",
    ]


def test_nothing_is_overwritten(folder: Path, tmp_path: Path) -> None:
    (tmp_path / "mine").touch()
    with pytest.raises(CadetError, match="is not an empty folder: name a new one"):
        convert(folder, tmp_path, "webdataset")
    with pytest.raises(CadetError, match="is not an empty folder: name a new one"):
        convert(folder, tmp_path / "mine", "webdataset")


def test_lists_that_contradict_are_refused(folder: Path, tmp_path: Path) -> None:
    root = tmp_path / "kitti"
    shutil.copytree(folder, root)
    (root / "ImageSets" / "val.txt").write_text("000003\n000002\n")
    with pytest.raises(CadetError, match=r"train\.txt and val\.txt both list frame 000002"):
        convert(root, tmp_path / "out", "webdataset")
    (root / "ImageSets" / "val.txt").write_text("000009\n")
    with pytest.raises(MissingFileError, match=r"ImageSets/val\.txt: there is no frame 000009"):
        convert(root, tmp_path / "out", "webdataset")
    assert not (tmp_path / "out").exists()


def test_a_frame_of_two_splits_is_refused(folder: Path, tmp_path: Path) -> None:
    convert(folder, tmp_path / "shards", "webdataset")
    shutil.copy(tmp_path / "shards" / "train" / "000000.tar", tmp_path / "shards" / "val" / "000001.tar")
    with pytest.raises(ArchiveError, match=r"val/000001\.tar: the member '.*': .*train/000000\.tar holds the frame"):
        convert(tmp_path / "shards", tmp_path / "out", "kitti")


@pytest.mark.parametrize(("name", "what"), [("nothing", "no such folder"), ("empty", "no KITTI folder: it is empty")])
def test_what_is_no_dataset_is_refused(tmp_path: Path, name: str, what: str) -> None:
    (tmp_path / "empty").mkdir()
    with pytest.raises(MissingFileError, match=f"{name}: {what}"):
        convert(tmp_path / name, tmp_path / "out", "webdataset")


def test_an_unknown_format_is_refused(folder: Path, tmp_path: Path) -> None:
    with pytest.raises(CadetError, match="unknown format 'nuscenes'; known: kitti, webdataset"):
        convert(folder, tmp_path / "out", "nuscenes")
