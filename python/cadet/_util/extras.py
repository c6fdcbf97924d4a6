"""Libraries that come with an extra of the package, imported when they are first needed."""

from __future__ import annotations

import importlib
from typing import Any

from cadet.errors import CadetError


def load_extra(module: str, extra: str, purpose: str) -> Any:
    """Import a library that not everyone has.

    Args:
        module: its dotted name.
        extra: the extra of `cadet-sim` that brings it.
        purpose: what needs it, for the message.

    Raises:
        CadetError: it is not installed.
    """
    try:
        return importlib.import_module(module)
    except ImportError as error:
        missing = error.name or module
        raise CadetError(f"{purpose} needs {missing}: pip install 'cadet-sim[{extra}]'") from None
