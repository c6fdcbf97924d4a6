"""Road networks from OpenDRIVE files."""

from __future__ import annotations

import codecs
import hashlib
import re
from dataclasses import dataclass, field
from pathlib import Path
from typing import Final

from cadet._util.checks import as_path, check_text
from cadet._util.user_files import read_file
from cadet.errors import CadetError

MAX_BYTES: Final = 1 << 28
"""Maps are smaller: the largest public ones have some 50 MB."""

_MARKS: Final = (
    (codecs.BOM_UTF8, "utf-8"),
    (codecs.BOM_UTF32_LE, "utf-32"),
    (codecs.BOM_UTF32_BE, "utf-32"),
    (codecs.BOM_UTF16_LE, "utf-16"),
    (codecs.BOM_UTF16_BE, "utf-16"),
    ("<?".encode("utf-16-le"), "utf-16-le"),
    ("<?".encode("utf-16-be"), "utf-16-be"),
)
"""How texts begin whose encoding shows, marks of byte order first."""

_ENCODINGS: Final = ("utf-", "iso8859", "cp", "mac-", "koi8", "gb", "big5", "euc_", "shift_jis", "johab", "tis-620")
"""How Python's names of encodings begin that hold texts."""

_AS_UTF8: Final = ("us-ascii", "ascii", "utf-16", "utf16", "utf-32", "utf32", "ucs", "iso-10646", "unicode")
"""Declared encodings that are read as UTF-8: writers of .NET declare UTF-16 in files of UTF-8, and what reads as a
declaration in single bytes is not in UTF-16."""

_PACKED: Final = {
    b"\x1f\x8b": "gzip: unpack it with gunzip",
    b"PK\x03\x04": "a ZIP file: unpack it with unzip",
    b"version https://git-lfs": "a pointer of Git LFS: get the map itself with git lfs pull",
}
_DECLARED: Final = re.compile(rb"<\?xml[^>]{0,200}?encoding\s*=\s*[\"']([A-Za-z0-9._-]{1,40})[\"']")


@dataclass(frozen=True)
class RoadMap:
    """An OpenDRIVE map, held in memory so that a run reads its file once.

    Attributes:
        name: the file's name, for metadata and messages.
        xodr: the whole text.

    Raises:
        CadetError: a name or a map that is not text.
    """

    name: str
    xodr: str = field(repr=False)

    def __post_init__(self) -> None:
        check_text("RoadMap", "name", self.name)
        check_text("RoadMap", "xodr", self.xodr)

    @classmethod
    def read(cls, path: str | Path) -> RoadMap:
        """Read an OpenDRIVE file, in the encoding that its XML declaration or byte order mark says; UTF-8 without one.

        Raises:
            MissingFileError: there is no such file.
            CadetError: it is no file, larger than `MAX_BYTES`, packed, or no text. What the text says is checked when a
                scene is built from it.
        """
        path = as_path("map", path)
        missing = f"unknown map {str(path)!r}: expected an OpenDRIVE file (.xodr)"
        return cls(path.name, _text(read_file(path, name=path.name, missing=missing, max_bytes=MAX_BYTES), path.name))

    @property
    def sha256(self) -> str:
        """The hash of the text."""
        return hashlib.sha256(self.xodr.encode()).hexdigest()


def as_road_map(road_map: RoadMap | str | Path) -> RoadMap:
    """Read a file; return what has been read already as it is.

    Raises:
        MissingFileError: there is no such file.
        CadetError: neither a map nor a path, or no text.
    """
    return road_map if isinstance(road_map, RoadMap) else RoadMap.read(road_map)


def _text(data: bytes, name: str) -> str:
    """Return the text of a file's bytes.

    Raises:
        CadetError: bytes that are none in their encoding, or an encoding that is not known.
    """
    if not data:
        raise CadetError(f"{name}: empty, expected OpenDRIVE")
    for mark, kind in _PACKED.items():
        if data.startswith(mark):
            raise CadetError(f"{name}: {kind}")
    encoding = next((found for mark, found in _MARKS if data.startswith(mark)), None) or _declared(data)
    remedy = f"convert it with iconv -f {'ISO-8859-1' if encoding == 'utf-8' else encoding} -t UTF-8, and declare that"
    try:
        is_text = codecs.lookup(encoding).name.startswith(_ENCODINGS)
    except LookupError:
        is_text = False
    if not is_text:
        raise CadetError(f"{name}: declared to be {encoding!r}, which is not a known encoding: {remedy}")
    try:
        return data.decode(encoding).removeprefix("\ufeff")
    except UnicodeDecodeError as error:
        line = data.count(b"\n", 0, error.start) + 1
        raise CadetError(f"{name}:{line}: not {encoding.upper()}: {remedy}") from None


def _declared(data: bytes) -> str:
    """Return the encoding that an XML declaration of single bytes names, UTF-8 without one."""
    declared = _DECLARED.search(data[:4096])
    encoding = "utf-8" if declared is None else declared[1].decode().lower()
    return "utf-8" if encoding.startswith(_AS_UTF8) else encoding
