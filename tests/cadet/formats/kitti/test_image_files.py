"""Images as others write them: read where the meaning is clear, with a word of it, or refused with what helps."""

from __future__ import annotations

import struct
import time
import zlib
from typing import Any

import cv2
import numpy as np
import pytest
from numpy.typing import NDArray

import image_bytes as made
from cadet._util.image_file import decode_file
from cadet.errors import FileFormatError, KittiFormatError
from cadet.formats.kitti.files import images
from cadet.formats.kitti.files.dialects import collected

_RNG = np.random.default_rng(3)
COLORS = _RNG.integers(0, 256, (6, 8, 3)).astype(np.uint8)
OTHERS = _RNG.integers(0, 256, (6, 8, 3)).astype(np.uint8)
LEVELS = _RNG.integers(0, 256, (6, 8, 1)).astype(np.uint8)
DEEP = _RNG.integers(0, 65536, (6, 8, 3)).astype(np.uint16)
OPAQUE = np.full((6, 8, 1), 255, np.uint8)
TABLE = _RNG.integers(0, 256, (256, 3)).astype(np.uint8)
PLTE = made.chunk(b"PLTE", TABLE.tobytes())
# Smooth, as JPEG likes it.
SMOOTH = np.dstack([np.add.outer(np.arange(48), np.arange(64)), np.full((48, 64), 90), np.full((48, 64), 30)])
SMOOTH = (SMOOTH + 60).astype(np.uint8)
SOLID = np.full((8, 8, 3), made.COLOR_OF_PILLOW, np.uint8)
# Fifty megabytes of text in fifty kilobytes.
BOMB = zlib.compress(bytes(50_000_000))


def encoded(image: NDArray[np.uint8], suffix: str, *options: int) -> bytes:
    done, data = cv2.imencode(suffix, image[..., ::-1] if image.ndim == 3 else image, options)
    assert done
    return data.tobytes()


def bits(levels: NDArray[np.uint8], depth: int) -> bytes:
    """Return a gray PNG of less than 8 bit; levels are (H, W)."""
    rows = np.unpackbits(levels[..., None], axis=2)[..., 8 - depth :].reshape(len(levels), -1)
    packed = zlib.compress(b"".join(b"\0" + np.packbits(row).tobytes() for row in rows))
    first = made.header(levels.shape[1], levels.shape[0], depth, made.GRAY)
    return made.PNG_START + first + made.chunk(b"IDAT", packed) + made.chunk(b"IEND", b"")


def turned(jpeg: bytes) -> bytes:
    """Return a JPEG whose EXIF data ask for a turn by 90 degrees."""
    entry = struct.pack("<HHHIHHHI", 1, 0x112, 3, 1, 6, 0, 0, 0)[:18]
    exif = b"Exif\0\0" + b"II*\0" + struct.pack("<I", 8) + entry
    return jpeg[:2] + b"\xff\xe1" + struct.pack(">H", len(exif) + 2) + exif + jpeg[2:]


CONTROL = made.chunk(b"acTL", struct.pack(">II", 1, 0))
FRAME = made.chunk(b"fdAT", struct.pack(">I", 1) + made.packed(OTHERS))
JPEG = encoded(SMOOTH, ".jpg", cv2.IMWRITE_JPEG_QUALITY, 98)
PROGRESSIVE = encoded(SMOOTH, ".jpg", cv2.IMWRITE_JPEG_QUALITY, 98, cv2.IMWRITE_JPEG_PROGRESSIVE, 1)
RESTARTS = encoded(SMOOTH, ".jpg", cv2.IMWRITE_JPEG_QUALITY, 98, cv2.IMWRITE_JPEG_RST_INTERVAL, 2)
WEBP = encoded(SMOOTH, ".webp", cv2.IMWRITE_WEBP_QUALITY, 101)

READ: dict[str, tuple[bytes, str, NDArray[np.uint8], list[str]]] = {
    "RGB": (made.png(COLORS, made.RGB), "a.png", COLORS, []),
    "RGB with full opacity": (made.png(np.dstack([COLORS, OPAQUE]), made.RGBA), "a.png", COLORS, ["image-opacity"]),
    "RGB and a transparent color that no pixel has": (
        made.png(np.maximum(COLORS, 1), made.RGB, before=[made.chunk(b"tRNS", bytes(6))]),
        "a.png",
        np.maximum(COLORS, 1),
        ["image-opacity"],
    ),
    "gray": (made.png(LEVELS, made.GRAY), "a.png", LEVELS.repeat(3, axis=2), ["image-gray"]),
    "gray with full opacity": (
        made.png(np.dstack([LEVELS, OPAQUE]), made.GRAY_ALPHA),
        "a.png",
        LEVELS.repeat(3, axis=2),
        ["image-opacity", "image-gray"],
    ),
    "black and white of 1 bit": (
        bits((LEVELS[..., 0] >> 7).astype(np.uint8), 1),
        "a.png",
        ((LEVELS >> 7) * 255).repeat(3, axis=2).astype(np.uint8),
        ["image-gray"],
    ),
    "a palette": (made.png(LEVELS, made.PALETTE, before=[PLTE]), "a.png", TABLE[LEVELS[..., 0]], ["image-palette"]),
    "an animation": (made.animation(COLORS, OTHERS), "a.png", COLORS, ["image-animation"]),
    "an animation of which the image is no frame": (
        made.png(COLORS, made.RGB, before=[CONTROL], after=made.frame_control(0, 8, 6) + FRAME),
        "a.png",
        COLORS,
        ["image-animation"],
    ),
    "an animation whose second frame is damaged": (
        made.animation(COLORS, OTHERS).replace(made.packed(OTHERS), made.packed(OTHERS)[::-1]),
        "a.png",
        COLORS,
        ["image-animation"],
    ),
    **{
        f"interlaced, {height} x {width}": (made.interlaced(part), "a.png", part, [])
        for height, width in ((6, 8), (1, 1), (2, 3), (4, 1))
        for part in [COLORS[:height, :width]]
    },
    "an animated WebP": (made.ANIMATED_WEBP, "a.webp", SOLID, ["image-animation"]),
    "texts that are bombs, and a chunk with a wrong checksum": (
        made.png(
            COLORS,
            made.RGB,
            before=[
                made.chunk(b"zTXt", b"a\0\0" + BOMB),
                made.chunk(b"iCCP", b"a\0\0" + BOMB),
                made.chunk(b"gAMA", bytes(4))[:-1] + b"?",
            ],
        ),
        "a.png",
        COLORS,
        [],
    ),
    "bytes behind the end": (made.png(COLORS, made.RGB) + b"more", "a.png", COLORS, []),
    "a stream whose last checksum is cut off": (
        made.PNG_START + made.header(8, 6) + made.chunk(b"IDAT", made.packed(COLORS)[:-4]) + made.chunk(b"IEND", b""),
        "a.png",
        COLORS,
        [],
    ),
    "WebP with chunks of EXIF and others": (
        b"RIFF" + struct.pack("<I", len(WEBP) - 8 + 20) + WEBP[8:] + b"EXIF" + struct.pack("<I", 12) + bytes(12),
        "a.webp",
        SMOOTH,
        [],
    ),
    "lossless WebP": (WEBP, "a.webp", SMOOTH, []),
    "JPEG": (JPEG, "a.jpg", SMOOTH, []),
    "JPEG that EXIF turns": (turned(JPEG), "a.JPG", SMOOTH, []),
    "progressive JPEG": (PROGRESSIVE, "a.jpeg", SMOOTH, []),
    "JPEG with restarts": (RESTARTS, "a.jpg", SMOOTH, []),
    "two JPEGs in a file, as phones write them": (JPEG + RESTARTS, "a.jpg", SMOOTH, []),
    "JPEG with bytes that mean nothing before its end": (JPEG[:-2] + bytes(248) + JPEG[-2:], "a.jpg", SMOOTH, []),
    "JPEG of RGB": (made.RGB_JPEG, "a.jpg", SOLID, []),
    "JPEG of CMYK": (made.CMYK_JPEG, "a.jpg", SOLID, []),
    "gray JPEG": (encoded(SMOOTH[..., 0], ".jpg"), "a.jpg", SMOOTH[..., :1].repeat(3, axis=2), ["image-gray"]),
    "JPEG called PNG": (JPEG, "image_2/000000.png", SMOOTH, ["image-format"]),
    "PNG called JPEG": (made.png(COLORS, made.RGB), "000000.jpg", COLORS, ["image-format"]),
}


@pytest.mark.parametrize("name", READ)
def test_images_of_others_are_read(name: str) -> None:
    data, file, expected, kinds = READ[name]
    with collected() as dialects:
        image = images.decode_image(data, file)
    assert image.dtype == np.uint8 and image.flags.c_contiguous
    assert image.shape == expected.shape
    difference = np.abs(image.astype(int) - expected)
    assert difference.max() <= (8 if "JPEG" in name and "PNG called" not in name else 0)
    assert [found.kind for found in dialects] == kinds
    assert all(found.file == file for found in dialects)


REFUSED: dict[str, tuple[bytes, str]] = {
    "nothing": (b"", "the file is empty; copy or save it again"),
    "another format": (b"GIF89a" + bytes(30), "no PNG, JPEG or WebP image (36 bytes); save it as PNG"),
    "a pointer of Git LFS": (
        b"version https://git-lfs.github.com/spec/v1\noid sha256:00\nsize 3\n",
        "a pointer of Git LFS in place of the image; run `git lfs pull`",
    ),
    "transparent pixels": (
        made.png(np.dstack([COLORS, OPAQUE - np.eye(6, 8, dtype=np.uint8)[..., None]]), made.RGBA),
        "some pixels are transparent: save it as RGB without opacity",
    ),
    "RGB of 16 bit": (made.png(DEEP, made.RGB), "16 bit a channel, expected 8: save it as RGB of 8 bit"),
    "gray of 16 bit": (made.png(DEEP[..., :1], made.GRAY), "16 bit a channel, expected 8: save it as RGB of 8 bit"),
    "too many pixels": (
        made.PNG_START + made.header(20_000, 20_000) + made.chunk(b"IDAT", b"") + made.chunk(b"IEND", b""),
        "20000 x 20000 pixels, at most 67108864 are read; scale it down",
    ),
    "too many pixels of JPEG": (
        JPEG[: (at := JPEG.index(b"\xff\xc0")) + 5] + b"\xff\xff\xff\xff" + JPEG[at + 9 :],
        "65535 x 65535 pixels, at most 67108864 are read; scale it down",
    ),
    "too many pixels of WebP": (
        b"RIFF" + struct.pack("<I", 18) + b"WEBPVP8L" + struct.pack("<IBI", 5, 0x2F, 0x3FFE << 14 | 0x3FFE) + b"\0",
        "16383 x 16383 pixels, at most 67108864 are read; scale it down",
    ),
    "more pixels than a WebP may have": (
        b"RIFF" + struct.pack("<I", 22) + b"WEBPVP8X" + struct.pack("<I", 10) + bytes(4) + b"\xff" * 6,
        "too many pixels, at most 67108864 are read; scale it down",
    ),
    "a chunk that is cut": (
        made.PNG_START + made.header(4, 4) + made.chunk(b"IDAT", b"", 2**31 - 1) + made.chunk(b"IEND", b""),
        "damaged PNG image: ",
    ),
    "a palette of less than whole colors": (
        made.png(LEVELS, made.PALETTE, before=[made.chunk(b"PLTE", bytes(4)), made.chunk(b"tRNS", bytes(2))]),
        "damaged PNG image: ",
    ),
    "no end": (made.png(COLORS, made.RGB)[:-12], "truncated PNG image ("),
    "cut JPEG": (JPEG[:-60], "truncated JPEG image ("),
    "cut progressive JPEG": (PROGRESSIVE[: len(PROGRESSIVE) // 2], "truncated JPEG image ("),
    "cut WebP": (WEBP[:-9], "damaged WebP image: "),
    "too few pixels": (
        made.PNG_START + made.header(8, 7) + made.chunk(b"IDAT", made.packed(COLORS)) + made.chunk(b"IEND", b""),
        "damaged PNG image: ",
    ),
    "an animation whose first frame is a part": (
        made.png(COLORS, made.RGB, before=(made.chunk(b"acTL", struct.pack(">II", 1, 0)), made.frame_control(0, 4, 3))),
        "damaged PNG image: ",
    ),
    "an animation of vast frames": (
        made.png(COLORS, made.RGB, before=[made.frame_control(0, 2**31 - 1, 2**31 - 1)]),
        "damaged PNG image: ",
    ),
}


@pytest.mark.parametrize("name", REFUSED)
def test_what_has_no_clear_meaning_is_refused_at_once_with_what_helps(name: str) -> None:
    data, message = REFUSED[name]
    start = time.process_time()
    with pytest.raises(KittiFormatError) as refused:
        images.decode_image(data, "a.png")
    assert time.process_time() - start < 1.0
    assert str(refused.value).startswith(f"a.png: {message}")
    assert "\n" not in str(refused.value)


@pytest.mark.parametrize("filter_kind", [5, 0x41, 255])
def test_the_animation_that_ended_opencv_is_refused(filter_kind: int, capfd: pytest.CaptureFixture[str]) -> None:
    rows = zlib.compress(b"".join(bytes([filter_kind]) + row.tobytes() for row in COLORS))
    first = made.header(8, 6) + made.chunk(b"acTL", struct.pack(">II", 2, 0)) + made.frame_control(0, 8, 6)
    data = made.PNG_START + first + made.chunk(b"IDAT", rows) + made.chunk(b"IEND", b"")
    with pytest.raises(KittiFormatError, match=r"^a\.png: damaged PNG image: "):
        images.decode_image(data, "a.png")
    assert capfd.readouterr() == ("", "")


@pytest.mark.parametrize(
    ("data", "dtype", "expected", "kinds"),
    [
        (made.png(LEVELS, made.GRAY), np.uint8, LEVELS, []),
        (made.png(DEEP[..., :1], made.GRAY), np.uint16, DEEP[..., :1], []),
        (made.png(LEVELS.repeat(3, axis=2), made.RGB), np.uint8, LEVELS, ["map-channels"]),
        (made.png(DEEP[..., :1].repeat(3, axis=2), made.RGB), np.uint16, DEEP[..., :1], ["map-channels"]),
        (made.png(COLORS, made.RGB), np.uint8, None, "expected one channel of uint8, got (6, 8, 3) uint8"),
        (made.png(LEVELS, made.GRAY), np.uint16, None, "expected one channel of uint16, got (6, 8) uint8"),
        (made.png(LEVELS, made.PALETTE, before=[PLTE]), np.uint8, None, "expected one channel of uint8, got (6, 8, 3)"),
    ],
)
def test_maps_are_read_exactly_or_refused(data: bytes, dtype: Any, expected: Any, kinds: Any) -> None:
    if expected is None:
        with pytest.raises(KittiFormatError) as refused:
            images.decode_map(data, "m.png", dtype)
        assert str(refused.value).startswith(f"m.png: {kinds}")
        return
    with collected() as dialects:
        found = images.decode_map(data, "m.png", dtype)
    np.testing.assert_array_equal(found, expected[..., 0], strict=True)
    assert [one.kind for one in dialects] == kinds


@pytest.mark.parametrize("suffix", [".bmp", ".ppm"])
def test_simple_formats_of_textures_pass_the_same_gate(suffix: str) -> None:
    rgb = np.arange(5 * 7 * 3, dtype=np.uint8).reshape(5, 7, 3)
    data = cv2.imencode(suffix, rgb[..., ::-1])[1].tobytes()
    np.testing.assert_array_equal(decode_file(data, "a").pixels, rgb)
    sizes = struct.pack("<ii", 32_768, -32_768)
    bomb = data[:18] + sizes + data[26:] if suffix == ".bmp" else b"P6\n# a\n32768 32768\n255\n"
    with pytest.raises(FileFormatError, match=r"^a: 32768 x 32768 pixels, at most"):
        decode_file(bomb, "a")
    with pytest.raises(FileFormatError, match=r"^a: damaged (BMP|PNM) image.*save it as PNG"):
        decode_file(data[:30] if suffix == ".bmp" else data[:8] + b"\n", "a")
