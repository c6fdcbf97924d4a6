"""Pictures as files, of the kind that the name says."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path
from typing import Any, Final

import cv2
import numpy as np
from numpy.typing import NDArray

from cadet._util.user_files import check_out_path
from cadet.errors import CadetError
from cadet.formats.kitti.files import images
from cadet.formats.kitti.files.folder import write_whole

_JPEG_QUALITY: Final = 95


def check_picture_path(path: str | Path) -> Path:
    """Return where a picture is to be written, refused before there is one to write.

    Raises:
        CadetError: a name that ends in nothing known, or that is a folder's.
        MissingFileError: the folder is not there.
    """
    return check_out_path(path, _ENCODERS)


def write_picture(path: str | Path, image: NDArray[np.uint8]) -> Path:
    """Write a picture, whole or not at all.

    Args:
        path: ends in .png, or in .jpg or .jpeg for JPEG of quality 95.
        image: (H, W, 3) uint8 RGB.

    Returns:
        The path.

    Raises:
        CadetError: a name that ends in nothing known, or that is a folder's.
        MissingFileError: the folder is not there.
    """
    path = check_picture_path(path)
    write_whole({path: _ENCODERS[path.suffix.lower()](image)})
    return path


def _encode_jpeg(image: NDArray[Any]) -> bytes:
    done, data = cv2.imencode(".jpg", cv2.cvtColor(image, cv2.COLOR_RGB2BGR), [cv2.IMWRITE_JPEG_QUALITY, _JPEG_QUALITY])
    if not done:
        raise CadetError(f"a picture of {image.shape[1]} x {image.shape[0]} pixels is too large for JPEG")
    return data.tobytes()


_ENCODERS: Final[dict[str, Callable[[NDArray[Any]], bytes]]] = {
    ".png": images.encode_png,
    ".jpg": _encode_jpeg,
    ".jpeg": _encode_jpeg,
}
