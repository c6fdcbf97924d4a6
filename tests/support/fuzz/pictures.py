"""Image files as targets: damage that checksums do not catch, in every form that is read and everywhere that reads."""

from __future__ import annotations

import json
import random
import tempfile
import zlib
from functools import cache
from pathlib import Path

import cv2
import numpy as np

import image_bytes as made
from cadet.datasets.object_bank import BankObject, ObjectBank, write_bank
from cadet.errors import CadetError
from cadet.formats.bdd100k import convert_bdd100k
from cadet.formats.kitti.files import images
from fuzz.mutations import damage_bytes
from fuzz.target import Input, Target


def picture_targets() -> tuple[Target, ...]:
    """Return a target for each format and each place beside KITTI's folders that reads pictures."""
    return (
        Target("PNG pictures", _damaged_png, _read),
        Target("JPEG pictures", lambda rng: damage_bytes(rng, rng.choice(_jpegs())), _read),
        Target("WebP pictures", lambda rng: damage_bytes(rng, rng.choice(_webps())), _read),
        Target("pictures of banks", _damaged_png, _read_bank),
        Target("pictures of BDD100K", lambda rng: damage_bytes(rng, rng.choice(_jpegs())), _read_bdd),
    )


@cache
def _colors() -> np.ndarray[tuple[int, ...], np.dtype[np.uint8]]:
    return np.random.default_rng(0).integers(0, 256, (24, 32, 4)).astype(np.uint8)


@cache
def _pngs() -> tuple[bytes, ...]:
    colors = _colors()
    palette = made.chunk(b"PLTE", colors[:8].tobytes()[:768])
    return (
        made.png(colors[..., :3], made.RGB),
        made.png(colors, made.RGBA),
        made.png(colors[..., :1].astype(np.uint16) * 257, made.GRAY),
        made.png(colors[..., :1], made.PALETTE, before=[palette, made.chunk(b"tRNS", bytes(9))]),
        made.animation(colors[..., :3], colors[..., 1:]),
        made.PNG_START + made.header(32, 24, 1, made.GRAY) + made.chunk(b"IDAT", made.packed(colors[:, :1, :])),
    )


def _encoded(suffix: str, *options: int) -> bytes:
    done, data = cv2.imencode(suffix, _colors()[..., :3], options)
    assert done
    return data.tobytes()


@cache
def _jpegs() -> tuple[bytes, ...]:
    progressive, restart = (cv2.IMWRITE_JPEG_PROGRESSIVE, 1), (cv2.IMWRITE_JPEG_RST_INTERVAL, 1)
    return (*(_encoded(".jpg", *options) for options in ((), progressive, restart)), made.CMYK_JPEG, made.RGB_JPEG)


@cache
def _webps() -> tuple[bytes, ...]:
    return (*(_encoded(".webp", cv2.IMWRITE_WEBP_QUALITY, quality) for quality in (60, 101)), made.ANIMATED_WEBP)


def _damaged_png(rng: random.Random) -> bytes:
    """Damage one chunk or their order; the checksums are right, and often what is compressed is, too."""
    chunks = list(made.png_chunks(rng.choice(_pngs())))
    at = rng.randrange(len(chunks))
    name, content = chunks[at]
    match rng.randrange(6):
        case 0:
            del chunks[at]
        case 1:
            chunks.insert(rng.randrange(len(chunks)), chunks[at])
        case 2:
            chunks[at] = (rng.choice(chunks)[0], content)
        case 3 | 4 if name in (b"IDAT", b"fdAT"):
            number, packed = (content[:4], content[4:]) if name == b"fdAT" else (b"", content)
            chunks[at] = (name, number + zlib.compress(damage_bytes(rng, zlib.decompress(packed))))
        case _:
            chunks[at] = (name, damage_bytes(rng, content))
    return made.PNG_START + b"".join(made.chunk(*one) for one in chunks)


def _read(value: Input) -> object:
    assert isinstance(value, bytes)
    try:
        return images.decode_image(value, "a.png")
    except CadetError:
        return images.decode_map(value, "a.png", np.uint16)


def _read_bank(value: Input) -> object:
    assert isinstance(value, bytes)
    box, points = np.array([0.0, 1.0, 9.0, 4.0, 2.0, 1.5, 0.0]), np.full((30, 4), 9.0, np.float32)
    item = BankObject("Car", box, points, _colors(), np.full((4, 3), 9.0), "set/000000")
    with tempfile.TemporaryDirectory() as folder:
        write_bank(folder, [item])
        (Path(folder) / "objects" / "000000.png").write_bytes(value)
        return ObjectBank(folder)[0]


def _read_bdd(value: Input) -> object:
    assert isinstance(value, bytes)
    with tempfile.TemporaryDirectory() as folder:
        root = Path(folder)
        (root / "a.jpg").write_bytes(value)
        (root / "l.json").write_text(json.dumps([{"name": "a.jpg"}]))
        return convert_bdd100k(root / "l.json", root, root / "out")
