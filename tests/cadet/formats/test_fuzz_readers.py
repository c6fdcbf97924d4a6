"""Whatever a file holds, reading it gives a value or a CadetError, in time and memory. `make fuzz` looks longer."""

from __future__ import annotations

import pytest

import fuzz.harness
from cadet.errors import CadetError
from fuzz.harness import fuzz as feed
from fuzz.harness import input_of
from fuzz.target import Input, Target
from fuzz.targets import TARGETS


@pytest.mark.parametrize("target", TARGETS, ids=lambda target: target.name)
def test_damaged_input_is_read_or_refused(target: Target) -> None:
    count, failures = feed(target, 1.0)
    assert count > 0
    assert failures == []


def _misbehave(value: Input) -> object:
    if value == "exit":
        raise SystemExit(3)
    if value == "forever":
        while True:
            pass
    if value == "memory":
        return bytearray(2 * fuzz.harness.BYTES)
    raise CadetError("refused")


@pytest.mark.parametrize(
    ("value", "what"),
    [("exit", "SystemExit in test_fuzz_readers.py:"), ("forever", "took more"), ("memory", "MemoryError")],
)
def test_the_harness_sees(value: str, what: str, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(fuzz.harness, "SECONDS_AN_INPUT", 0.5)
    target = Target("bad", lambda rng: value if rng.random() < 0.5 else "fine", _misbehave)
    _, failures = feed(target, 1.0)
    assert [failure.what[: len(what)] for failure in failures] == [what]
    assert input_of(target, failures[0].number) == value
