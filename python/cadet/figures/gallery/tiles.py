"""Pages of pictures side by side, each with a line of text below it."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Final

import cv2
import numpy as np

from cadet._util import style

_GAP_PX: Final = 6
_LINE_PX: Final = 18
_TITLE_PX: Final = 34


def fitted(image: style.Image, width: int, height: int) -> style.Image:
    """Scale a picture to lie within width x height pixels, and put it in the middle of that."""
    scale = min(width / image.shape[1], height / image.shape[0])
    size = (max(round(image.shape[1] * scale), 1), max(round(image.shape[0] * scale), 1))
    scaled = cv2.resize(image, size, interpolation=cv2.INTER_AREA if scale < 1.0 else cv2.INTER_CUBIC)
    tile = style.filled(height, width, style.PANEL)
    left, top = (width - size[0]) // 2, (height - size[1]) // 2
    tile[top : top + size[1], left : left + size[0]] = scaled
    return tile


def page(title: str, tiles: Sequence[tuple[str, style.Image]], *, across: int, tile_px: tuple[int, int]) -> style.Image:
    """Compose a page.

    Args:
        title: printed at its top.
        tiles: what is written below each picture, and the picture, of any size.
        across: pictures side by side.
        tile_px: width and height that each gets.

    Returns:
        (H, W, 3) uint8 RGB.
    """
    width, height = tile_px
    rows = -(-len(tiles) // across)
    row_px = height + _LINE_PX + _GAP_PX
    sheet = style.filled(_TITLE_PX + rows * row_px, _GAP_PX + across * (width + _GAP_PX))
    style.write(sheet, title, _GAP_PX + 2, _TITLE_PX - 12, 0.6)
    for number, (caption, picture) in enumerate(tiles):
        top = _TITLE_PX + number // across * row_px
        left = _GAP_PX + number % across * (width + _GAP_PX)
        sheet[top : top + height, left : left + width] = fitted(picture, width, height)
        style.write(sheet, caption, left + 2, top + height + _LINE_PX - 5, 0.38, style.FAINT_TEXT)
    return np.ascontiguousarray(sheet)
