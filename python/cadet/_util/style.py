"""Colors, text and strokes that every figure shares. Colors are RGB, images (H, W, 3) uint8 RGB."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from typing import Any, Final

import cv2
import numpy as np
from numpy.typing import NDArray

Color = tuple[int, int, int]
Image = NDArray[np.uint8]

BACKGROUND: Final[Color] = (16, 19, 24)
PANEL: Final[Color] = (26, 30, 37)
GRID: Final[Color] = (52, 59, 70)
TEXT: Final[Color] = (222, 227, 234)
FAINT_TEXT: Final[Color] = (140, 149, 161)
HIDDEN: Final[Color] = (244, 63, 60)
VISIBLE: Final[Color] = (74, 222, 94)
DONT_CARE: Final[Color] = (150, 156, 166)

CLASS_COLORS: Final[dict[str, Color]] = {
    "Car": (64, 200, 255),
    "Van": (120, 140, 255),
    "Truck": (196, 130, 255),
    "Pedestrian": (255, 170, 40),
    "Person_sitting": (255, 120, 90),
    "Cyclist": (170, 240, 70),
    "Tram": (255, 110, 200),
    "Misc": (240, 230, 120),
    "DontCare": DONT_CARE,
}
"""One color a type of KITTI's labels."""

_OTHER: Final[Color] = (255, 255, 255)


def class_color(name: str) -> Color:
    """Return the color of a type; that of types that KITTI does not have is white."""
    return CLASS_COLORS.get(name, _OTHER)


_SHIFT: Final = 4
_SUBPIXELS: Final = 1 << _SHIFT
_MAX_COORDINATE_PX: Final = 30_000.0
_FONT: Final = cv2.FONT_HERSHEY_SIMPLEX
_TURBO: Final = np.array(
    cv2.applyColorMap(np.arange(256, dtype=np.uint8)[:, None], cv2.COLORMAP_TURBO)[:, 0, ::-1], np.uint8
)


def turbo(share: NDArray[Any] | float) -> NDArray[np.uint8]:
    """Color shares 0..1 from blue over green to red, leaving out the map's dark ends: (...) to (..., 3) uint8."""
    index = np.rint(np.clip(share, 0.0, 1.0) * 215.0 + 20.0).astype(np.intp)
    colors: NDArray[np.uint8] = _TURBO[index]
    return colors


def depth_share(depth_m: NDArray[Any] | float) -> NDArray[np.float64]:
    """Place depths on a color scale, near at 1: logarithmic from 4 m to 70 m, as what is near fills most pixels."""
    share = (np.log(70.0) - np.log(np.maximum(depth_m, 1e-3))) / (np.log(70.0) - np.log(4.0))
    return np.asarray(np.clip(share, 0.0, 1.0))


def filled(height: int, width: int, color: Color = BACKGROUND) -> Image:
    """Make an image of one color."""
    return np.full((height, width, 3), color, np.uint8)


def dimmed(image: Image, brightness: float, saturation: float) -> Image:
    """Darken an image and take color out of it, so that what is drawn on it stands out."""
    gray = cv2.cvtColor(cv2.cvtColor(image, cv2.COLOR_RGB2GRAY), cv2.COLOR_GRAY2RGB)
    mixed = cv2.addWeighted(image, saturation * brightness, gray, (1.0 - saturation) * brightness, 0.0)
    return np.asarray(mixed, np.uint8)


def stroke(
    image: Image,
    start: Sequence[float] | NDArray[Any],
    end: Sequence[float] | NDArray[Any],
    color: Color,
    width: int = 1,
) -> None:
    """Draw a line between points [u, v] given in fractions of a pixel; one with NaN is left out."""
    if np.isfinite(start).all() and np.isfinite(end).all():
        cv2.line(image, _fixed(start), _fixed(end), color, width, cv2.LINE_AA, _SHIFT)


def polyline(image: Image, points: NDArray[Any], color: Color, width: int = 1, *, is_closed: bool = True) -> None:
    """Draw a line through points (K, 2); left out if any is NaN."""
    if np.isfinite(points).all():
        cv2.polylines(image, [_fixed_array(points)], is_closed, color, width, cv2.LINE_AA, _SHIFT)


def polygon(image: Image, points: NDArray[Any], color: Color, opacity: float) -> None:
    """Fill a convex polygon (K, 2), letting the image shine through; left out if any point is NaN."""
    if not np.isfinite(points).all():
        return
    height, width = image.shape[:2]
    low = np.clip(np.floor(points.min(axis=0)) - 1, 0, [width, height]).astype(int)
    high = np.clip(np.ceil(points.max(axis=0)) + 2, 0, [width, height]).astype(int)
    if (high <= low).any():
        return
    window = image[low[1] : high[1], low[0] : high[0]]
    cover = np.zeros(window.shape[:2], np.uint8)
    cv2.fillConvexPoly(cover, _fixed_array(points - low), 255, cv2.LINE_AA, _SHIFT)
    share = cover[..., None].astype(np.float32) * np.float32(opacity / 255.0)
    window[:] = np.rint(window + share * (np.array(color, np.float32) - window)).astype(np.uint8)


def dot(image: Image, center: Sequence[float] | NDArray[Any], radius: float, color: Color) -> None:
    """Draw a filled circle."""
    if np.isfinite(center).all():
        cv2.circle(image, _fixed(center), round(radius * _SUBPIXELS), color, -1, cv2.LINE_AA, _SHIFT)


def text_size(text: str, scale: float) -> tuple[int, int]:
    """Measure a line of text: width and height of its capitals in pixels."""
    (width, height), _ = cv2.getTextSize(text, _FONT, scale, 1)
    return int(width), int(height)


def write(image: Image, text: str, left: float, baseline: float, scale: float = 0.45, color: Color = TEXT) -> None:
    """Write a line of text whose lower left corner is at (left, baseline)."""
    cv2.putText(image, text, (round(left), round(baseline)), _FONT, scale, color, 1, cv2.LINE_AA)


def write_on_tag(image: Image, text: str, left: float, bottom: float, color: Color, scale: float = 0.4) -> None:
    """Write dark text on a tag of `color` whose lower left corner is at (left, bottom)."""
    left, top, right, bottom = tag_bounds(image, text, left, bottom, scale)
    corners = np.array([[left, top], [right, top], [right, bottom], [left, bottom]])
    polygon(image, corners, color, 0.92)
    write(image, text, left + 3, bottom - 4, scale, BACKGROUND)


def tag_bounds(
    image: Image, text: str, left: float, bottom: float, scale: float = 0.4
) -> tuple[float, float, float, float]:
    """Bound a tag, moved to lie inside the image: left, top, right, bottom in pixels."""
    width, height = text_size(text, scale)
    left = min(max(left, 0.0), image.shape[1] - width - 7.0)
    bottom = min(max(bottom, height + 8.0), image.shape[0] - 1.0)
    return left, bottom - height - 7.0, left + width + 6.0, bottom


def dashes(
    start: NDArray[Any], end: NDArray[Any], length_px: float = 5.0
) -> Iterable[tuple[NDArray[np.float64], NDArray[np.float64]]]:
    """Cut a line into dashes, as far as they can lie in an image."""
    start, end = (np.clip(point, -_MAX_COORDINATE_PX, _MAX_COORDINATE_PX) for point in (start, end))
    span = float(np.linalg.norm(end - start))
    cuts = np.arange(0.0, max(span, 1e-9), 2.0 * length_px)
    for cut in cuts:
        ends = np.array([cut, min(cut + length_px, span)]) / max(span, 1e-9)
        yield start + ends[0] * (end - start), start + ends[1] * (end - start)


def _fixed(point: Sequence[float] | NDArray[Any]) -> tuple[int, int]:
    u, v = np.clip(point, -_MAX_COORDINATE_PX, _MAX_COORDINATE_PX)
    return round(float(u) * _SUBPIXELS), round(float(v) * _SUBPIXELS)


def _fixed_array(points: NDArray[Any]) -> NDArray[np.int32]:
    limited = np.clip(points, -_MAX_COORDINATE_PX, _MAX_COORDINATE_PX)
    return np.asarray(np.rint(limited * _SUBPIXELS), np.int32)
