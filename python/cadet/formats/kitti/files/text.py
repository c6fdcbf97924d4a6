"""The text of KITTI's files: labels, results, calibrations, planes and lists, as editors and programs save it.

The core reads labels and results for the evaluation by the same rules (`evaluate/text.rs`).
"""

from __future__ import annotations

from codecs import BOM_UTF8, BOM_UTF16_BE, BOM_UTF16_LE
from typing import Final

from cadet._util.checks import check_text
from cadet.errors import KittiFormatError
from cadet.formats.kitti.files.dialects import accept

_MARK: Final = "\ufeff"


def text_from_bytes(data: bytes, file: str, encoding: str = "ascii") -> str:
    r"""Decode a file: without a byte order mark, each line ended by \n.

    Args:
        data: the file's bytes.
        file: its name for messages.
        encoding: "ascii", or "utf-8" for text that may hold other letters.

    Raises:
        KittiFormatError: UTF-16, or a byte that the encoding does not have, named with its line.
    """
    if data.startswith((BOM_UTF16_LE, BOM_UTF16_BE)) or b"\0" in data:
        raise KittiFormatError("UTF-16, or no text: save it as UTF-8, as iconv -f UTF-16 -t UTF-8 does", file, 1)
    if data.startswith(BOM_UTF8):
        data = data.removeprefix(BOM_UTF8)
        accept("byte-order-mark", "the byte order mark before the text is passed over: save it as plain ASCII", file, 1)
    try:
        text = data.decode(encoding)
    except UnicodeDecodeError as error:
        line = data.count(b"\n", 0, error.start) + 1
        reason = f"byte 0x{data[error.start]:02x} is not {encoding.upper()}"
        raise KittiFormatError(f"{reason}: write plain numbers, and names in ASCII letters", file, line) from None
    return _with_newlines(text)


def content_lines(text: str, name: str = "text") -> list[tuple[int, str]]:
    """Return the lines that are not blank, without blanks around them, each with its number from 1.

    Raises:
        CadetError: `text` is no text.
    """
    check_text("", name, text)
    numbered = enumerate(_with_newlines(text.removeprefix(_MARK)).split("\n"), start=1)
    return [(number, line.strip()) for number, line in numbered if line.strip()]


def _with_newlines(text: str) -> str:
    # A text without a newline may be an old Macintosh's.
    return text.replace("\r\n", "\n") if "\n" in text else text.replace("\r", "\n")
