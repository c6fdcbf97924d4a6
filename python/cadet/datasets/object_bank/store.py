"""A bank on disk: a folder of pictures and points, and a list that says what they are.

bank.json            format, version, and of each object type, box, the crop's corners, source, and number of points
objects/000000.png   the crop: RGB and opacity
objects/000000.bin   its points: float32 x, y, z, intensity
"""

from __future__ import annotations

import json
import math
import zlib
from collections import Counter
from collections.abc import Iterable
from functools import lru_cache
from pathlib import Path
from typing import Any, Final

import numpy as np
from numpy.typing import NDArray

from cadet._util.checks import as_path
from cadet._util.image_file import decode_file
from cadet._util.plain_text import json_from_text
from cadet._util.sink import LocalSink
from cadet._util.summary import counts, summary
from cadet._util.user_files import read_file
from cadet.datasets.object_bank.object import BankObject
from cadet.errors import CadetError, MissingFileError
from cadet.formats.kitti.files.images import encode_png
from cadet.formats.kitti.files.velodyne import bytes_from_points, points_from_bytes

_LIST: Final = "bank.json"
_FORMAT: Final = "cadet-object-bank"
_VERSION: Final = 1
_KEPT: Final = 512
"""Objects that are kept in memory: about 20 kB each."""


def write_bank(root: str | Path, objects: Iterable[BankObject]) -> Counter[str]:
    """Write a bank; its list comes last, so that a folder with one is whole.

    Args:
        root: a new folder, or one without a bank.
        objects: are read one by one.

    Returns:
        How many objects of each type there are.

    Raises:
        CadetError: a bank is there already, or there are no objects.
    """
    root = as_path("root", root)
    if (root / _LIST).exists():
        raise CadetError(f"{root} holds a bank already: name a new folder")
    sink = LocalSink(root)
    entries: list[dict[str, Any]] = []
    for item in objects:
        name = _name(len(entries))
        sink.put(f"{name}.png", encode_png(item.crop))
        sink.put(f"{name}.bin", bytes_from_points(item.points_scan))
        entries.append(
            {
                "type": item.type,
                "source": item.source,
                "box_scan": item.box_scan.round(6).tolist(),
                "corners_scan": item.corners_scan.round(6).tolist(),
                "num_points": len(item.points_scan),
            }
        )
    if not entries:
        raise CadetError(f"{root}: no object to put into a bank: none is seen whole with enough points")
    table = {"format": _FORMAT, "version": _VERSION, "objects": entries}
    sink.put(_LIST, (json.dumps(table, indent=1) + "\n").encode())
    sink.remove_partial()
    return Counter(entry["type"] for entry in entries)


class ObjectBank:
    """The objects of a bank, read when asked for.

    Args:
        root: the folder.

    Attributes:
        types: of the objects, by number.
        crc32: of the list: another bank has another one.

    Raises:
        MissingFileError: no bank there.
        CadetError: a damaged list.
    """

    def __init__(self, root: str | Path) -> None:
        self.root = as_path("root", root)
        path = self.root / _LIST
        if not path.is_file():
            raise MissingFileError(f"{path}: no such file: expected a bank, as `cadet bank DATA -o BANK` makes one")
        data = path.read_bytes()
        table = json_from_text(data, str(path))
        if not isinstance(table, dict) or table.get("format") != _FORMAT or table.get("version") != _VERSION:
            raise CadetError(f"{path}: not the list of an object bank of version {_VERSION}")
        entries = table.get("objects")
        if not isinstance(entries, list) or not entries:
            raise CadetError(f"{path}: objects: expected a list of at least one")
        self._entries = [_checked(entry, f"{path}: objects[{number}]") for number, entry in enumerate(entries)]
        self.types: tuple[str, ...] = tuple(entry["type"] for entry in self._entries)
        self.crc32 = zlib.crc32(data)
        self._read = lru_cache(maxsize=_KEPT)(self._read_object)

    def __len__(self) -> int:
        return len(self._entries)

    def __getitem__(self, number: int) -> BankObject:
        """Read an object.

        Raises:
            IndexError: no such number.
            MissingFileError: one of its files is not there.
            CadetError: a damaged file.
        """
        if not 0 <= number < len(self._entries):
            raise IndexError(number)
        return self._read(number)

    def __reduce__(self) -> tuple[type[ObjectBank], tuple[Path]]:
        """Tell what travels to another process: where the bank is."""
        return ObjectBank, (self.root,)

    def __repr__(self) -> str:
        return summary(self, root=str(self.root), objects=counts(self.types))

    def _read_object(self, number: int) -> BankObject:
        entry = self._entries[number]
        png, binary = (self.root / f"{_name(number)}.{end}" for end in ("png", "bin"))
        points = points_from_bytes(read_file(binary), str(binary))
        if len(points) != entry["num_points"]:
            raise CadetError(f"{binary}: {len(points)} points, expected {entry['num_points']}")
        crop = _decoded(read_file(png), png)
        try:
            return BankObject(
                entry["type"],
                np.array(entry["box_scan"], np.float64),
                points,
                crop,
                np.array(entry["corners_scan"], np.float64),
                entry["source"],
            )
        except CadetError as error:
            raise CadetError(f"{self.root / _LIST}: objects[{number}]: {error}") from None


def _name(number: int) -> str:
    return f"objects/{number:06d}"


def _decoded(data: bytes, path: Path) -> NDArray[np.uint8]:
    crop = decode_file(data, str(path)).pixels
    if crop.dtype != np.uint8 or crop.shape[2] != 4:
        raise CadetError(f"{path}: expected a PNG image of four channels of 8 bit")
    return crop


def _checked(entry: Any, where: str) -> dict[str, Any]:
    """Return an entry whose values are of the right kind; the objects themselves check the rest."""
    if not isinstance(entry, dict):
        raise CadetError(f"{where}: expected a table")
    for name in ("type", "source"):
        if not isinstance(entry.get(name), str):
            raise CadetError(f"{where}: {name}: expected a string")
    corners, count = entry.get("corners_scan"), entry.get("num_points")
    rows = [entry.get("box_scan"), *(corners if isinstance(corners, list) and len(corners) == 4 else [None])]
    for row, length in zip(rows, (7, 3, 3, 3, 3), strict=False):
        is_row = isinstance(row, list) and len(row) == length
        if not is_row or not all(isinstance(v, int | float) and math.isfinite(v) for v in row):
            raise CadetError(f"{where}: expected box_scan of 7 numbers and corners_scan of 4 rows of 3")
    if not isinstance(count, int) or isinstance(count, bool):
        raise CadetError(f"{where}: num_points: expected a whole number")
    return entry
