"""`croissant.json`, as MLCommons' own library reads it, against cadet's own reader and the files."""

from __future__ import annotations

import json
from collections import Counter
from fnmatch import fnmatchcase
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from cadet import kitti
from small_runs import make

# mlcroissant calls what rdflib is about to take away.
pytestmark = pytest.mark.filterwarnings("ignore::DeprecationWarning:rdflib")


@pytest.fixture(scope="module")
def folder(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """Return a set of four episodes, one of them for tests."""
    out = tmp_path_factory.mktemp("described") / "out"
    make(out, 14, write=("depth",), test_fraction=0.34)
    return out


@pytest.fixture(scope="module")
def described(folder: Path) -> Any:
    """Return the set as the library opens it."""
    mlcroissant = pytest.importorskip("mlcroissant", reason="needs mlcroissant")
    return mlcroissant.Dataset(jsonld=str(folder / "croissant.json"))


def text(value: Any) -> Any:
    return value.decode() if isinstance(value, bytes) else value


def test_the_library_finds_nothing_wrong_but_that_whoever_publishes_it_must_say_when(described: Any) -> None:
    issues = described.metadata.ctx.issues
    assert not issues.errors
    (warning,) = issues.warnings
    assert "datePublished" in warning


def test_its_records_are_the_labels(folder: Path, described: Any) -> None:
    rows = [{key.partition("/")[2]: text(value) for key, value in row.items()} for row in described.records("labels")]
    assert Counter(row["frame"] for row in rows) == Counter(
        frame_id
        for split in ("trainval", "test")
        for frame_id in kitti.Dataset(folder, split).ids
        for _ in kitti.Dataset(folder, split).read_frame(frame_id).labels
    )
    frame_id = kitti.Dataset(folder, "trainval").ids[3]
    for row, label in zip(
        [row for row in rows if row["frame"] == frame_id], kitti.read_frame(folder, int(frame_id)).labels, strict=True
    ):
        assert row["type"] == label.type
        assert [*row.values()][2:] == [float(field) for field in label.to_line().split()[1:]]


def test_its_images_and_frames_are_those_of_the_folder(folder: Path, described: Any) -> None:
    images = {text(row["images/frame"]): np.asarray(row["images/image"]) for row in described.records("images")}
    frame = kitti.read_frame(folder, 1)
    assert len(images) == 14 and np.array_equal(images["000001"], frame.image)
    frames = {text(row["frames/frame"]): row for row in described.records("frames")}
    assert frame.meta is not None and len(frames) == 14
    found = {name: text(frames["000001"][f"frames/{name}"]) for name in ("episode", "district", "weather")}
    assert found == {name: frame.meta[name] for name in found}


def test_every_file_of_a_frame_is_in_one_set_of_files(folder: Path) -> None:
    content = json.loads((folder / "croissant.json").read_text())
    patterns = [(one["@id"], pattern) for one in content["distribution"] for pattern in one.get("includes", [])]
    hashes = json.loads((folder / "manifest.json").read_text())["sha256"]
    for name in hashes:
        if not name.startswith("ImageSets/"):
            assert [kind for kind, pattern in patterns if fnmatchcase(name, pattern)] == [name.split("/")[1]]
    assert str(folder) not in json.dumps(content)
