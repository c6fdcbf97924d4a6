"""The one place where errors end: a line on stderr and an exit code."""

from __future__ import annotations

import sys
from typing import NoReturn

import click

from cadet.errors import CadetError

INTERRUPTED = 130
FAILED = 2


def run(command: click.Command, name: str) -> NoReturn:
    """Run a command: 0 if it went well, 2 with one line on stderr if not, 130 after Ctrl-C."""
    try:
        code = command.main(prog_name=name, standalone_mode=False)
    except click.exceptions.NoArgsIsHelpError as error:
        sys.stderr.write(error.format_message() + "\n")
        sys.exit(FAILED)
    except click.ClickException as error:
        _fail(name, error.format_message())
    except CadetError as error:
        _fail(name, str(error))
    except OSError as error:
        _fail(name, f"{error.filename}: {error.strerror}" if error.filename else str(error))
    except (click.Abort, KeyboardInterrupt):
        sys.stderr.write(f"{name}: interrupted\n")
        sys.exit(INTERRUPTED)
    sys.exit(code if isinstance(code, int) else 0)


def _fail(name: str, message: str) -> NoReturn:
    sys.stderr.write(f"{name}: {' '.join(message.split())}\n")
    sys.exit(FAILED)
