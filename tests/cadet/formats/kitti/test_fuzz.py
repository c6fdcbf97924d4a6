"""Whatever bytes a file holds, reading gives a value or a CadetError that names the file."""

from __future__ import annotations

import math
import struct
from collections.abc import Callable

import pytest
from hypothesis import given
from hypothesis import strategies as st

from cadet.errors import KittiFormatError
from cadet.formats.kitti import Calibration, ImageSet, Label, labels_from_text
from cadet.formats.kitti.files.dialects import collected
from cadet.formats.kitti.files.planes import plane_from_text
from cadet.formats.kitti.files.velodyne import points_from_bytes
from synthetic import make_calib, make_frame

LABELS = "".join(f"{label.to_line()}\n" for label in make_frame().labels)
PLANE = "# Matrix\nWIDTH 4\nHEIGHT 1\n0.0 -1.0 0.0 1.65 \n"
PARSERS: list[tuple[Callable[[str, str], object], str]] = [
    (labels_from_text, LABELS),
    (Label.from_line, LABELS.split("\n")[0]),
    (Calibration.from_text, make_calib().to_text()),
    (plane_from_text, PLANE),
    (ImageSet.from_text, "000001\n000002\n"),
]


def refusal(parse: Callable[[str, str], object], text: str) -> str | None:
    """Parse and return the message of the refusal, None if the text was read."""
    try:
        with collected():
            parse(text, "file.txt")
    except KittiFormatError as error:
        return str(error)
    return None


@pytest.mark.parametrize(("parse", "valid"), PARSERS)
@given(data=st.data())
def test_damaged_text_is_read_or_refused_with_the_files_name(
    parse: Callable[[str, str], object], valid: str, data: st.DataObject
) -> None:
    at = data.draw(st.integers(0, len(valid)))
    length = data.draw(st.integers(0, 40))
    noise = data.draw(
        st.text(st.characters(codec="latin-1"), max_size=20) | st.sampled_from(["nan", "1e999", "-", " ", "\n"])
    )
    message = refusal(parse, valid[:at] + noise + valid[at + length :])
    assert message is None or message.startswith("file.txt:")


@given(st.text(max_size=200))
def test_any_text_is_read_or_refused(text: str) -> None:
    for parse, valid in PARSERS:
        message = refusal(parse, text)
        assert message is None or message.startswith("file.txt:")
        assert refusal(parse, valid) is None


@given(st.binary(max_size=100))
def test_any_bytes_are_a_scan_or_refused(data: bytes) -> None:
    try:
        num_points = len(points_from_bytes(data, "file.bin"))
    except KittiFormatError:
        values = [struct.unpack("<f", data[at : at + 4])[0] for at in range(0, len(data) // 4 * 4, 4)]
        assert len(data) % 16 != 0 or not all(math.isfinite(value) for value in values)
    else:
        assert num_points * 16 == len(data)
