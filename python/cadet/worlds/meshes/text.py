"""The text of OBJ files and their libraries, in the encodings that programs write."""

from __future__ import annotations

import codecs
from collections.abc import Collection, Iterator


def text_from_bytes(data: bytes) -> str:
    """Decode UTF-8, UTF-16 with its mark, or Latin-1; a mark at the beginning is left out."""
    if data.startswith((codecs.BOM_UTF16_LE, codecs.BOM_UTF16_BE)):
        return data.decode("utf-16", errors="replace")
    try:
        return data.decode("utf-8-sig")
    except UnicodeDecodeError:
        return data.decode("latin-1")


def lines_of(text: str, of_numbers: Collection[str]) -> Iterator[tuple[int, str]]:
    """Yield the lines of a text, whatever system has ended them, with their numbers from 1.

    Args:
        text: the text.
        of_numbers: in lower case, the first words of lines that go on after a backslash and end before a comment; names
            and paths may hold both.
    """
    begun, first = "", 0
    for number, line in enumerate(text.replace("\r\n", "\n").replace("\r", "\n").split("\n"), 1):
        if begun:
            line = f"{begun} {line}"
        start = first if begun else number
        begun = ""
        if "\\" in line or "#" in line:
            words = line.split(None, 1)
            if not words or words[0].startswith("#"):
                continue
            if words[0].lower() in of_numbers:
                line = line.split("#")[0].rstrip()
                if line.endswith("\\"):
                    begun, first = line.rstrip("\\"), start
                    continue
        yield start, line
    if begun:
        yield first, begun
