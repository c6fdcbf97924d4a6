"""`cadet convert --to coco`: what pycocotools makes of it, and what stands in it."""

from __future__ import annotations

import copy
import importlib
import json
from collections.abc import Callable
from pathlib import Path
from types import ModuleType
from typing import Any

import numpy as np
import pytest
from numpy.typing import NDArray

from cadet import kitti
from cadet.errors import CadetWarning, KittiFormatError
from cadet.formats.coco import run_lengths
from cadet.formats.convert import convert
from cadet.formats.kitti.label import TYPES
from gen_process import tree
from scans.sensed import Sensed
from synthetic import DONT_CARE, make_calib, make_frame, make_label

# Of pycocotools' arrays, which numpy 2 takes with a warning.
pytestmark = pytest.mark.filterwarnings("ignore:__array__ implementation:DeprecationWarning")

Row = dict[str, Any]
SPLITS = {"train": ("000000", "000001", "000002"), "val": ("000003", "000004")}


@pytest.fixture(scope="module")
def root(tmp_path_factory: pytest.TempPathFactory, street_frames: list[Sensed]) -> Path:
    """Five generated frames with instance maps."""
    folder = tmp_path_factory.mktemp("coco") / "kitti"
    for number, sensed in enumerate(street_frames[::6]):
        kitti.write_frame(folder, number, sensed.frame, split="train" if number < 3 else "val")
    return folder


@pytest.fixture(scope="module")
def out(root: Path) -> Path:
    convert(root, root.parent / "coco", "coco")
    return root.parent / "coco"


@pytest.fixture(scope="module")
def pycocotools() -> ModuleType:
    for module in ("pycocotools.coco", "pycocotools.cocoeval"):
        pytest.importorskip(module, reason="needs pycocotools")
    return importlib.import_module("pycocotools")


def content(out: Path, split: str) -> dict[str, list[Row]]:
    found: dict[str, list[Row]] = json.loads((out / "annotations" / f"instances_{split}.json").read_text())
    return found


def truth(pycocotools: Any, out: Path, split: str) -> Any:
    return pycocotools.coco.COCO(str(out / "annotations" / f"instances_{split}.json"))


def detections(coco: Any, kind: str) -> list[Row]:
    """Return the objects of a set as what a detector of boxes ("bbox") or masks ("segm") found."""
    of_result: Callable[[Row], Row] = {
        "bbox": lambda row: {"bbox": row["bbox"]},
        "segm": lambda row: {"segmentation": coco.annToRLE(row)},
    }[kind]
    rows = [row for row in coco.dataset["annotations"] if not row["iscrowd"]]
    return [{key: row[key] for key in ("image_id", "category_id")} | {"score": 0.5} | of_result(row) for row in rows]


def average_precision(pycocotools: Any, coco: Any, found: list[Row], kind: str) -> float:
    coco = copy.deepcopy(coco)  # COCOeval writes into it
    evaluation = pycocotools.cocoeval.COCOeval(coco, coco.loadRes(copy.deepcopy(found)), kind)
    evaluation.evaluate()
    evaluation.accumulate()
    evaluation.summarize()
    return float(evaluation.stats[0])


@pytest.mark.parametrize("split", SPLITS)
@pytest.mark.parametrize("kind", ["bbox", "segm"])
def test_cocos_evaluation_finds_the_truth_perfect(pycocotools: Any, out: Path, split: str, kind: str) -> None:
    coco = truth(pycocotools, out, split)
    found = detections(coco, kind)
    assert len(found) >= 5
    assert average_precision(pycocotools, coco, found, kind) == pytest.approx(1.0, abs=1e-9)
    assert average_precision(pycocotools, coco, found[1:], kind) < 0.99


def test_boxes_moved_by_a_tenth_of_their_width_pass_seven_of_ten_thresholds(pycocotools: Any, out: Path) -> None:
    """Their IoU is 0.9 / 1.1 = 0.818; the thresholds are 0.5 to 0.95."""
    coco = truth(pycocotools, out, "train")
    found = detections(coco, "bbox")
    for row in found:
        left, top, width, height = row["bbox"]
        row["bbox"] = [left + width / 10, top, width, height]
    assert average_precision(pycocotools, coco, found, "bbox") == pytest.approx(0.7, abs=0.02)


@pytest.mark.parametrize("kind", ["bbox", "segm"])
def test_whatever_is_found_in_a_region_counts_for_no_class(pycocotools: Any, out: Path, kind: str) -> None:
    coco = truth(pycocotools, out, "train")
    found = detections(coco, kind)
    region = next(row for row in coco.dataset["annotations"] if row["iscrowd"])
    num_crowds = sum(row["iscrowd"] and row["bbox"] == region["bbox"] for row in coco.dataset["annotations"])
    assert num_crowds == len(coco.dataset["categories"]) == 8
    place: Row = {"bbox": region["bbox"]} if kind == "bbox" else {"segmentation": coco.annToRLE(region)}
    for category_id in {row["category_id"] for row in found}:
        more = {"image_id": region["image_id"], "category_id": category_id, "score": 0.9, **place}
        assert average_precision(pycocotools, coco, [*found, more], kind) == pytest.approx(1.0, abs=1e-9)
        cut = copy.deepcopy(coco)
        cut.dataset["annotations"] = [row for row in cut.dataset["annotations"] if not row["iscrowd"]]
        cut.createIndex()
        assert average_precision(pycocotools, cut, [*found, more], kind) < 0.99


def test_masks_are_the_pixels_of_the_instance_map(pycocotools: Any, out: Path, street_frames: list[Sensed]) -> None:
    num_compared = 0
    for split, ids in SPLITS.items():
        coco = truth(pycocotools, out, split)
        for image in coco.dataset["images"]:
            frame = street_frames[6 * int(image["file_name"][:6])].frame
            assert frame.instance is not None and image["file_name"][:6] in ids
            assert (image["width"], image["height"]) == frame.image_size
            rows = [row for row in coco.imgToAnns[image["id"]] if not row["iscrowd"]]
            objects = [seen for seen in frame.objects if seen.is_labeled]
            for row, seen in zip(rows, objects, strict=True):
                is_own = frame.instance == seen.id
                np.testing.assert_array_equal(coco.annToMask(row), is_own)
                assert row["area"] == is_own.sum() > 0 and row["track_id"] == seen.id
                num_compared += 1
    assert num_compared >= 10


@pytest.mark.parametrize("mask", [np.zeros((3, 4)), np.ones((3, 4)), np.eye(4)[:3], np.eye(4)[::-1], np.ones((1, 1))])
def test_runs_go_down_the_columns(pycocotools: Any, mask: NDArray[np.float64]) -> None:
    counts = run_lengths(mask.astype(bool))
    coco = pycocotools.coco.COCO()
    coco.imgs = {1: {"height": mask.shape[0], "width": mask.shape[1]}}
    decoded = coco.annToMask({"image_id": 1, "segmentation": {"counts": counts, "size": list(mask.shape)}})
    np.testing.assert_array_equal(decoded, mask)


def test_splits_images_and_ids(root: Path, out: Path) -> None:
    assert sorted(path.name for path in out.iterdir()) == ["ImageSets", "annotations", "train", "val"]
    assert sorted(path.name for path in (out / "annotations").iterdir()) == [
        "instances_train.json",
        "instances_val.json",
    ]
    sets = {split: content(out, split) for split in SPLITS}
    for split, ids in SPLITS.items():
        assert [image["file_name"] for image in sets[split]["images"]] == [f"{frame_id}.png" for frame_id in ids]
        for frame_id in ids:
            image = (root / "training" / "image_2" / f"{frame_id}.png").read_bytes()
            assert (out / split / f"{frame_id}.png").read_bytes() == image
        names = {row["id"]: row["name"] for row in sets[split]["categories"]}
        assert names == dict(enumerate(TYPES[:-1], start=1))
    for key in ("images", "annotations"):
        numbers = [row["id"] for split in SPLITS for row in sets[split][key]]
        assert numbers == list(range(1, len(numbers) + 1))


def test_shards_give_the_same_bytes(root: Path, out: Path, tmp_path: Path) -> None:
    convert(root, tmp_path / "shards", "webdataset", shard_size=2)
    convert(tmp_path / "shards", tmp_path / "coco", "coco")
    assert tree(tmp_path / "coco") == tree(out)


def test_a_set_without_maps_has_boxes_and_types_of_its_own(tmp_path: Path) -> None:
    calib = make_calib()
    bus = make_label("Bus", (-2.0, 1.65, 14.0, 4.1, 1.7, 1.5, 1.5), calib, occluded=1)
    kitti.write_frame(tmp_path / "kitti", 0, make_frame(meta=None, labels=(bus, DONT_CARE)), split=None)
    with pytest.warns(CadetWarning, match="type Bus is not one of KITTI's"):
        convert(tmp_path / "kitti", tmp_path / "coco", "coco")
    found = content(tmp_path / "coco", "train")
    assert found["categories"][-1] == {"id": 9, "name": "Bus"}
    row, *regions = found["annotations"]
    (label, _) = kitti.read_labels(tmp_path / "kitti", 0)
    left, top, right, bottom = label.bbox
    assert row["bbox"] == pytest.approx([left, top, right - left, bottom - top], abs=1e-4)
    assert row["area"] == pytest.approx((right - left) * (bottom - top), abs=1e-2)
    assert (row["category_id"], row["iscrowd"], row["truncated"], row["occluded"]) == (9, 0, 0.0, 1)
    assert row["box_cam"] == label.box_cam.tolist() and not {"segmentation", "track_id"} & set(row)
    assert [(region["category_id"], region["iscrowd"]) for region in regions] == [(n, 1) for n in range(1, 10)]
    assert {tuple(region["bbox"]) for region in regions} == {(300.0, 80.0, 20.0, 15.0)}


def test_a_meta_of_other_labels_is_refused(root: Path, tmp_path: Path) -> None:
    frame = kitti.read_frame(root, 0)
    kitti.write_frame(tmp_path / "kitti", 0, make_frame(meta=frame.meta))
    with pytest.raises(KittiFormatError, match=r"^meta/000000\.json: objects: 4 labels, and \d+ in meta.*boxes alone"):
        convert(tmp_path / "kitti", tmp_path / "coco", "coco")
