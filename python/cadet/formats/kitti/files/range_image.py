"""A scan as an image: a row for each ring, a column for each firing."""

from __future__ import annotations

from typing import Final

import numpy as np
from numpy.typing import NDArray

from cadet._util.arrays import array_from_npy, check_array, npy_from_array
from cadet.errors import FileFormatError, KittiFormatError
from cadet.sensors.firing import RasterFiring
from cadet.sensors.lidar import Lidar
from cadet.sensors.sample import Scan

NO_RETURN: Final = 0.0


def range_image(scan: Scan, lidar: Lidar) -> NDArray[np.float32]:
    """Return the range of every beam.

    Args:
        scan: what the LIDAR has taken.
        lidar: the LIDAR.

    Returns:
        (rings, columns) float32, meters from the laser: rings from the top, columns counter-clockwise from forward, as
        `Scan.ring` and `Scan.column` count them, of a raster its lines, laser by laser; 0 without a return, the nearest
        of several.
    """
    beams = lidar.beam_table()
    image = np.full((len(beams.rings), beams.num_columns), NO_RETURN, np.float32)
    # Of numbers for one pixel NumPy keeps the last.
    nearest_last = np.argsort(-scan.range_m, kind="stable")
    image[scan.ring[nearest_last], scan.column[nearest_last]] = scan.range_m[nearest_last]
    image[np.isinf(image)] = NO_RETURN
    return image.reshape(-1, beams.firing.columns) if isinstance(beams.firing, RasterFiring) else image


def bytes_from_range_image(image: NDArray[np.float32]) -> bytes:
    """Return a range image as a .npy file.

    Raises:
        ShapeError: not (R, C) float32.
    """
    check_array(image, "range_image", ("R", "C"), np.float32)
    return npy_from_array(image.astype("<f4"))


def range_image_from_bytes(data: bytes, file: str = "range_image") -> NDArray[np.float32]:
    """Read a range image: (R, C) float32, meters, 0 without a return.

    Raises:
        KittiFormatError: no .npy file, or another shape or type.
    """
    try:
        image = array_from_npy(data, file)
    except FileFormatError as error:
        raise KittiFormatError(error.reason, file) from None
    if image.ndim != 2 or image.dtype != np.dtype("<f4"):
        raise KittiFormatError(f"expected (rings, columns) float32, got {image.shape} {image.dtype}", file)
    return image.astype(np.float32)
