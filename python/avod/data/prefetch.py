"""Items of an iterator, taken by a thread before they are asked for."""

from __future__ import annotations

import contextlib
import queue
import threading
from collections.abc import Iterator
from dataclasses import dataclass
from typing import Any, Final, TypeVar

T = TypeVar("T")

_POLL_S: Final = 0.2


@dataclass(frozen=True)
class _End:
    error: BaseException | None


@contextlib.contextmanager
def prefetched(items: Iterator[T], size: int, is_over: threading.Event) -> Iterator[Iterator[T]]:
    """Let a thread take up to `size` items ahead meanwhile; an error comes out in its turn.

    Args:
        items: are taken one after the other, by the thread alone.
        size: how many may wait.
        is_over: ends the iterator and, once it has taken the item that it is about to, the thread, which is then waited
            for. Threads that take from each other share it. It is set at the end.
    """
    ready: queue.Queue[Any] = queue.Queue(size)
    thread = threading.Thread(target=_take, args=(items, ready, is_over), daemon=True)
    thread.start()
    try:
        yield _given(ready, is_over)
    finally:
        is_over.set()
        thread.join()


def _take(items: Iterator[Any], ready: queue.Queue[Any], is_over: threading.Event) -> None:
    error: BaseException | None = None
    try:
        for item in items:
            _put(ready, item, is_over)
            if is_over.is_set():
                return
    except BaseException as caught:  # noqa: BLE001 - raised again where the item was wanted
        error = caught
    _put(ready, _End(error), is_over)


def _put(ready: queue.Queue[Any], item: object, is_over: threading.Event) -> None:
    while not is_over.is_set():
        with contextlib.suppress(queue.Full):
            ready.put(item, timeout=_POLL_S)
            return


def _given(ready: queue.Queue[Any], is_over: threading.Event) -> Iterator[Any]:
    while not is_over.is_set():
        try:
            item = ready.get(timeout=_POLL_S)
        except queue.Empty:
            continue
        if not isinstance(item, _End):
            yield item
        elif item.error is None:
            return
        else:
            raise item.error
