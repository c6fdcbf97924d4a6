"""The lines of KITTI's `calib` files and of their dialects: which matrix each one holds.

KITTI's tracking files name `R_rect`, `Tr_velo_cam` and `Tr_imu_velo` without a colon, those of odometry `Tr`, which
rectifies too. Converters leave out what their car has not, repeat lines, and spell names in other ways.
"""

from __future__ import annotations

import re
from typing import Final

import numpy as np
from numpy.typing import NDArray

from cadet._util.checks import shown
from cadet.errors import KittiFormatError
from cadet.formats.kitti.files.dialects import accept
from cadet.formats.kitti.files.numbers import number_from_text
from cadet.formats.kitti.files.text import content_lines

SHAPES: Final = {
    "P0": (3, 4),
    "P1": (3, 4),
    "P2": (3, 4),
    "P3": (3, 4),
    "R0_rect": (3, 3),
    "Tr_velo_to_cam": (3, 4),
    "Tr_imu_to_velo": (3, 4),
}
"""The keys of a calibration file in the order of KITTI's lines, and the shapes of their matrices."""

_USED: Final = ("P2", "R0_rect", "Tr_velo_to_cam")
_NAMES_SHOWN: Final = 12
_ODOMETRY: Final = "tr"
_ALIASES: Final = {re.sub("_|to", "", key.lower()): key for key in SHAPES} | {
    "r0": "R0_rect",
    "rrect": "R0_rect",
    "trvelo2cam": "Tr_velo_to_cam",
    "trvelodynecam": "Tr_velo_to_cam",
    "trlidarcam": "Tr_velo_to_cam",
    _ODOMETRY: "Tr_velo_to_cam",
    "trimu2velo": "Tr_imu_to_velo",
    "trimuvelodyne": "Tr_imu_to_velo",
}
"""Keys without letter case, underscores and "to"."""

_REMEDIES: Final = {
    "P2": "it projects into image_2",
    "R0_rect": "if the images are rectified, add 'R0_rect: 1 0 0 0 1 0 0 0 1'",
    "Tr_velo_to_cam": "it brings the LIDAR's points into the camera's frame",
}
_LINE: Final = re.compile(r"([A-Za-z]\w{0,63})(?:\s*[:=]\s*|\s+|$)(.*)")


def key_of_line(line: str) -> str:
    """Return the key of a line as KITTI spells it, as it stands there if KITTI has no such key; "" without one."""
    match = _LINE.fullmatch(line)
    return "" if match is None else _ALIASES.get(_plain(match[1]), match[1])


def matrices_from_text(text: str, file: str) -> dict[str, NDArray[np.float64]]:
    """Read the matrices of a calibration file. Those that it lacks and that nothing here uses are zero.

    Raises:
        KittiFormatError: `P2`, `R0_rect` or `Tr_velo_to_cam` is missing, a key comes twice with different numbers, or
            a line has no key, or too few, too many or malformed numbers.
    """
    matrices: dict[str, NDArray[np.float64]] = {}
    first_lines: dict[str, int] = {}
    unknown: dict[str, int] = {}
    for number, line in content_lines(text):
        where = (file, number)
        match = _LINE.fullmatch(line)
        if match is None:
            raise KittiFormatError(f"expected a key such as P2 and numbers, got {shown(line[:40])}", *where)
        spelled, values = match[1], match[2].split()
        key = key_of_line(line)
        if key not in SHAPES:
            unknown.setdefault(spelled, number)
            continue
        if spelled != key:
            accept(f"calib-key-{key}", f"{spelled} is read as {key}", *where)
        matrix = _matrix(values, key, where)
        if key in matrices and not np.array_equal(matrix, matrices[key]):
            raise KittiFormatError(
                f"{key} comes twice, with other numbers than in line {first_lines[key]}: name lines 1 to 7 "
                f"{', '.join(SHAPES)}, in this order",
                *where,
            )
        if key in matrices:
            accept("calib-repeated-key", f"{key} comes again with the numbers of line {first_lines[key]}", *where)
        elif key not in _USED and not matrix.any():
            accept("calib-zeros", f"{key} is all zero, which means unknown: nothing here uses it", *where)
        matrices.setdefault(key, matrix)
        first_lines.setdefault(key, number)
        if _plain(spelled) == _ODOMETRY:
            _accept_odometry(text, matrices, where)
    _check_used(matrices, tuple(unknown), file)
    for spelled, number in unknown.items():
        accept("calib-other-key", f"{spelled} is not one of KITTI's keys and is ignored", file, number)
    missing = [key for key in SHAPES if key not in matrices]
    if missing:
        accept("calib-missing-keys", f"no {', '.join(missing)}: read as zeros, for unknown; nothing here uses it", file)
    return {key: matrices.get(key, np.zeros(shape)) for key, shape in SHAPES.items()}


def _plain(key: str) -> str:
    return re.sub("_|to", "", key.lower())


def _accept_odometry(text: str, matrices: dict[str, NDArray[np.float64]], where: tuple[str, int]) -> None:
    """Take the identity for `R0_rect` where `Tr` rectifies too, as in KITTI's odometry."""
    if all(key_of_line(line) != "R0_rect" for _, line in content_lines(text)):
        matrices["R0_rect"] = np.eye(3)
        accept("calib-odometry", "Tr without R0_rect, as in KITTI's odometry, rectifies: R0_rect is 1", *where)


def _check_used(matrices: dict[str, NDArray[np.float64]], unknown: tuple[str, ...], file: str) -> None:
    missing = [key for key in _USED if key not in matrices]
    if not missing:
        return
    if {"P_rect_02", "R", "T"} & set(unknown):
        raise KittiFormatError(
            f"missing key {missing[0]!r}: a calibration of KITTI's raw data? Write a file with P_rect_02 of "
            "calib_cam_to_cam.txt as P2, R_rect_00 as R0_rect, and R and T of calib_velo_to_cam.txt, row by row "
            "(3 x 4), as Tr_velo_to_cam",
            file,
        )
    found = f"; it has {', '.join((*matrices, *unknown)[:_NAMES_SHOWN])}" if matrices or unknown else ""
    remedies = "; ".join(f"missing key {key!r}: {_REMEDIES[key]}" for key in missing)
    raise KittiFormatError(f"{remedies}{found}", file)


def _matrix(values: list[str], key: str, where: tuple[str, int]) -> NDArray[np.float64]:
    rows, columns = SHAPES[key]
    try:
        numbers = np.array([number_from_text(value) for value in values])
    except ValueError as error:
        raise KittiFormatError(f"{key}: {error}", *where) from None
    if len(numbers) == rows * columns:
        return numbers.reshape(rows, columns)
    wider = _cut(numbers, rows, columns)
    if wider is None:
        raise KittiFormatError(f"{key}: expected {rows * columns} numbers, got {len(numbers)}", *where)
    accept("calib-shape", f"{key} of {len(numbers)} numbers is read as {rows} x {columns}", *where)
    return wider


def _cut(numbers: NDArray[np.float64], rows: int, columns: int) -> NDArray[np.float64] | None:
    """Return the matrix within a homogeneous one of 4 x 4, or a rotation's within 3 x 4; None if it is not one."""
    for shape in ((4, 4), (3, 4)):
        if len(numbers) == shape[0] * shape[1]:
            whole = np.eye(4)
            whole[: shape[0]] = numbers.reshape(shape)
            rest = whole - np.eye(4)
            rest[:rows, :columns] = 0.0
            return None if rest.any() else whole[:rows, :columns]
    return None
