"""BDD100K's 2D labels as KITTI's, for detectors that learn from images alone."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any, Final

from cadet._util.checks import as_path, plain_number, shown
from cadet._util.plain_text import json_from_text
from cadet._util.sink import LocalSink
from cadet._util.user_files import read_file
from cadet.errors import FileFormatError, MissingFileError
from cadet.formats.kitti import Label
from cadet.formats.kitti.files.images import decode_image, encode_png
from cadet.formats.kitti.image_sets import ImageSet

_Box = tuple[float, float, float, float]

TYPES: Final[Mapping[str, str | None]] = {
    "car": "Car",
    "truck": "Truck",
    "bus": "Truck",
    "train": "Tram",
    "person": "Pedestrian",
    "pedestrian": "Pedestrian",
    "rider": None,
    "bike": None,
    "bicycle": None,
    "motor": None,
    "motorcycle": None,
    "trailer": "Misc",
    "other vehicle": "Misc",
    "other person": "DontCare",
    "traffic light": None,
    "traffic sign": None,
    "drivable area": None,
    "area/drivable": None,
    "area/alternative": None,
    "lane": None,
}
"""KITTI's type for each category of the releases of 2018 and 2020; None for what is ridden, rides, or is left out."""
_RIDDEN: Final = {"bike": "Cyclist", "bicycle": "Cyclist", "motor": "Misc", "motorcycle": "Misc"}
_LEAST_OVERLAP: Final = 0.2
_FULLY_TRUNCATED: Final = 1.0
_UNKNOWN_OCCLUSION: Final = 3


@dataclass(frozen=True)
class BddImage:
    """The labels of one image."""

    name: str
    """Its file."""
    labels: tuple[Label, ...]


def labels_from_text(text: str | bytes, file: str) -> tuple[BddImage, ...]:
    """Read a file of BDD100K's labels: a list of frames, or an object whose `frames` is one.

    A rider becomes one object with the bicycle (Cyclist) or motorcycle (Misc, as KITTI has it) that it overlaps most,
    in the box around both. Bicycles and motorcycles that nobody rides have no label in KITTI: their boxes, and riders
    of nothing, are DontCare. Lights, signs, lanes, and areas are left out. What is unknown has KITTI's marks: every
    number in 3D; `occluded` 3 where BDD100K says occluded; `truncated` 1, which no level of evaluation counts, where
    it says truncated.

    Args:
        text: of the file.
        file: its name, for messages.

    Raises:
        FileFormatError: invalid JSON, no such list, an unknown category, or an invalid box; frame and label are named.
    """
    frames = json_from_text(text, file)
    if isinstance(frames, dict):
        frames = frames.get("frames")
    if not isinstance(frames, list) or not all(isinstance(frame, dict) for frame in frames):
        raise FileFormatError("not labels of BDD100K: expected a list of frames", file)
    images = tuple(_image(frame, number, file) for number, frame in enumerate(frames))
    names: set[str] = set()
    for image in images:
        if image.name in names:
            raise FileFormatError(f"{image.name} is listed twice", file)
        names.add(image.name)
    return images


def convert_bdd100k(labels: str | Path, images: str | Path, out: str | Path) -> int:
    """Write labels and images of BDD100K as a KITTI folder without scans; returns how many frames there are.

    Frames are numbered in the file's order; `names.txt` says which image each was. All are listed in `train`.

    Args:
        labels: a JSON file such as `det_train.json` or `bdd100k_labels_images_train.json`.
        images: the folder of its images.
        out: a new or empty folder.

    Raises:
        MissingFileError: no such file, or an image of it.
        CadetError: labels as `labels_from_text` refuses them, an image that can't be decoded, or `out` is not empty.
        OSError: the folder can't be written.
    """
    file, folder = as_path("labels", labels), as_path("images", images)
    sink = LocalSink.new(as_path("out", out))
    found = labels_from_text(read_file(file), str(file))
    if missing := next((image for image in found if not (folder / image.name).is_file()), None):
        raise MissingFileError(f"{folder / missing.name}: no such image, which {file} lists")
    try:
        for number, image in enumerate(found):
            path = folder / image.name
            sink.put(f"training/image_2/{number:06d}.png", encode_png(decode_image(read_file(path), str(path))))
            lines = "".join(f"{label.to_line()}\n" for label in image.labels)
            sink.put(f"training/label_2/{number:06d}.txt", lines.encode("ascii"))
        ids = ImageSet(tuple(f"{number:06d}" for number in range(len(found))))
        for split, listed in {"train": ids, "trainval": ids, "val": ImageSet(()), "test": ImageSet(())}.items():
            sink.put(f"ImageSets/{split}.txt", listed.to_text().encode("ascii"))
        names = "".join(f"{number:06d} {image.name}\n" for number, image in enumerate(found))
        sink.put("names.txt", names.encode("utf-8", "surrogateescape"))
    finally:
        sink.remove_partial()
    return len(found)


def _image(frame: dict[str, Any], number: int, file: str) -> BddImage:
    name = frame.get("name")
    if not isinstance(name, str) or not name or Path(name).name != name or "\n" in name:
        raise FileFormatError(f"frame {number}: name: expected an image's file name, got {shown(name)}", file)
    # Frames in which there is nothing have null or no list.
    entries = frame.get("labels") or []
    if not isinstance(entries, list):
        raise FileFormatError(f"frame {number}: labels: expected a list, got {shown(entries)}", file)
    objects = [_Object.of(entry, f"frame {number}, label {place}", file) for place, entry in enumerate(entries)]
    return BddImage(name, tuple(labels_of([found for found in objects if found is not None])))


@dataclass(frozen=True)
class _Object:
    category: str
    box: _Box
    is_occluded: bool
    is_truncated: bool

    @classmethod
    def of(cls, entry: Any, where: str, file: str) -> _Object | None:
        """Read a label; None for what has no box."""
        if not isinstance(entry, dict):
            raise FileFormatError(f"{where}: expected an object, got {shown(entry)}", file)
        category = entry.get("category")
        if not isinstance(category, str) or category not in TYPES:
            raise FileFormatError(f"{where}: unknown category {shown(category)}; known: {', '.join(TYPES)}", file)
        box = entry.get("box2d")
        if box is None:
            return None
        corners = [box.get(key) if isinstance(box, dict) else None for key in ("x1", "y1", "x2", "y2")]
        if not all(isinstance(v, (int, float)) and not isinstance(v, bool) for v in corners):
            raise FileFormatError(f"{where}: box2d: expected the numbers x1, y1, x2, y2, got {shown(box)}", file)
        left, top, right, bottom = (plain_number(v) for v in corners)
        if not (left <= right and top <= bottom):
            raise FileFormatError(f"{where}: box2d: x1 {left} to x2 {right}, y1 {top} to y2 {bottom} is no box", file)
        is_occluded, is_truncated = (_mark(entry, key, where, file) for key in ("occluded", "truncated"))
        return cls(category, (left, top, right, bottom), is_occluded, is_truncated)


def _mark(entry: dict[str, Any], key: str, where: str, file: str) -> bool:
    attributes = entry.get("attributes") or {}
    mark = attributes.get(key, False) if isinstance(attributes, dict) else None
    if not isinstance(mark, bool):
        raise FileFormatError(f"{where}: {key}: expected true or false, got {shown(mark)}", file)
    return mark


def labels_of(objects: list[_Object]) -> list[Label]:
    """Return KITTI's labels of the objects of an image, DontCare last."""
    labels = [_label(name, found) for found in objects if (name := TYPES[found.category]) is not None]
    ridden = [found for found in objects if found.category in _RIDDEN]
    for rider in (found for found in objects if found.category == "rider"):
        best = max(ridden, key=lambda found: _overlap(found.box, rider.box), default=None)
        if best is None or _overlap(best.box, rider.box) < _LEAST_OVERLAP:
            labels.append(_label("DontCare", rider))
            continue
        ridden.remove(best)
        both = _Object(
            best.category,
            _around(best.box, rider.box),
            best.is_occluded or rider.is_occluded,
            best.is_truncated or rider.is_truncated,
        )
        labels.append(_label(_RIDDEN[best.category], both))
    labels += [_label("DontCare", found) for found in ridden]
    return sorted(labels, key=lambda label: label.type == "DontCare")


def _overlap(a: _Box, b: _Box) -> float:
    """Return the shared area as a part of the smaller box's."""
    width, height = min(a[2], b[2]) - max(a[0], b[0]), min(a[3], b[3]) - max(a[1], b[1])
    if width <= 0.0 or height <= 0.0:
        return 0.0
    return width * height / min((box[2] - box[0]) * (box[3] - box[1]) for box in (a, b))


def _around(a: _Box, b: _Box) -> _Box:
    return (min(a[0], b[0]), min(a[1], b[1]), max(a[2], b[2]), max(a[3], b[3]))


def _label(name: str, found: _Object) -> Label:
    if name == "DontCare":
        return Label.in_image(name, found.box)
    truncated = _FULLY_TRUNCATED if found.is_truncated else 0.0
    return Label.in_image(name, found.box, truncated=truncated, occluded=_UNKNOWN_OCCLUSION if found.is_occluded else 0)
