"""All figures of a frame on one sheet, and contact sheets of several frames."""

from __future__ import annotations

from collections import Counter
from collections.abc import Iterable
from pathlib import Path
from typing import Final

import numpy as np

from cadet._util import style
from cadet.errors import CadetError
from cadet.figures.picture import check_picture_path, write_picture
from cadet.formats.kitti.calib import points_in_image
from cadet.formats.kitti.drawing.bev import bev_figure, height_colors
from cadet.formats.kitti.drawing.camera import boxes_figure, corners_figure, far_to_near, lidar_figure
from cadet.formats.kitti.drawing.drawable import enlarged, resized
from cadet.formats.kitti.drawing.panel import FINE_WIDTH, MARGIN, panel
from cadet.formats.kitti.drawing.visibility import corner_visibility
from cadet.formats.kitti.frame import Frame

SHEET_WIDTH_PX: Final = 1920

_CAPTION: Final = 30
_LEGEND_COLUMNS: Final = 5


def sheet(frame: Frame, title: str = "") -> style.Image:
    """Compose all figures of a frame: the camera's on the left, the one from above on the right, a legend below it.

    Args:
        frame: the frame.
        title: printed over the legend, such as the frame's id.

    Returns:
        (about 1090, 1920, 3) uint8 RGB; the height follows the camera image's.
    """
    large = enlarged(frame, FINE_WIDTH)
    is_visible, source = corner_visibility(frame, far_to_near(frame.labels))
    drawn = {
        "boxes": boxes_figure(large),
        "lidar": lidar_figure(large),
        "corners": corners_figure(large, is_visible),
    }
    captions = {
        "boxes": "Labels: 2D and 3D boxes, arrows along the heading",
        "lidar": _lidar_caption(frame),
        "corners": f"Box corners: green visible, red hidden ({source})",
    }
    rows = [_panel(resized(drawn[name], FINE_WIDTH), caption) for name, caption in captions.items()]
    right_width = SHEET_WIDTH_PX - FINE_WIDTH - 3 * MARGIN
    bev = _panel(bev_figure(frame, right_width), "From above: returns by height over ground, rings every 10 m")
    left_height = sum(len(row) for row in rows) + (len(rows) - 1) * MARGIN
    legend_height = max(left_height - len(bev) - MARGIN, 190)
    height = max(left_height, len(bev) + MARGIN + legend_height) + 2 * MARGIN
    page = style.filled(height, SHEET_WIDTH_PX)
    top = MARGIN
    for row in rows:
        page[top : top + len(row), MARGIN : MARGIN + FINE_WIDTH] = row
        top += len(row) + MARGIN
    left = FINE_WIDTH + 2 * MARGIN
    page[MARGIN : MARGIN + len(bev), left : left + right_width] = bev
    top = MARGIN + len(bev) + MARGIN
    page[top : top + legend_height, left : left + right_width] = _legend(frame, right_width, legend_height, title)
    return page


def overview(frames: Iterable[Frame], path: str | Path, *, width: int = 1600) -> Path:
    """Write a contact sheet: for each frame its boxes above its LIDAR in the image, beside the figure from above.

    Args:
        frames: the frames, best 3 to 6; they must not be none.
        path: the PNG or JPEG file to write, in a folder that is there.
        width: of the sheet in pixels.

    Returns:
        `path`.

    Raises:
        CadetError: no frames, or the name ends in no picture's suffix.
    """
    path = check_picture_path(path)
    rows = [panel(frame, width) for frame in frames]
    if not rows:
        raise CadetError("overview: no frames")
    gap = style.filled(MARGIN, width)
    page = np.concatenate([part for row in rows for part in (gap, row)] + [gap])
    return write_picture(path, page)


def _lidar_caption(frame: Frame) -> str:
    points_cam = frame.calib.points_cam_from_velo(frame.points_velo)
    num_seen = int(points_in_image(points_cam, frame.calib, frame.image_size).sum())
    return f"LIDAR: {num_seen:,} of {len(points_cam):,} returns fall into the image, colored by depth"


def _panel(figure: style.Image, caption: str) -> style.Image:
    panel = style.filled(len(figure) + _CAPTION, figure.shape[1], style.PANEL)
    style.write(panel, caption, 12, 20, 0.48)
    panel[_CAPTION:] = figure
    return panel


def _legend(frame: Frame, width: int, height: int, title: str) -> style.Image:
    panel = style.filled(height, width, style.PANEL)
    left, line = 16, 30
    if title:
        style.write(panel, title, left, line, 0.62)
        line += 30
    for text in _facts(frame):
        style.write(panel, text, left, line, 0.45, style.FAINT_TEXT)
        line += 22
    line += 8
    counts = Counter(label.type for label in frame.labels)
    column_width = (width - 2 * left) // _LEGEND_COLUMNS
    names = [*style.CLASS_COLORS, *sorted(set(counts) - set(style.CLASS_COLORS))]
    for index, name in enumerate(names):
        x, y = left + index % _LEGEND_COLUMNS * column_width, line + index // _LEGEND_COLUMNS * 26
        swatch = np.array([[x, y - 10], [x + 12, y - 10], [x + 12, y + 2], [x, y + 2]])
        style.polygon(panel, swatch, style.class_color(name), 1.0 if counts[name] else 0.35)
        text_color = style.TEXT if counts[name] else style.FAINT_TEXT
        style.write(panel, f"{name} {counts[name] or ''}", x + 20, y, 0.45, text_color)
    bottom = line + -(-len(names) // _LEGEND_COLUMNS) * 26
    if bottom + 30 <= height:
        _draw_height_scale(panel, left, bottom, min(260, width - 2 * left))
    return panel


def _draw_height_scale(panel: style.Image, left: int, top: int, width: int) -> None:
    colors = height_colors(np.linspace(0.0, 1.0, width))
    panel[top : top + 8, left : left + width] = np.rint(colors).astype(np.uint8)[None]
    for height_m in (0, 1, 2, 3):
        x = left + (height_m + 0.3) / 3.3 * (width - 1)
        style.stroke(panel, (x, top + 8), (x, top + 11), style.TEXT)
        text = f"{height_m} m" if height_m else "ground"
        style.write(panel, text, x - style.text_size(text, 0.38)[0] / 2, top + 24, 0.38, style.FAINT_TEXT)


def _facts(frame: Frame) -> list[str]:
    width, height = frame.image_size
    num_regions = sum(label.is_dont_care for label in frame.labels)
    facts = [f"{len(frame.labels) - num_regions} objects, {num_regions} DontCare regions, image {width} x {height}"]
    meta = frame.meta or {}
    noted = [
        f"{key} {meta[key]}" for key in ("map", "weather", "episode", "sample") if isinstance(meta.get(key), str | int)
    ]
    if noted:
        facts.append(", ".join(noted))
    return facts
