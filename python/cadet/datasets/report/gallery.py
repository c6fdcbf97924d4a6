"""Frames for the page: a small image, boxes to be drawn over it, and points of the scan."""

from __future__ import annotations

import base64
from collections.abc import Iterable
from dataclasses import dataclass
from html import escape
from pathlib import Path
from typing import Any, Final

import cv2
import numpy as np
from numpy.typing import NDArray

from cadet._util import style
from cadet.errors import CadetError
from cadet.formats.kitti import Calibration, Frame, Label, boxes, read_frame
from cadet.formats.kitti.files.folder import file_path, frame_ids, sample_folder
from cadet.formats.kitti.files.unreadable import READING_ERRORS, Unreadable

_IMAGE_WIDTH_PX: Final = 960
_MOST_JPEG_BYTES: Final = 150_000
_QUALITIES: Final = (82, 70, 55, 40)
_NUM_POINTS: Final = 20_000
_RANGE_M: Final = 60.0
_STEPS_PER_M: Final = 500.0
"""Points travel as 16-bit whole numbers: steps of 2 mm up to 65 m."""
_FARTHEST_M: Final = 1000.0
"""A damaged label's box may be too far away to be drawn."""


@dataclass(frozen=True)
class Picture:
    """A frame of the gallery.

    Attributes:
        frame_id: of the frame.
        caption: weather and the like; empty where nothing is known.
        svg: image and boxes.
        cloud: what the viewer draws: `points` in base64 (little-endian int16 x, y, z in steps, then uint8 intensity,
            each for all points), `steps` per meter, and `boxes` (class and corners, meters, velo frame).
    """

    frame_id: str
    caption: str
    svg: str
    cloud: dict[str, Any]


def pictures(root: str | Path, number: int) -> list[Picture]:
    """Return frames spread over a dataset, so that several episodes show; those that cannot be read are left out.

    Raises:
        MissingFileError: no KITTI folder.
    """
    folder = sample_folder(root)
    ids = [one for one in frame_ids(folder) if file_path(folder, "label_2", one).is_file()]
    number = min(number, len(ids))
    chosen = [ids[index * len(ids) // number] for index in range(number)]
    unreadable, found = Unreadable(root), []
    for frame_id in chosen:
        try:
            found.append(_picture(frame_id, read_frame(folder, frame_id)))
        except READING_ERRORS as error:
            unreadable.add(frame_id, error)
    unreadable.warn(number, "have no picture")
    return found


def class_color(name: str) -> str:
    """Return a class's color as CSS has it."""
    red, green, blue = style.class_color(name)
    return f"#{red:02x}{green:02x}{blue:02x}"


def _picture(frame_id: str, frame: Frame) -> Picture:
    meta = frame.meta or {}
    words = [str(meta[name]) for name in ("district", "weather") if isinstance(meta.get(name), str)]
    return Picture(frame_id, ", ".join(words).replace("_", " "), _svg(frame_id, frame), _cloud(frame))


def _svg(frame_id: str, frame: Frame) -> str:
    width, height = frame.image_size
    # From far to near: what is near lies on top.
    objects = sorted((one for one in frame.labels if not one.is_dont_care), key=lambda one: -one.location_cam[2])
    regions = [one for one in frame.labels if one.is_dont_care]
    rectangles = "".join(_rectangle(label) for label in objects)
    wires = "".join(_wire(label, frame.calib) for label in objects)
    named = f'role="img" aria-label="Frame {escape(frame_id)} with its boxes"'
    return (
        f'<svg class="frame" viewBox="0 0 {width} {height}" {named}>'
        f'<image width="{width}" height="{height}" href="data:image/jpeg;base64,{_jpeg(frame.image)}"/>'
        f'<g class="dontcare">{"".join(_rectangle(label) for label in regions)}</g>'
        f'<g class="box2d">{rectangles}</g><g class="box3d">{wires}</g></svg>'
    )


def _rectangle(label: Label) -> str:
    left, top, right, bottom = label.bbox
    color = class_color(label.type)
    size = f'width="{max(right - left, 0.0):.1f}" height="{max(bottom - top, 0.0):.1f}"'
    return f'<rect x="{left:.1f}" y="{top:.1f}" {size} stroke="{color}"><title>{_says(label)}</title></rect>'


def _wire(label: Label, calib: Calibration) -> str:
    corners = boxes.corners_cam(label.box_cam[None])[0]
    if np.abs(corners).max() > _FARTHEST_M:
        return ""
    starts, ends = boxes.clip_segments(corners[[a for a, _ in boxes.EDGES]], corners[[b for _, b in boxes.EDGES]])
    # The cross on the front tells the heading.
    front = corners[list(boxes.FRONT)]
    crossed = boxes.clip_segments(front[[0, 1]], front[[2, 3]])
    starts_img, ends_img = (calib.project(np.concatenate(pair)) for pair in ((starts, crossed[0]), (ends, crossed[1])))
    is_there = np.isfinite(starts_img).all(axis=1) & np.isfinite(ends_img).all(axis=1)
    path = "".join(
        f"M{a:.1f} {b:.1f}L{c:.1f} {d:.1f}"
        for (a, b), (c, d) in zip(starts_img[is_there], ends_img[is_there], strict=True)
    )
    return f'<path d="{path}" stroke="{class_color(label.type)}"><title>{_says(label)}</title></path>'


def _says(label: Label) -> str:
    if label.is_dont_care:
        return "DontCare"
    distance_m = float(np.hypot(label.location_cam[0], label.location_cam[2]))
    return escape(f"{label.type}, {distance_m:.0f} m, occluded {label.occluded}, truncated {label.truncated:.2f}")


def _jpeg(image: NDArray[np.uint8]) -> str:
    """Encode an image no wider than the page shows it, in as good a quality as its share of the page allows."""
    height, width = image.shape[:2]
    scale = min(1.0, _IMAGE_WIDTH_PX / width)
    size = (max(round(width * scale), 1), max(round(height * scale), 1))
    small = cv2.cvtColor(cv2.resize(image, size, interpolation=cv2.INTER_AREA), cv2.COLOR_RGB2BGR)
    for quality in _QUALITIES:
        is_done, data = cv2.imencode(".jpg", small, [cv2.IMWRITE_JPEG_QUALITY, quality])
        if not is_done:
            raise CadetError(f"an image of {size[0]} x {size[1]} pixels is too large for JPEG")
        if data.nbytes <= _MOST_JPEG_BYTES:
            break
    return base64.b64encode(data.tobytes()).decode("ascii")


def _cloud(frame: Frame) -> dict[str, Any]:
    points = frame.points_velo[np.abs(frame.points_velo[:, :2]).max(axis=1, initial=0.0) <= _RANGE_M]
    # Every n-th return: the scan's order runs along its lines, so that all of it stays.
    kept = points[np.linspace(0, len(points) - 1, min(_NUM_POINTS, len(points))).astype(np.intp)]
    steps = np.clip(np.rint(kept[:, :3] * _STEPS_PER_M), -32768, 32767).astype("<i2")
    intensity = np.clip(np.rint(kept[:, 3] * 255.0), 0, 255).astype(np.uint8)
    return {
        "points": base64.b64encode(steps.tobytes() + intensity.tobytes()).decode("ascii"),
        "steps": _STEPS_PER_M,
        "boxes": list(_velo_boxes(frame.labels, frame.calib)),
    }


def _velo_boxes(labels: Iterable[Label], calib: Calibration) -> Iterable[dict[str, Any]]:
    for label in labels:
        if label.is_dont_care:
            continue
        corners = boxes.corners_cam(label.box_cam[None])[0]
        if np.abs(corners).max() <= _FARTHEST_M:
            corners_velo = calib.points_velo_from_cam(corners)
            yield {"type": label.type, "color": class_color(label.type), "corners": corners_velo.round(2).tolist()}
