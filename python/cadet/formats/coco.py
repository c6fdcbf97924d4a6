"""COCO's annotations of a set's images, for programs that find and segment objects in images alone."""

from __future__ import annotations

import json
from collections.abc import Iterator, Mapping, Sequence
from itertools import count
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from cadet import _cadet
from cadet._util.sink import Sink
from cadet.errors import CadetError, KittiFormatError
from cadet.formats.kitti import Label
from cadet.formats.kitti.files.images import decode_image
from cadet.formats.kitti.frame_files import FrameFiles, labels_from_files, meta_from_files, read_map
from cadet.formats.kitti.frame_object import objects_of
from cadet.formats.kitti.label import TYPES

_Row = dict[str, Any]


def put_coco(sink: Sink, splits: Mapping[str, tuple[FrameFiles, Sequence[str]]]) -> None:
    """Write `SPLIT/ID.png`, byte for byte, and `annotations/instances_SPLIT.json` for each split.

    Categories are KITTI's types in their order, from 1, then the set's own by name. Ids of images and annotations are
    unique in all splits. An object's `bbox` is its label's; where a frame has an instance map, `segmentation` and
    `area` are its visible pixels. A DontCare region is a crowd of every category.

    Args:
        sink: where to.
        splits: where the frames of each split lie, and their ids in order.

    Raises:
        MissingFileError: a file of a frame that its fellows have is missing.
        CadetError: an image, instance map, label file, or `meta` that is damaged, or a `meta` of other labels.
    """
    types = {label.type for files, ids in splits.values() for frame_id in ids for label in _labels(files, frame_id)}
    names = [name for name in (*TYPES, *sorted(types.difference(TYPES))) if name != "DontCare"]
    categories = {name: number for number, name in enumerate(names, start=1)}
    image_ids, annotation_ids = count(1), count(1)
    for split, (files, ids) in splits.items():
        images: list[_Row] = []
        annotations: list[_Row] = []
        for frame_id in ids:
            data, name = files.read("image_2", frame_id)
            image = decode_image(data, name)
            file_name = f"{frame_id}{Path(name).suffix}"
            row = {"id": next(image_ids), "file_name": file_name, "width": image.shape[1], "height": image.shape[0]}
            images.append(row)
            annotations += (
                {"id": next(annotation_ids), "image_id": row["id"], **annotation}
                for annotation in _annotations(files, frame_id, image.shape, categories)
            )
            sink.put(f"{split}/{file_name}", data)
        content = {
            "info": {"description": f"Labels by KITTI's definitions, {split}: converted by cadet {_cadet.__version__}"},
            "images": images,
            "annotations": annotations,
            "categories": [{"id": number, "name": name} for name, number in categories.items()],
        }
        sink.put(f"annotations/instances_{split}.json", json.dumps(content, separators=(",", ":")).encode("ascii"))


def run_lengths(mask: NDArray[np.bool_]) -> list[int]:
    """Return the lengths of a mask's runs down its columns, of unset and set pixels in turn: COCO's `counts`.

    Args:
        mask: (H, W) bool.
    """
    pixels = np.concatenate([[False], mask.ravel(order="F")])
    changes = np.flatnonzero(pixels[1:] != pixels[:-1])
    lengths: list[int] = np.diff(changes, prepend=0, append=mask.size).tolist()
    return lengths


def _labels(files: FrameFiles, frame_id: str) -> tuple[Label, ...]:
    return labels_from_files(files, frame_id) if files.has_kind("label_2") else ()


def _annotations(
    files: FrameFiles, frame_id: str, image_shape: tuple[int, ...], categories: Mapping[str, int]
) -> Iterator[_Row]:
    """Yield a frame's annotations without their ids: objects, then regions."""
    labels = _labels(files, frame_id)
    meta = meta_from_files(files, frame_id) if files.has("meta", frame_id) else None
    instance = read_map(files, "instance", frame_id, image_shape)
    try:
        objects = [seen for seen in objects_of(labels, meta) if seen.is_labeled]
    except CadetError as error:
        raise KittiFormatError(f"{error}; without this file boxes alone are written", f"meta/{frame_id}.json") from None
    for seen in objects:
        label = seen.label
        mask = None if instance is None or seen.id is None else instance == seen.id
        of_kitti = {"truncated": label.truncated, "occluded": label.occluded, "box_cam": label.box_cam.tolist()}
        track = {} if seen.id is None else {"track_id": seen.id}
        yield {"category_id": categories[label.type], "iscrowd": 0, **_place(label, mask), **of_kitti, **track}
    for label in (label for label in labels if label.is_dont_care):
        place = _place(label, None if instance is None else _inside(label, instance.shape))
        # COCO's evaluation takes categories one by one, so a region for all classes is one of each.
        yield from ({"category_id": category, "iscrowd": 1, **place} for category in categories.values())


def _place(label: Label, mask: NDArray[np.bool_] | None) -> _Row:
    left, top, right, bottom = label.bbox
    bbox = [round(value, 4) for value in (left, top, right - left, bottom - top)]
    if mask is None:
        return {"bbox": bbox, "area": round(bbox[2] * bbox[3], 4)}
    segmentation = {"size": list(mask.shape), "counts": run_lengths(mask)}
    return {"bbox": bbox, "area": int(mask.sum()), "segmentation": segmentation}


def _inside(label: Label, shape: tuple[int, ...]) -> NDArray[np.bool_]:
    """Return the pixels of a region: (H, W) bool."""
    left, top, right, bottom = (max(round(value), 0) for value in label.bbox)
    mask = np.zeros(shape, np.bool_)
    mask[top : bottom + 1, left : right + 1] = True
    return mask
