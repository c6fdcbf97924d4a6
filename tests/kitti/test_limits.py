"""Files that ask for gigabytes, numbers that only Python reads, and calibrations without a way back."""

from __future__ import annotations

import struct
import zlib
from dataclasses import replace
from typing import Any

import cv2
import numpy as np
import pytest

from cadet.errors import CadetError, KittiFormatError
from cadet.kitti import Calibration, images
from cadet.kitti.planes import plane_from_text
from synthetic import make_calib

START = b"\x89PNG\r\n\x1a\n"


def chunk(name: bytes, data: bytes, length: int | None = None) -> bytes:
    stated = len(data) if length is None else length
    return struct.pack(">I", stated) + name + data + struct.pack(">I", zlib.crc32(name + data))


def header(width: int, height: int) -> bytes:
    return chunk(b"IHDR", struct.pack(">IIBBBBB", width, height, 8, 2, 0, 0, 0))


END = chunk(b"IEND", b"")
BLACK = chunk(b"IDAT", zlib.compress(bytes(100)))


@pytest.mark.parametrize(
    ("data", "message"),
    [
        (START + header(20_000, 20_000) + BLACK + END, "a.png: 20000 x 20000 pixels, at most 33554432 are read"),
        (START + header(4, 4) + chunk(b"IDAT", b"", 2**32 - 1) + END, "a.png: truncated PNG image (57 bytes)"),
        (START + header(4, 4) + BLACK, "a.png: truncated PNG image ("),
        (
            START
            + header(4, 4)
            + chunk(b"fcTL", struct.pack(">III", 0, 2**31 - 1, 2**31 - 1) + bytes(14))
            + BLACK
            + END,
            "a.png: 2147483647 x 2147483647 pixels, at most 33554432 are read",
        ),
    ],
)
def test_images_that_ask_for_gigabytes_are_refused_before_they_are_decoded(
    data: bytes, message: str, monkeypatch: pytest.MonkeyPatch
) -> None:
    def decode(*_: Any) -> None:
        pytest.fail("the decoder was asked")

    monkeypatch.setattr(cv2, "imdecode", decode)
    with pytest.raises(KittiFormatError) as refused:
        images.decode_image(data, "a.png")
    assert str(refused.value).startswith(message)


@pytest.mark.parametrize("number", ["1_0", "٣", "1__0"])
def test_numbers_that_only_python_reads_are_refused(number: str) -> None:
    text = make_calib().to_text()
    first = text.split("P0: ")[1].split(" ")[0]
    with pytest.raises(KittiFormatError, match=r"^c\.txt:1: P0: expected a number, got "):
        Calibration.from_text(text.replace(first, number, 1), "c.txt")
    with pytest.raises(KittiFormatError, match=r"^p\.txt:4: expected a number, got "):
        plane_from_text(f"# Matrix\nWIDTH 4\nHEIGHT 1\n{number} -1 0 1.65\n", "p.txt")


def test_singular_calibrations_have_no_way_back_and_say_so() -> None:
    calib = make_calib()
    flat = replace(calib, R0_rect=np.diag([1.0, 1.0, 0.0]))
    with pytest.raises(CadetError, match=r"^calib: R0_rect times Tr_velo_to_cam is singular"):
        flat.points_velo_from_cam(np.ones((1, 3)))
    blind = replace(calib, P2=np.zeros((3, 4)))
    with pytest.raises(CadetError, match=r"^calib: the first three columns of P2 are singular"):
        blind.eye_cam  # noqa: B018


def test_the_eye_is_where_p2_maps_to_nothing() -> None:
    calib = make_calib()
    np.testing.assert_allclose(calib.P2 @ [*calib.eye_cam, 1.0], 0.0, atol=1e-9)
