"""TOML and JSON that would end Python's own readers, or whoever walks through what they return."""

from __future__ import annotations

from collections.abc import Callable

import pytest

from cadet._util.plain_text import MAX_DEPTH, json_from_text, toml_from_text
from cadet.errors import CadetError, FileFormatError


def lists(deep: int) -> str:
    return "[" * deep + "]" * deep


@pytest.mark.parametrize(
    ("read", "text", "message"),
    [
        (json_from_text, lists(100_000), "f.x: invalid JSON: nested deeper than 64"),
        (json_from_text, lists(MAX_DEPTH + 1), "f.x: nested deeper than 64"),
        (json_from_text, '{"a":' * 80 + "1" + "}" * 80, "f.x: nested deeper than 64"),
        (json_from_text, "7" * 5000, "f.x: invalid JSON: a whole number has too many digits"),
        (json_from_text, "[1,\n2,\n]", "f.x:3: invalid JSON: "),
        (json_from_text, b"\xff", "f.x: invalid JSON: "),
        (json_from_text, "Infinity", "f.x: invalid JSON: Infinity is not a number"),
        (toml_from_text, f"x = {lists(5000)}", "f.x: invalid TOML: "),
        (toml_from_text, f"x = {lists(MAX_DEPTH + 1)}", "f.x: nested deeper than 64"),
        (toml_from_text, ".".join("a" * 500) + " = 1", "f.x: nested deeper than 64"),
        (toml_from_text, f"x = {'7' * 5000}", "f.x: invalid TOML: a whole number has too many digits"),
        (toml_from_text, b"x = '\xff'", "f.x: invalid TOML: "),
        (toml_from_text, "x = ", "f.x: invalid TOML: "),
        (toml_from_text, ".".join("a" * 20_000) + " = 1", "f.x: nested deeper than 64"),
        (toml_from_text, "[t]\n" + " . ".join(['"a b"', "'c.d'", "e"] * 30) + " = 1", "f.x: nested deeper than 64"),
        (toml_from_text, f"[[a]]\nb = 1\n[[a]]\nb = [1, {10**400}]", "f.x: a[1].b[1]: a whole number of 401 digits"),
        (json_from_text, f'{{"a": [{-(2**64)}]}}', "f.x: a[0]: a whole number of 20 digits"),
        (json_from_text, '[{"a": -1e309}]', "f.x: [0].a: expected a finite number, got -inf"),
        (json_from_text, '{"a": "\\ud800"}', "f.x: a: '\\ud800' is not valid text: half of a surrogate pair"),
        (json_from_text, '{"\\udc00x": 1}', "f.x: "),
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


@pytest.mark.parametrize(
    "text",
    [
        "x = [" + ", ".join(["0.5"] * 1000) + "]",
        "# " + "A sentence. " * 200,
        "x = '" + "1.2, " * 500 + "'",
        "\ufeffx = 1",
        "x = 1\r\n",
        "x = inf",
        f"x = {2**64 - 1}",
        "x = 'gr\u00fcn \U0001f600'",
    ],
)
def test_plain_values_are_read(text: str) -> None:
    toml_from_text(text.encode(), "f.toml")


def test_depth_up_to_the_limit_is_read() -> None:
    assert json_from_text(lists(MAX_DEPTH), "f.json") == eval(lists(MAX_DEPTH))
    assert toml_from_text(f"x = {lists(MAX_DEPTH - 1)}", "f.toml") == {"x": eval(lists(MAX_DEPTH - 1))}
