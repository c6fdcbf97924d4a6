"""The figure of what a detector takes from above: the maps of the paper's three configurations."""

from __future__ import annotations

from pathlib import Path
from typing import Final

import numpy as np
from numpy.typing import NDArray

from cadet import bev
from cadet._util import style
from cadet.bev import BevConfig
from cadet.errors import CadetError
from cadet.figures.picture import check_picture_path, write_picture
from cadet.formats.kitti.calib import points_in_image
from cadet.formats.kitti.drawing.drawable import LEVEL_PLANE
from cadet.formats.kitti.frame import Frame
from cadet.formats.kitti.plane_estimate import estimate_plane

CONFIGURATIONS: Final[dict[str, BevConfig]] = {
    "default": BevConfig.default(),
    "max3_density3": BevConfig.max3_density3(),
    "max_min_density": BevConfig.max_min_density(),
}

_POOLED: Final = 2
_MARGIN: Final = 12
_CAPTION: Final = 26
_TITLE: Final = 30
_FEATURES: Final = {
    "max_height": "max height",
    "min_height": "min height",
    "density": "density",
    "density_log64": "density, log 64",
}


def bev_maps_figure(frame: Frame) -> style.Image:
    """Draw the maps of the three configurations, a row each: 70 m ahead, 40 m to either side.

    Of four cells the greatest value shows. Heights run from blue to red, density from dark to white.

    Args:
        frame: the frame; without a plane its own is estimated, and without points the maps are empty.

    Returns:
        (about 1300, 2484, 3) uint8 RGB.
    """
    points_cam = frame.calib.points_cam_from_velo(frame.points_velo)
    seen_cam = points_cam[points_in_image(points_cam, frame.calib, frame.image_size)]
    plane = _plane(frame)
    rows = []
    for name, config in CONFIGURATIONS.items():
        channels = zip(_captions(config), bev.maps(seen_cam, plane, config), strict=True)
        panels = [_panel(values, caption) for caption, values in channels]
        rows.append((f"{name}: {len(panels)} channels", panels))
    panel_height, panel_width = rows[0][1][0].shape[:2]
    most = max(len(panels) for _, panels in rows)
    page = style.filled(
        len(rows) * (_TITLE + panel_height + _MARGIN) + _MARGIN, most * (panel_width + _MARGIN) + _MARGIN
    )
    top = _MARGIN
    for title, panels in rows:
        style.write(page, title, _MARGIN, top + _TITLE - 12, 0.6)
        top += _TITLE
        for index, panel in enumerate(panels):
            left = _MARGIN + index * (panel_width + _MARGIN)
            page[top : top + panel_height, left : left + panel_width] = panel
        top += panel_height + _MARGIN
    return page


def view_bev_maps(frame: Frame, out_path: str | Path) -> Path:
    """Write the figure of a frame's maps as a PNG or JPEG file, in a folder that is there, and return its path.

    Raises:
        CadetError: the name ends in no picture's suffix, or the folder is not there.
    """
    path = check_picture_path(out_path)
    return write_picture(path, bev_maps_figure(frame))


def _plane(frame: Frame) -> NDArray[np.float64]:
    if frame.plane is not None:
        return frame.plane
    try:
        return estimate_plane(frame.points_velo, frame.calib)
    except CadetError:
        # No road to be seen, as in an empty scan.
        return LEVEL_PLANE


def _captions(config: BevConfig) -> list[str]:
    captions = []
    thickness_m = (config.height_hi_m - config.height_lo_m) / config.num_slices
    for index in range(config.num_slices):
        low_m = config.height_lo_m + index * thickness_m
        captions += [f"{_FEATURES[f]}, {low_m:.1f} to {low_m + thickness_m:.1f} m" for f in config.slice_maps]
    return captions + [f"{_FEATURES[feature]}, whole cloud" for feature in config.cloud_maps]


def _panel(values: NDArray[np.float32], caption: str) -> style.Image:
    height, width = (n // _POOLED for n in values.shape)
    pooled = values[: height * _POOLED, : width * _POOLED].reshape(height, _POOLED, width, _POOLED).max(axis=(1, 3))
    panel = style.filled(height + _CAPTION, width, style.PANEL)
    style.write(panel, caption, 8, 18, 0.45)
    if caption.startswith(_FEATURES["density"]):
        colors = np.rint(60.0 + 195.0 * pooled[..., None] * np.ones(3)).astype(np.uint8)
    else:
        colors = style.turbo(pooled)
    panel[_CAPTION:] = np.where(pooled[..., None] > 0, colors, np.array(style.BACKGROUND, np.uint8))
    return panel
