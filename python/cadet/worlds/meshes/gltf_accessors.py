"""The numbers of glTF accessors: views, strides, sparse and normalized values (specification, 3.6.2)."""

from __future__ import annotations

from typing import Any, Final

import numpy as np
from numpy.typing import NDArray

from cadet.errors import FileFormatError
from cadet.worlds.meshes.gltf_container import Container
from cadet.worlds.meshes.gltf_tables import Table

_DTYPES: Final = {5120: "<i1", 5121: "<u1", 5122: "<i2", 5123: "<u2", 5125: "<u4", 5126: "<f4", 5130: "<f8"}
_PARTS: Final = {"SCALAR": 1, "VEC2": 2, "VEC3": 3, "VEC4": 4, "MAT4": 16}
# Of all accessors that are read, so that small files that point at the same bytes again and again end soon.
_MOST_VALUES: Final = 100_000_000


class Accessors:
    """Reads accessors of a file.

    Args:
        container: the file.
    """

    def __init__(self, container: Container) -> None:
        self._container = container
        self._left = _MOST_VALUES

    def floats(self, owner: Table, key: str, kinds: tuple[str, ...]) -> NDArray[np.float64]:
        """Return (n, parts) the values that `owner` names, of one of the kinds, such as "VEC3"; normalized if they are.

        Raises:
            FileFormatError: another kind, beyond the end of its bytes, or too many.
        """
        accessor, values = self._read(owner, key, kinds)
        found = values.astype(np.float64)
        if accessor.flag("normalized") and values.dtype.kind in "iu":
            found = np.maximum(found / np.iinfo(values.dtype).max, -1.0)
        return found

    def wholes(self, owner: Table, key: str, kinds: tuple[str, ...] = ("SCALAR",)) -> NDArray[np.int64]:
        """Return (n, parts) the whole numbers that `owner` names.

        Raises:
            FileFormatError: as `floats`, or numbers that are not whole.
        """
        accessor, values = self._read(owner, key, kinds)
        if values.dtype.kind != "u":
            raise accessor.bad("componentType", "unsigned whole numbers (5121, 5123, or 5125)")
        return values.astype(np.int64)

    def _read(self, owner: Table, key: str, kinds: tuple[str, ...]) -> tuple[Table, NDArray[Any]]:
        accessor = self._container.item(owner, key, "accessors")
        kind = accessor.text("type")
        if kind not in kinds:
            raise accessor.bad("type", " or ".join(kinds))
        parts = _PARTS[kind]
        count = accessor.whole("count")
        self._left -= count * parts
        if self._left < 0:
            raise FileFormatError(f"{accessor.where}: more than {_MOST_VALUES} values in all", accessor.file)
        dtype = self._dtype(accessor)
        values = self._values(accessor, count, parts, dtype) if "bufferView" in accessor else None
        if values is None:
            values = np.zeros((count, parts), dtype)
        if "sparse" in accessor:
            sparse = accessor.table("sparse")
            some = sparse.whole("count", below=count + 1)
            places_of, values_of = sparse.table("indices"), sparse.table("values")
            places = self._values(places_of, some, 1, self._dtype(places_of))[:, 0].astype(np.int64)
            if len(places) and not 0 <= places.min() <= places.max() < count:
                raise FileFormatError(f"{places_of.where}: an index beyond the {count} values", accessor.file)
            values[places] = self._values(values_of, some, parts, dtype)
        return accessor, values

    @staticmethod
    def _dtype(table: Table) -> np.dtype[Any]:
        kind = table.whole("componentType")
        if kind not in _DTYPES:
            raise table.bad("componentType", "one of " + ", ".join(map(str, _DTYPES)))
        return np.dtype(_DTYPES[kind])

    def _values(self, table: Table, count: int, parts: int, dtype: np.dtype[Any]) -> NDArray[Any]:
        """Return a copy of what a view holds from an offset on."""
        number = table.whole("bufferView", below=len(self._container.items("bufferViews")))
        size = parts * dtype.itemsize
        stride = self._container.items("bufferViews")[number].whole("byteStride", 0) or size
        data = self._container.view(number)[table.whole("byteOffset", 0) :]
        if count and (count - 1) * stride + size > len(data):
            raise FileFormatError(f"{table.where}: beyond the end of its view", table.file)
        strided = np.ndarray((count, parts), dtype, data or b"\0" * size, 0, (stride, dtype.itemsize))
        return strided.copy()
