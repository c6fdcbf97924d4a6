"""The one place where errors end: a line on stderr and an exit code.

An unexpected error ends here too, in one line that asks for a report. `CADET_TRACEBACK=1` shows where any
error came from.
"""

from __future__ import annotations

import errno
import os
import sys
import traceback
import warnings
from pathlib import Path
from typing import NoReturn, TextIO

import click

from cadet.cli.signals import INTERRUPTED, exit_code, how_ended
from cadet.errors import CadetError, CadetWarning, InternalError

FAILED = 2
UNFORESEEN = 70
"""The exit code of sysexits.h for an error of the program's own."""
TRACEBACK = "CADET_TRACEBACK"
_MAX_MESSAGE = 2000
_REMEDIES = {
    errno.EMFILE: "; raise the limit with ulimit -n",
    errno.ENFILE: "; end programs that hold many files open",
    errno.ENOSPC: "; make room, then run it again",
    errno.ELOOP: "; a link leads back to itself",
}


def run(command: click.Command, name: str) -> NoReturn:
    """Run a command: 0 if it went well, 2 with one line on stderr if not, 70 after a bug, 130 after Ctrl-C."""
    _show_warnings(name)
    # Terminals without a size set it, and rich prints nothing at that width.
    if os.environ.get("COLUMNS", "").strip("0") == "":
        os.environ.pop("COLUMNS", None)
    try:
        code = command.main(prog_name=name, standalone_mode=False)
    except click.exceptions.NoArgsIsHelpError as error:
        sys.stderr.write(error.format_message() + "\n")
        sys.exit(FAILED)
    except click.ClickException as error:
        _fail(name, error.format_message())
    except InternalError as error:
        _fail(name, str(error), UNFORESEEN)
    except CadetError as error:
        _fail(name, str(error))
    except OSError as error:
        reason = error.strerror or str(error)
        what = f"{error.filename}: {reason}" if error.filename else reason
        _fail(name, what + _REMEDIES.get(error.errno or 0, ""))
    except MemoryError:
        _fail(name, "out of memory")
    except KeyboardInterrupt as error:
        sys.stderr.write(f"{name}: {how_ended(error)}\n")
        sys.exit(exit_code(error))
    except click.Abort:
        sys.stderr.write(f"{name}: interrupted\n")
        sys.exit(INTERRUPTED)
    except (SystemExit, GeneratorExit):
        raise
    except BaseException as error:  # noqa: BLE001 - a panic of the core is none of Exception's kind
        _fail(name, str(InternalError(_what_happened(error))), UNFORESEEN)
    sys.exit(code if isinstance(code, int) else 0)


def _show_warnings(name: str) -> None:
    """Print cadet's own warnings as lines of the command."""
    usual = warnings.showwarning

    def show(
        message: Warning | str,
        category: type[Warning],
        filename: str,
        lineno: int,
        file: TextIO | None = None,
        line: str | None = None,
    ) -> None:
        if issubclass(category, CadetWarning):
            _write(name, f"warning: {message}")
        else:
            usual(message, category, filename, lineno, file, line)

    warnings.showwarning = show
    warnings.simplefilter("always", CadetWarning)


def _what_happened(error: BaseException) -> str:
    """Name an error and the place where it was raised."""
    frames = traceback.extract_tb(error.__traceback__)
    where = f" ({Path(frames[-1].filename).name}:{frames[-1].lineno})" if frames else ""
    return f"{type(error).__name__}: {error}{where}"


def _fail(name: str, message: str, code: int = FAILED) -> NoReturn:
    if os.environ.get(TRACEBACK, "0") not in ("", "0"):
        traceback.print_exc()
    _write(name, message)
    sys.exit(code)


def _write(name: str, message: str) -> None:
    line = " ".join(message.split())
    if len(line) > _MAX_MESSAGE:
        line = f"{line[: _MAX_MESSAGE // 2]} ... {line[-_MAX_MESSAGE // 2 :]}"
    # What a terminal can't show, such as halves of a surrogate pair in a file's name, is written as its number.
    encoding = sys.stderr.encoding or "utf-8"
    sys.stderr.write(f"{name}: {line.encode(encoding, 'backslashreplace').decode(encoding)}\n")
