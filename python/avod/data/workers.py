"""Processes that read and prepare frames for another."""

from __future__ import annotations

import signal
from collections.abc import Iterator
from contextlib import contextmanager
from typing import Any

import cv2
import torch
from torch.utils.data import DataLoader
from torch.utils.data.dataloader import _MultiProcessingDataLoaderIter

from cadet._util.operating_system import ENDING_SIGNALS


@contextmanager
def running(loader: DataLoader[Any]) -> Iterator[Iterator[Any]]:
    """Run a loader's workers meanwhile, each with one thread of OpenCV's.

    The number is set before they are forked: OpenCV's own threads do not come along, and a child that changes their
    number waits for them for ever. The loader's own draw, a seed for its workers, is not taken from the caller's
    generator. At the end workers are told to go, whatever still refers to the iterator, such as an
    error's traceback: this process waits for them before it ends, and they may outlive signals.
    """
    loader.generator = torch.Generator()
    threads = cv2.getNumThreads()
    cv2.setNumThreads(1)
    try:
        iterator = iter(loader)
    finally:
        cv2.setNumThreads(threads)
    try:
        yield iterator
    finally:
        if isinstance(iterator, _MultiProcessingDataLoaderIter):
            iterator._shutdown_workers()


def outlive_signals(_: int) -> None:
    """Let a worker end with its parent and not before it.

    Ctrl-C and most managers of jobs signal all processes of a group, and the parent still trains to the end of its
    step. They end when they are told to (`running`), or without a parent.
    """
    for number in (signal.SIGINT, *ENDING_SIGNALS):
        signal.signal(number, signal.SIG_IGN)


def as_it_is(item: Any) -> Any:
    """Return what a dataset gave: samples are not stacked."""
    return item
