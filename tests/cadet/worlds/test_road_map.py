"""Files of OpenDRIVE maps: in whatever encoding, and what is none."""

from __future__ import annotations

import gzip
import os
from pathlib import Path

import pytest

from cadet import CadetError, RoadMap
from cadet.errors import MissingFileError

TEXT = '<?xml version="1.0" encoding="{}"?>\n<OpenDRIVE name="Straße"/>\n'


@pytest.mark.parametrize(
    ("declared", "encoding"),
    [
        ("UTF-8", "utf-8"),
        ("UTF-8", "utf-8-sig"),
        ("UTF-16", "utf-16"),
        ("utf-16", "utf-16-be"),
        ("UTF-16", "utf-16-le"),
        ("UTF-32", "utf-32"),
        ("ISO-8859-1", "latin-1"),
        ("iso-8859-15", "iso8859-15"),
        ("windows-1252", "cp1252"),
        ("US-ASCII", "utf-8"),
        # As writers of .NET declare texts that they then save in UTF-8.
        ("utf-16", "utf-8"),
    ],
)
def test_maps_are_read_in_the_encoding_that_they_declare(tmp_path: Path, declared: str, encoding: str) -> None:
    path = tmp_path / "m.xodr"
    path.write_bytes(TEXT.format(declared).encode(encoding))
    assert RoadMap.read(path).xodr == TEXT.format(declared)


@pytest.mark.parametrize(
    ("data", "message"),
    [
        (b"", "m.xodr: empty, expected OpenDRIVE"),
        (gzip.compress(b"<OpenDRIVE/>", mtime=0), "m.xodr: gzip: unpack it with gunzip"),
        (b"PK\x03\x04", "m.xodr: a ZIP file: unpack it with unzip"),
        (
            b"version https://git-lfs.github.com/spec/v1\n",
            "m.xodr: a pointer of Git LFS: get the map itself with git lfs pull",
        ),
        (TEXT.encode("latin-1"), "m.xodr:2: not UTF-8: convert it with iconv -f ISO-8859-1 -t UTF-8, and declare that"),
        (b"\xff\xfe<", "m.xodr:1: not UTF-16: convert it with iconv -f utf-16 -t UTF-8, and declare that"),
        *(
            (
                TEXT.format(name).encode(),
                f"m.xodr: declared to be '{name}', which is not a known encoding: convert it with iconv -f {name} "
                "-t UTF-8, and declare that",
            )
            for name in ("x-mine", "rot13", "punycode", "undefined")
        ),
    ],
    ids=lambda value: None,
)
def test_what_is_no_text_is_refused_with_its_remedy(tmp_path: Path, data: bytes, message: str) -> None:
    path = tmp_path / "m.xodr"
    path.write_bytes(data.replace(b' encoding="{}"', b""))
    with pytest.raises(CadetError) as refused:
        RoadMap.read(path)
    assert str(refused.value) == message


def test_what_is_no_file_is_refused_at_once(tmp_path: Path) -> None:
    os.mkfifo(tmp_path / "fifo")
    for name, got in {"fifo": ", got a pipe", ".": ", got a folder", "none": "", "fifo/x": ""}.items():
        with pytest.raises(MissingFileError, match=rf"expected an OpenDRIVE file \(\.xodr\){got}$"):
            RoadMap.read(tmp_path / name)
    huge = tmp_path / "huge.xodr"
    with huge.open("wb") as file:
        file.truncate(1 << 29)
    with pytest.raises(CadetError, match=r"^huge\.xodr: 536870912 bytes, at most 268435456 are read$"):
        RoadMap.read(huge)
