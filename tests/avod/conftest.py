"""The detector's tests need torch."""

from needs_torch import collect_ignore_glob, pytest_runtest_setup

__all__ = ["collect_ignore_glob", "pytest_runtest_setup"]
