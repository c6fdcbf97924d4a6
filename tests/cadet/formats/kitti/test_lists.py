"""The lists that `write_frame` keeps."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np
import pytest

from cadet import CadetError, kitti
from cadet.errors import KittiFormatError
from cadet.formats.kitti import Dataset, ImageSet, read_image_set, write_frame, write_image_set
from cadet.formats.kitti.files.dialects import collected
from synthetic import make_frame


def lists_of(root: Path) -> dict[str, tuple[str, ...]]:
    return {path.stem: read_image_set(root, path.stem).ids for path in sorted((root / "ImageSets").iterdir())}


def test_a_set_written_frame_by_frame_is_read_by_split(tmp_path: Path) -> None:
    frame = make_frame()
    for number in (3, 0, 1):
        write_frame(str(tmp_path), number, frame)
    assert lists_of(tmp_path) == {
        "train": ("000000", "000001", "000003"),
        "trainval": ("000000", "000001", "000003"),
        "val": (),
    }
    write_frame(tmp_path, "000002", make_frame(seed=1), split="val")
    assert lists_of(tmp_path)["val"] == ("000002",)
    assert lists_of(tmp_path)["trainval"] == ("000000", "000001", "000002", "000003")
    assert len(Dataset(tmp_path, "train")) == 3
    np.testing.assert_array_equal(Dataset(tmp_path, "val")[0].image, make_frame(seed=1).image)
    assert not [finding for finding in kitti.lint(tmp_path, strict=False) if finding.file.startswith("ImageSets")]


@pytest.mark.parametrize("text", ["", "000001", "000001\n", "000003\n000001", "a1b2\n0000001\nscene 1.left\n"])
def test_a_list_is_written_as_it_was_read(text: str) -> None:
    assert ImageSet.from_text(text).to_text() == text


@pytest.mark.parametrize(
    ("data", "ids", "lines"),
    [
        (b"\n", (), [1]),
        (b"\n000001\n\n", ("000001",), [1]),
        (b"000001\r\n000002\r\n", ("000001", "000002"), []),
        (b"\xef\xbb\xbf000001\n", ("000001",), []),
        (b"000001 \n\t000002\n", ("000001", "000002"), []),
        (b"000001\n000000.png\n000002.png\n", ("000001", "000000", "000002"), [2]),
        (b"training/image_2/000000.png\n", ("000000",), [1]),
        (b"C:\\set\\velodyne\\000000.bin\n", ("000000",), [1]),
        (b"/data/kitti/training/image_2/a.b.jpg\n\n", ("a.b",), [1, 2]),
        ("stra\u00dfe_1\n".encode(), ("stra\u00dfe_1",), []),
    ],
)
def test_lists_as_others_write_them_are_read(
    tmp_path: Path, data: bytes, ids: tuple[str, ...], lines: list[int]
) -> None:
    write_frame(tmp_path, 0, make_frame(), split=None)
    (tmp_path / "ImageSets").mkdir()
    (tmp_path / "ImageSets" / "train.txt").write_bytes(data)
    with collected() as dialects:
        assert read_image_set(tmp_path, "train").ids == ids
    assert [(one.file, one.line) for one in dialects] == [("ImageSets/train.txt", line) for line in lines]
    found = [one for one in kitti.lint(tmp_path, strict=False) if one.rule == "dialect"]
    assert [one.line for one in found] == lines


def test_a_list_in_another_encoding_is_named(tmp_path: Path) -> None:
    (tmp_path / "ImageSets").mkdir()
    (tmp_path / "ImageSets" / "train.txt").write_bytes("000001\n".encode("utf-16"))
    with pytest.raises(KittiFormatError, match=r"^ImageSets/train\.txt: not UTF-8 .*: save the list as UTF-8"):
        read_image_set(tmp_path, "train")


def test_lists_beside_the_frames_are_read_where_there_are_no_others(tmp_path: Path) -> None:
    for number in range(2):
        write_frame(tmp_path, number, make_frame(seed=number), split=None)
    (tmp_path / "train.txt").write_text("000001\n")
    (tmp_path / "readme.txt").write_text("no list\n")
    with collected() as dialects:
        assert Dataset(tmp_path, "train").ids == Dataset(tmp_path / "training", "train").ids == ("000001",)
    assert {(one.kind, one.file) for one in dialects} == {("list-place", "train.txt")}
    findings = [one for one in kitti.lint(tmp_path) if not one.file.startswith("label_2")]
    assert [(one.place, one.rule, one.severity) for one in findings] == [("train.txt", "dialect", "warning")]
    write_image_set(tmp_path, "train", ImageSet(("000000",)))
    assert Dataset(tmp_path, "train").ids == ("000000",)


def test_a_frame_written_again_stays_where_it_is(tmp_path: Path) -> None:
    write_frame(tmp_path, 0, make_frame(), split="val")
    before = lists_of(tmp_path)
    with pytest.raises(CadetError, match=r"val\.txt: frame 000000 is listed there; pass split='val'"):
        write_frame(tmp_path, 0, make_frame(labels=()), overwrite=True)
    assert kitti.read_labels(tmp_path, 0), "nothing was overwritten"
    write_frame(tmp_path, 0, make_frame(labels=()), split="val", overwrite=True)
    assert lists_of(tmp_path) == before


def test_lists_of_another_order_keep_it(tmp_path: Path) -> None:
    write_image_set(tmp_path, "train", ImageSet(("000007", "000002")))
    write_frame(tmp_path, 4, make_frame())
    assert lists_of(tmp_path)["train"] == ("000007", "000002", "000004")


def test_no_split_leaves_the_lists_alone(tmp_path: Path) -> None:
    write_frame(tmp_path, 0, make_frame(), split=None)
    assert not (tmp_path / "ImageSets").exists()


@pytest.mark.parametrize("split", ["test", "", "../x", 3, ("train",)])
def test_another_split_is_refused_before_anything_is_written(tmp_path: Path, split: Any) -> None:
    with pytest.raises(CadetError, match=r"^split: expected train or val, or None for no list, got "):
        write_frame(tmp_path, 0, make_frame(), split=split)
    assert not any(tmp_path.iterdir())
