"""The lint of `meta` files: is it the record of this very frame?"""

from __future__ import annotations

from collections.abc import Iterator
from typing import Any

from cadet.formats.kitti.frame import Frame
from cadet.formats.kitti.label import Label
from cadet.formats.kitti.lint.finding import Problem
from cadet.formats.kitti.lint.labels import ROUNDING
from cadet.formats.kitti.lint.lists import is_number
from cadet.formats.record_seal import SEAL, is_intact

_XYZ = 3


def lint_meta(meta: dict[str, Any], frame: Frame) -> Iterator[tuple[str, Problem]]:
    """Yield what is wrong with a `meta`, or with the files that it speaks of: the folder, and the problem."""
    for message in _lint_objects(meta, frame.labels):
        yield "meta", Problem(None, "meta", message)
    size = meta.get("image_size")
    if size is not None and not (isinstance(size, list) and all(map(is_number, size))):
        yield "meta", Problem(None, "meta", "image_size: expected two numbers")
    elif size is not None and size != list(frame.image_size):
        yield "image_2", Problem(None, "meta", f"image is {list(frame.image_size)} pixels, meta says {size}")


def episode_of(meta: dict[str, Any] | None) -> tuple[object, object] | None:
    """Return seed and number of the episode that a frame is of; None where its `meta` does not say."""
    episode = None if meta is None else meta.get("episode")
    if meta is None or not isinstance(episode, int):
        return None
    seed = meta.get("seed")
    return seed if isinstance(seed, int) else None, episode


def lint_seal(record: bytes, meta: dict[str, Any]) -> Iterator[Problem]:
    """Compare the bytes of a `meta` with the hash that it carries of itself, if it does."""
    hashes = meta.get("sha256")
    if isinstance(hashes, dict) and SEAL in hashes and not is_intact(record, hashes[SEAL]):
        yield Problem(None, "wrong-hash", "not as it was written, by its own hash: cadet-gen --resume makes it anew")


def recorded_hashes(meta: dict[str, Any] | None) -> dict[str, str]:
    """Return the hashes that a `meta` carries, by folder."""
    hashes = None if meta is None else meta.get("sha256")
    if not isinstance(hashes, dict):
        return {}
    return {kind: digest for kind, digest in hashes.items() if isinstance(digest, str)}


def _lint_objects(meta: dict[str, Any], labels: tuple[Label, ...]) -> Iterator[str]:
    if "objects" not in meta:
        return
    objects = meta["objects"]
    if not (isinstance(objects, list) and all(isinstance(one, dict) for one in objects)):
        yield "objects: expected a list of JSON objects"
    elif len(objects) != len(labels):
        yield f"{len(objects)} objects, label_2 has {len(labels)} lines"
    else:
        yield from _compare_objects(objects, labels)


def _compare_objects(objects: list[dict[str, Any]], labels: tuple[Label, ...]) -> Iterator[str]:
    """Compare type and place line by line; of a DontCare region the metadata knows what it really is."""
    for line, (one, label) in enumerate(zip(objects, labels, strict=True), start=1):
        if label.is_dont_care:
            continue
        kind, place = one.get("type", label.type), one.get("location_cam")
        if kind != label.type:
            shown = kind if isinstance(kind, str) and kind.isidentifier() else "no type"
            yield f"object {line} is {shown}, label_2 says {label.type} on line {line}"
        elif place is not None and not _is_place(place, label.location_cam):
            yield f"object {line} lies elsewhere than line {line} of label_2: {label.location_cam}"


def _is_place(place: object, location_cam: tuple[float, float, float]) -> bool:
    if not isinstance(place, list) or len(place) != _XYZ or not all(map(is_number, place)):
        return False
    return all(abs(x - at) <= ROUNDING for x, at in zip(place, location_cam, strict=True))
