"""The lists that `write_frame` keeps."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np
import pytest

from cadet import CadetError, kitti
from cadet.kitti import Dataset, ImageSet, read_image_set, write_frame, write_image_set
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


def test_a_list_is_written_as_it_was_read_and_blank_lines_are_none() -> None:
    for text in ("", "000001", "000001\n", "000003\n000001"):
        assert ImageSet.from_text(text).to_text() == text
    for text in ("\n", "\n\n", "000001\n\n", "\n000001\n"):
        with pytest.raises(CadetError, match=r"train\.txt:\d: expected a six-digit id, got ''"):
            ImageSet.from_text(text, "train.txt")


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
