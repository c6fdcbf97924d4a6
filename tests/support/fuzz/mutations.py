"""Damages texts and bytes. What comes out is a function of the random generator alone."""

from __future__ import annotations

import copy
import random
from typing import Any

_WORDS = (
    "nan -inf 1e308 -1e308 1e-320 -0 -1 0 3 255 65536 2147483648 18446744073709551616 1_0 0x1f .5 1e --2 true null []"
).split() + ["{}", "", " ", "٣", "7" * 5000, "0." + "3" * 3000]
_SIGNS = ("\0", "\n", "\r\n", "\t", "\x1c", "\ufeff", "é", '"', "'", "[", "]", "{", "}", "<", ">", "=", ":", "#", "\\")
_NUMBERS = (0, 1, 2, 3, 4, 5, 6, 7, 8, 255, 5121, 5126, 33071, 2**31, 2**40, 10**400, -1, 0.5, -2.5, 1e-30, 1e30, 1e308)
_MOST_LETTERS = 1 << 20


def damage_text(rng: random.Random, text: str) -> str:
    """Return the text with one to four pieces of damage."""
    for _ in range(rng.choice((1, 1, 2, 4))):
        at = rng.randrange(len(text) + 1)
        end = min(len(text), at + rng.choice((1, 5, 40, len(text))))
        match rng.randrange(7):
            case 0 | 1:
                text = _with_another_word(rng, text)
            case 2:
                text = text[:at] + text[end:]
            case 3:
                text = text[:at] + rng.choice(_SIGNS) * rng.choice((1, 1, 200)) + text[at:]
            case 4:
                text = text[:at] + text[at:end] * rng.choice((2, 3, 60)) + text[end:]
            case 5:
                text = _with_lines_moved(rng, text)
            case _:
                text = text[:at] + "".join(chr(rng.randrange(1, 300)) for _ in range(8)) + text[end:]
    return text[:_MOST_LETTERS]


def damage_bytes(rng: random.Random, data: bytes) -> bytes:
    """Return the bytes with one to four pieces of damage."""
    damaged = bytearray(data)
    for _ in range(rng.choice((1, 1, 2, 4))):
        at = rng.randrange(len(damaged) + 1)
        match rng.randrange(5):
            case 0:
                damaged[at : at + 1] = rng.randbytes(1)
            case 1:
                size = rng.choice((2, 4, 8))
                number = rng.choice((0, 1, 0x7F800000, 2**31, 2**32 - 1, rng.getrandbits(64))) % 256**size
                damaged[at : at + size] = number.to_bytes(size, rng.choice(("little", "big")))
            case 2:
                del damaged[at : at + rng.choice((1, 16, 200))]
            case 3:
                damaged[at:at] = rng.randbytes(rng.choice((1, 4, 30)))
            case _:
                del damaged[at:]
    return bytes(damaged)


def nested(rng: random.Random) -> str:
    """Return brackets in brackets, as TOML and JSON may hold them."""
    deep = rng.choice((10, 100, 1_000, 30_000))
    opening, closing = rng.choice((("[", "]"), ('{"a":', "}"), ("{a=", "}")))
    return rng.choice(("", "x = ")) + opening * deep + rng.choice(("", "1")) + closing * rng.choice((0, deep))


def _with_another_word(rng: random.Random, text: str) -> str:
    starts = [i for i, letter in enumerate(text[:50_000]) if letter in ' "=,:[\n']
    if not starts:
        return text
    start = rng.choice(starts) + 1
    end = next((i for i in range(start, len(text)) if text[i] in ' ",:]}\n'), len(text))
    return text[:start] + rng.choice(_WORDS) + text[end:]


def _with_lines_moved(rng: random.Random, text: str) -> str:
    lines = text.split("\n")
    for _ in range(3):
        a, b = rng.randrange(len(lines)), rng.randrange(len(lines))
        lines[a], lines[b] = lines[b], rng.choice((lines[a], lines[b]))
    return "\n".join(lines)


def _places(value: Any) -> list[tuple[Any, Any]]:
    """Return every list and object within a value with each of its keys."""
    items = value.items() if isinstance(value, dict) else enumerate(value) if isinstance(value, list) else ()
    return [place for key, inner in items for place in ((value, key), *_places(inner))]


def damage_values(rng: random.Random, document: Any) -> Any:
    """Return a document of lists and objects with one to four values in place of others, most of their own kind."""
    document = copy.deepcopy(document)
    for _ in range(rng.choice((1, 1, 2, 4))):
        places = _places(document)
        owner, key = rng.choice(places)
        value = owner[key]
        match rng.randrange(8):
            case 0 if isinstance(owner, dict):
                del owner[key]
            case 1:
                other, other_key = rng.choice(places)
                if other_key in (other if isinstance(other, dict) else range(len(other))):
                    owner[key] = copy.deepcopy(other[other_key])
            case 2 if isinstance(value, list):
                value += value * rng.choice((1, 3, 400))
            case 3:
                owner[key] = rng.choice(([], {}, None, True, "", "\ud800", [[0]], {"a": 1}))
            case _ if isinstance(value, str):
                owner[key] = damage_text(rng, value)
            case _:
                numbers = [owner[k] for owner, k in places if isinstance(owner, dict) and type(owner.get(k)) is int]
                owner[key] = rng.choice((*_NUMBERS, *numbers))
    return document
