"""TOML and JSON that would end Python's own readers, or whoever walks through what they return."""

from __future__ import annotations

from collections.abc import Callable

import pytest

from cadet.errors import CadetError, FileFormatError
from cadet.plain_text import MAX_DEPTH, json_from_text, toml_from_text


def lists(deep: int) -> str:
    return "[" * deep + "]" * deep


@pytest.mark.parametrize(
    ("read", "text", "message"),
    [
        (json_from_text, lists(100_000), "f.x: no JSON: nested deeper than 64"),
        (json_from_text, lists(MAX_DEPTH + 1), "f.x: nested deeper than 64"),
        (json_from_text, '{"a":' * 80 + "1" + "}" * 80, "f.x: nested deeper than 64"),
        (json_from_text, "7" * 5000, "f.x: no JSON: a whole number has too many digits"),
        (json_from_text, "[1,\n2,\n]", "f.x:3: no JSON: "),
        (json_from_text, b"\xff", "f.x: no JSON: "),
        (json_from_text, "Infinity", "f.x: no JSON: Infinity is no number"),
        (toml_from_text, f"x = {lists(5000)}", "f.x: no TOML: "),
        (toml_from_text, f"x = {lists(MAX_DEPTH + 1)}", "f.x: nested deeper than 64"),
        (toml_from_text, ".".join("a" * 500) + " = 1", "f.x: nested deeper than 64"),
        (toml_from_text, f"x = {'7' * 5000}", "f.x: no TOML: a whole number has too many digits"),
        (toml_from_text, b"x = '\xff'", "f.x: no TOML: "),
        (toml_from_text, "x = ", "f.x: no TOML: "),
    ],
)
def test_what_cannot_be_read_is_refused_with_its_name(
    read: Callable[[str | bytes, str], object], text: str | bytes, message: str
) -> None:
    with pytest.raises(FileFormatError) as refused:
        read(text, "f.x")
    assert str(refused.value).startswith(message)
    assert "\n" not in str(refused.value)
    assert isinstance(refused.value, CadetError)


def test_depth_up_to_the_limit_is_read() -> None:
    assert json_from_text(lists(MAX_DEPTH), "f.json") == eval(lists(MAX_DEPTH))
    assert toml_from_text(f"x = {lists(MAX_DEPTH - 1)}", "f.toml") == {"x": eval(lists(MAX_DEPTH - 1))}
