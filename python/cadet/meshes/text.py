"""The text of OBJ files and their libraries, in the encodings that programs write."""

from __future__ import annotations

import codecs


def text_from_bytes(data: bytes) -> str:
    """Decode UTF-8, UTF-16 with its mark, or Latin-1; a mark at the beginning is left out."""
    if data.startswith((codecs.BOM_UTF16_LE, codecs.BOM_UTF16_BE)):
        return data.decode("utf-16", errors="replace")
    try:
        return data.decode("utf-8-sig")
    except UnicodeDecodeError:
        return data.decode("latin-1")


def lines_of(text: str) -> list[str]:
    """Split a text at the ends of lines of any system, and nowhere else."""
    return text.replace("\r\n", "\n").replace("\r", "\n").split("\n")
