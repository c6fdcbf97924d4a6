"""Where errors end: what nobody foresaw is a line that asks for a report, too."""

from __future__ import annotations

import click
import pytest

from cadet.cli.errors import run
from cadet.errors import CadetError, InternalError


class Panic(BaseException):
    """What is none of Exception's kind."""


def ended(error: BaseException, capsys: pytest.CaptureFixture[str]) -> tuple[object, str]:
    """Run a command that raises an error: its exit code and what it printed."""

    @click.command()
    def fail() -> None:
        raise error

    with pytest.MonkeyPatch.context() as patch:
        patch.setattr("sys.argv", ["cadet"])
        with pytest.raises(SystemExit) as exited:
            run(fail, "cadet")
    stdout, stderr = capsys.readouterr()
    assert stdout == ""
    return exited.value.code, stderr


@pytest.mark.parametrize(
    ("error", "code", "text"),
    [
        (CadetError("a.txt:3: bad"), 2, "cadet: a.txt:3: bad\n"),
        (MemoryError(), 2, "cadet: out of memory\n"),
        (CadetError("half \ud800"), 2, "cadet: half \\ud800\n"),
        (InternalError("it broke"), 70, "cadet: internal error: it broke; please report it, with what led to it, "),
        (ZeroDivisionError("by\nzero"), 70, "cadet: internal error: ZeroDivisionError: by zero (test_cli_errors.py:"),
        (Panic("len is 3"), 70, "cadet: internal error: Panic: len is 3 (test_cli_errors.py:"),
    ],
)
def test_every_error_is_one_line(
    error: BaseException, code: int, text: str, capsys: pytest.CaptureFixture[str]
) -> None:
    got_code, stderr = ended(error, capsys)
    assert got_code == code
    assert stderr.startswith(text)
    assert stderr.count("\n") == 1


def test_endless_messages_are_cut(capsys: pytest.CaptureFixture[str]) -> None:
    _, stderr = ended(CadetError("x" * 100_000), capsys)
    assert len(stderr) < 2100


def test_the_traceback_is_shown_on_demand(capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv("CADET_TRACEBACK", "1")
    _, stderr = ended(ZeroDivisionError("by zero"), capsys)
    assert stderr.startswith("Traceback (most recent call last):\n")
    assert stderr.splitlines()[-1].startswith("cadet: internal error: ")
