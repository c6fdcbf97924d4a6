"""What CI may skip: where `CI` is set, a test that is skipped for any other reason fails."""

from __future__ import annotations

import os
import re
from collections.abc import Generator
from typing import Final

import pytest

ALLOWED: Final = (
    r"needs .* in \.\./shared/",  # files that are not ours to give away
    r"needs (nuscenes-devkit|stable-baselines3|Open3D)",
    r"reads the folder with [\w.]+",  # toolboxes that hold back newer versions of others
    r"needs (Chromium|mkdocs, the extra docs)",
)
"""Whole reasons, as regular expressions."""


def is_ci() -> bool:
    """Whether `CI` says that these are CI's own tests."""
    return os.environ.get("CI", "").lower() not in ("", "0", "false")


def is_allowed(reason: str) -> bool:
    """Whether CI may skip a test for this reason."""
    return any(re.match(allowed, reason.removeprefix("Skipped: ")) for allowed in ALLOWED)


def _failed_if_skipped(report: pytest.TestReport | pytest.CollectReport) -> None:
    if report.outcome == "skipped" and is_ci() and not hasattr(report, "wasxfail"):
        reason = report.longrepr[2] if isinstance(report.longrepr, tuple) else str(report.longrepr)
        if not is_allowed(reason):
            report.outcome = "failed"
            report.longrepr = f"{reason}: CI may not skip for this; what it may stands in tests/support/in_ci.py"


@pytest.hookimpl(wrapper=True)
def pytest_runtest_makereport() -> Generator[None, pytest.TestReport, pytest.TestReport]:
    """Fail what CI skips without leave."""
    report = yield
    _failed_if_skipped(report)
    return report


@pytest.hookimpl(wrapper=True)
def pytest_make_collect_report() -> Generator[None, pytest.CollectReport, pytest.CollectReport]:
    """Fail modules that CI skips as a whole without leave."""
    report = yield
    _failed_if_skipped(report)
    return report
