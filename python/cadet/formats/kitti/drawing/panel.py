"""A frame in one picture: its boxes above its returns in the image, beside the scan from above."""

from __future__ import annotations

from typing import Final

import numpy as np

from cadet._util import style
from cadet._util.checks import check_number
from cadet.formats.kitti.drawing.bev import bev_figure
from cadet.formats.kitti.drawing.camera import boxes_figure, lidar_figure
from cadet.formats.kitti.drawing.drawable import Drawable, enlarged, resized

MARGIN: Final = 20
"""Between figures, in pixels."""
FINE_WIDTH: Final = 1000
"""A camera image of so many pixels has fine strokes."""

_BEV_SHARE: Final = 0.4


def panel(frame: Drawable, width: int = 1600) -> style.Image:
    """Draw a frame: labeled boxes and LIDAR returns in the image, and the scan from above with the boxes.

    Args:
        frame: the frame.
        width: of the picture in pixels, 200 to 16384; the height follows.

    Returns:
        (H, width, 3) uint8 RGB.

    Raises:
        CadetError: a width out of range.
    """
    check_number("", "width", width, 200, 16_384, whole=True)
    bev_width = round(width * _BEV_SHARE)
    camera_width = width - bev_width - 3 * MARGIN
    large = enlarged(frame, FINE_WIDTH)
    figures = [resized(figure(large), camera_width) for figure in (boxes_figure, lidar_figure)]
    camera = np.concatenate([figures[0], style.filled(MARGIN // 2, camera_width), figures[1]])
    page = style.filled(len(camera), width)
    page[:, MARGIN : MARGIN + camera_width] = camera
    page[:, 2 * MARGIN + camera_width : 2 * MARGIN + camera_width + bev_width] = _fitted(
        bev_figure(frame, bev_width, has_text=False), len(camera)
    )
    return page


def _fitted(image: style.Image, height: int) -> style.Image:
    """Keep the lower rows, which show what is near, or fill up above."""
    page = style.filled(height, image.shape[1])
    num_rows = min(height, len(image))
    page[height - num_rows :] = image[len(image) - num_rows :]
    return page
