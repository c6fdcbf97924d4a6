"""Processes that read and prepare frames for another."""

from __future__ import annotations

import signal
from collections.abc import Iterator
from typing import Any

import cv2
from torch.utils.data import DataLoader


def started(loader: DataLoader[Any]) -> Iterator[Any]:
    """Start a loader's workers, each with one thread of OpenCV's.

    The number is set before they are forked: OpenCV's own threads do not come along, and a child that changes their
    number waits for them for ever.
    """
    threads = cv2.getNumThreads()
    cv2.setNumThreads(1)
    try:
        return iter(loader)
    finally:
        cv2.setNumThreads(threads)


def outlive_signals(_: int) -> None:
    """Let a worker end with its parent and not before it.

    Ctrl-C and most managers of jobs signal all processes of a group, and the parent still trains to the end of its
    step. Without a parent workers end by themselves.
    """
    for number in (signal.SIGINT, signal.SIGTERM, signal.SIGHUP):
        signal.signal(number, signal.SIG_IGN)


def as_it_is(item: Any) -> Any:
    """Return what a dataset gave: samples are not stacked."""
    return item
