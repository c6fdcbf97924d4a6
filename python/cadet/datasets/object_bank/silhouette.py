"""Which pixels of an image are an object's."""

from __future__ import annotations

from typing import Final

import cv2
import numpy as np
from numpy.typing import NDArray

_MOST_STRETCH: Final = 1.6
"""Points show less of an object than its rectangle; where they show far less, their hull says little of its outline."""
_LEAST_FILLED: Final = 0.72
"""Of the box's outline within the rectangle: a hull of few points is a triangle or a diamond, and cuts corners off."""
_AROUND: Final = 0.15
"""Of the rectangle's longer side: the background about it that colors are taken from."""
_SURE: Final = 0.12
"""Of its shorter side: a hull's border is an object's only perhaps."""
_ROUNDS: Final = 4
_LEAST_KEPT, _MOST_GAINED = 0.55, 1.15
_LEAST_SOLID: Final = 0.9
"""Of its convex hull: a vehicle with less is hidden in part by something without a label."""


def silhouette_from_instances(
    instance: NDArray[np.int32], points_img: NDArray[np.float64], box_img: tuple[float, float, float, float]
) -> NDArray[np.uint8] | None:
    """Return the pixels of the instance that most of an object's points lie on.

    Args:
        instance: (H, W) ids, 1 and above for objects.
        points_img: (N, 2) [u, v] of the object's points, inside the image.
        box_img: its rectangle (left, top, right, bottom), which the silhouette may pass by a pixel.

    Returns:
        (H, W), 255 inside and 0 elsewhere; None where most points lie on no instance.
    """
    columns, rows = np.rint(points_img).astype(np.intp).T
    height, width = instance.shape
    ids = instance[np.clip(rows, 0, height - 1), np.clip(columns, 0, width - 1)]
    values, counts = np.unique(ids, return_counts=True)
    best = values[counts.argmax()]
    if best < 1 or 2 * counts.max() < len(ids):
        return None
    left, top, right, bottom = box_img
    window = np.zeros((height, width), np.bool_)
    window[max(int(top) - 1, 0) : int(bottom) + 3, max(int(left) - 1, 0) : int(right) + 3] = True
    return np.where(window & (instance == best), 255, 0).astype(np.uint8)


def is_solid(mask: NDArray[np.uint8]) -> bool:
    """Tell whether a silhouette (H, W) fills its convex hull as a vehicle's does that nothing hides."""
    rows, columns = np.nonzero(mask)
    hull = _filled(np.column_stack([columns, rows]).astype(np.float64), (mask.shape[1], mask.shape[0]))
    return bool(len(rows) >= _LEAST_SOLID * np.count_nonzero(hull))


def silhouette_from_points(
    image_size: tuple[int, int],
    points_img: NDArray[np.float64],
    corners_img: NDArray[np.float64],
    box_img: tuple[float, float, float, float],
) -> NDArray[np.uint8] | None:
    """Return the convex hull of an object's points, stretched to fill its rectangle.

    Args:
        image_size: width and height in pixels.
        points_img: (N, 2) [u, v] of the object's points.
        corners_img: (8, 2) of its box.
        box_img: its rectangle (left, top, right, bottom), which annotators draw tightly.

    Returns:
        (H, W), 255 inside and 0 elsewhere; None where the points cover too little of the rectangle.
    """
    low, high = points_img.min(axis=0), points_img.max(axis=0)
    corner, extent = np.array(box_img[:2]), np.array(box_img[2:]) - box_img[:2]
    if not (high - low > extent / _MOST_STRETCH).all():
        return None
    mask = _filled((points_img - low) / (high - low) * extent + corner, image_size)
    outline = _filled(corners_img, image_size)
    left, top, right, bottom = (round(value) for value in box_img)
    possible = np.count_nonzero(outline[max(top, 0) : bottom + 1, max(left, 0) : right + 1])
    return mask if np.count_nonzero(mask) >= _LEAST_FILLED * possible else None


def refined_silhouette(
    image: NDArray[np.uint8], mask: NDArray[np.uint8], box_img: tuple[float, float, float, float]
) -> NDArray[np.uint8]:
    """Draw a rough silhouette's border where the colors of object and background part.

    Args:
        image: (H, W, 3) RGB.
        mask: (H, W), 255 inside; its middle is the object's for sure.
        box_img: the object's rectangle (left, top, right, bottom); what is outside is background for sure.

    Returns:
        (H, W), 255 inside; `mask` itself where the colors would make it far smaller or larger.

    Reference: Rother, Kolmogorov, and Blake, "GrabCut" (2004), OpenCV's implementation.
    """
    left, top, right, bottom = box_img
    smaller = min(right - left, bottom - top)
    around = max(_AROUND * max(right - left, bottom - top), 4.0)
    (rows, columns), (inner_rows, inner_columns) = (_window(box_img, room, mask.shape) for room in (around, 1.0))
    rough = mask[rows, columns] > 0
    sure = round(_SURE * smaller)
    middle = cv2.erode(rough.astype(np.uint8), np.ones((2 * sure + 1, 2 * sure + 1), np.uint8)) > 0
    whole = np.full(mask.shape, cv2.GC_BGD, np.uint8)
    whole[inner_rows, inner_columns] = cv2.GC_PR_BGD
    kinds: NDArray[np.uint8] = whole[rows, columns].copy()
    kinds[rough], kinds[middle] = cv2.GC_PR_FGD, cv2.GC_FGD
    if not middle.any():
        return mask
    # GrabCut draws its first clusters from OpenCV's own generator.
    cv2.setRNGSeed(0)
    pixels = np.ascontiguousarray(image[rows, columns])
    cv2.grabCut(pixels, kinds, (0, 0, 0, 0), np.zeros((1, 65)), np.zeros((1, 65)), _ROUNDS, cv2.GC_INIT_WITH_MASK)
    found = np.isin(kinds, (cv2.GC_FGD, cv2.GC_PR_FGD)).astype(np.uint8)
    # Without single pixels and hairs, in one piece, and without holes.
    cross = cv2.getStructuringElement(cv2.MORPH_CROSS, (3, 3))
    pieces, _ = cv2.findContours(
        cv2.morphologyEx(found, cv2.MORPH_OPEN, cross), cv2.RETR_EXTERNAL, cv2.CHAIN_APPROX_NONE
    )
    piece = np.zeros_like(found)
    if pieces:
        cv2.drawContours(piece, [max(pieces, key=cv2.contourArea)], -1, 255, cv2.FILLED)
    if not _LEAST_KEPT <= np.count_nonzero(piece) / np.count_nonzero(rough) <= _MOST_GAINED:
        return mask
    refined = np.zeros_like(mask)
    refined[rows, columns] = piece
    return refined


def _window(box_img: tuple[float, float, float, float], room_px: float, shape: tuple[int, ...]) -> tuple[slice, slice]:
    left, top, right, bottom = box_img
    return (
        slice(max(int(top - room_px), 0), min(int(bottom + room_px) + 1, shape[0])),
        slice(max(int(left - room_px), 0), min(int(right + room_px) + 1, shape[1])),
    )


def _filled(points_img: NDArray[np.float64], image_size: tuple[int, int]) -> NDArray[np.uint8]:
    """Fill the convex hull of points: (H, W), 255 inside."""
    hull = np.asarray(cv2.convexHull(points_img.astype(np.float32)))
    mask = np.zeros((image_size[1], image_size[0]), np.uint8)
    cv2.fillConvexPoly(mask, np.rint(hull * 16.0).astype(np.int32), 255, lineType=cv2.LINE_8, shift=4)
    return mask
