"""What CI must not skip: where `CI` is set, a tool that is missing is a failure and no skip."""

from __future__ import annotations

import os
from typing import NoReturn

import pytest


def is_ci() -> bool:
    """Whether `CI` says that these are CI's own tests."""
    return os.environ.get("CI", "").lower() not in ("", "0", "false")


def skip_or_fail_in_ci(reason: str) -> NoReturn:
    """Skip a developer's test for want of a tool; fail CI's."""
    if is_ci():
        pytest.fail(f"{reason}: CI may not do without", pytrace=False)
    pytest.skip(reason)
