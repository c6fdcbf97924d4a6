"""The lint of what is there twice.

Two frames are near-duplicates if images and scans are nearly the same and no labeled object has come, gone, or moved:
a car that waits at a red light sees one street and other cars. Measured on 45 real and 84
generated frames, the most alike pair of a set: image 0.92 (in dense fog), scans 0.023; a frame beside its own copy with
JPEG's quality 30, 20 % more light, noise of 8 gray levels or of 3 cm: image 0.989, scans 0.018.
"""

from __future__ import annotations

import itertools
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from hashlib import sha256
from typing import Final

import numpy as np
from numpy.typing import NDArray

from cadet.formats.kitti.frame import Frame
from cadet.formats.kitti.lint.finding import Problem

_SMALL_SIZE: Final = (48, 16)
_ALIKE_IMAGES: Final = 0.97
_ALIKE_SCANS: Final = 0.022
_MOVED_PX: Final = 8.0
"""Of 1242: an object whose 2D box has moved by more makes another sample, as it does for the generator."""
_WIDTH_PX: Final = 1242.0
_NUM_SECTORS: Final = 64
_HALF_SECTORS_RAD: Final = 0.7
"""To either side of the car's front: within the image, as some scans are cut to it."""
_BLOCK: Final = 2048


@dataclass(frozen=True, eq=False)
class Signature:
    """What tells a frame from others.

    Attributes:
        image_hash: of the image's pixels.
        scan_hash: of the scan's points; empty for a scan without points.
        small_image: (48 * 16,) float32, gray, of mean 0 and length 1.
        log_ranges: (64,) float32: the logarithm of a meter plus the median range of each sector ahead.
        types: of the M objects.
        boxes_img: (M, 4) float32: the 2D box of each, in pixels of an image 1242 pixels wide.
    """

    image_hash: bytes
    scan_hash: bytes
    small_image: NDArray[np.float32]
    log_ranges: NDArray[np.float32]
    types: NDArray[np.str_]
    boxes_img: NDArray[np.float32]


def signature_of(frame: Frame) -> Signature:
    """Return a frame's signature."""
    import cv2  # here, as `import cadet` does without it

    gray = cv2.cvtColor(frame.image, cv2.COLOR_RGB2GRAY)
    small = cv2.resize(gray, _SMALL_SIZE, interpolation=cv2.INTER_AREA).astype(np.float32).ravel()
    small -= small.mean()
    points = frame.points_velo
    objects = [label for label in frame.labels if not label.is_dont_care]
    scale = _WIDTH_PX / frame.image_size[0]
    return Signature(
        image_hash=sha256(frame.image.tobytes()).digest(),
        scan_hash=sha256(points.tobytes()).digest() if len(points) else b"",
        small_image=small / np.float32(max(float(np.linalg.norm(small)), 1e-6)),
        log_ranges=_log_ranges(points),
        types=np.array([label.type for label in objects], np.str_),
        boxes_img=scale * np.array([label.bbox for label in objects], np.float32).reshape(-1, 4),
    )


def lint_duplicates(signatures: Sequence[Signature], names: Sequence[str]) -> Iterator[tuple[int, str, Problem]]:
    """Yield frames that are there twice: the later one's index, the folder of the file, and what is wrong with it.

    Args:
        signatures: of the frames, in order.
        names: the frames' names for messages.
    """
    images: dict[bytes, int] = {}
    scans: dict[bytes, int] = {}
    alike = dict(_alike_pairs(signatures))
    for index, signature in enumerate(signatures):
        image = images.setdefault(signature.image_hash, index)
        scan = scans.setdefault(signature.scan_hash, index) if signature.scan_hash else index
        if image != index:
            yield index, "image_2", Problem(None, "duplicate-frame", f"the same pixels as {names[image]}'s")
        if scan != index and scan != image:
            yield index, "velodyne", Problem(None, "duplicate-frame", f"the same points as {names[scan]}'s")
        if image == scan == index and index in alike:
            message = f"image and scan are nearly those of {names[alike[index]]}"
            yield index, "image_2", Problem(None, "duplicate-frame", message, "warning")


def _alike_pairs(signatures: Sequence[Signature]) -> Iterator[tuple[int, int]]:
    """Yield each frame that is nearly an earlier one, with the first of these."""
    if not signatures:
        return
    small = np.stack([signature.small_image for signature in signatures])
    ranges = np.stack([signature.log_ranges for signature in signatures])
    for start in range(0, len(small), _BLOCK):
        # Rows are the later frames, columns the earlier ones.
        alike = small[start : start + _BLOCK] @ small[: start + _BLOCK].T >= _ALIKE_IMAGES
        found: set[int] = set()
        for row, column in np.argwhere(np.tril(alike, start - 1)):
            later = start + int(row)
            if later in found or np.median(np.abs(ranges[later] - ranges[column])) > _ALIKE_SCANS:
                continue
            if _have_same_objects(signatures[later], signatures[int(column)]):
                found.add(later)
                yield later, int(column)


def _have_same_objects(one: Signature, other: Signature) -> bool:
    """Tell whether each object of either has one of its type, with nearly its box, in the other."""
    if len(one.types) != len(other.types):
        return False
    if not len(one.types):
        return True
    is_type = one.types[:, None] == other.types[None, :]
    moved_px = np.abs(one.boxes_img[:, None] - other.boxes_img[None, :]).max(axis=2)
    is_same = is_type & (moved_px < _MOVED_PX)
    return bool(is_same.any(axis=0).all() and is_same.any(axis=1).all())


def _log_ranges(points_velo: NDArray[np.float32]) -> NDArray[np.float32]:
    azimuth_rad = np.arctan2(points_velo[:, 1], points_velo[:, 0])
    sector = np.floor((azimuth_rad / (2.0 * _HALF_SECTORS_RAD) + 0.5) * _NUM_SECTORS).astype(np.intp)
    order = np.argsort(sector, kind="stable")
    range_m = np.hypot(points_velo[:, 0], points_velo[:, 1])[order]
    edges = np.searchsorted(sector[order], np.arange(_NUM_SECTORS + 1))
    medians = [np.median(range_m[a:b]) if b > a else 0.0 for a, b in itertools.pairwise(edges)]
    return np.log1p(np.array(medians, np.float32))
