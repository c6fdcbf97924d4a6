"""A function of many things, in several processes."""

from __future__ import annotations

import signal
from collections.abc import Callable, Iterator, Sequence
from typing import Final, TypeVar

from cadet._util.checks import check_number
from cadet.errors import CadetError

_Item = TypeVar("_Item")
_Result = TypeVar("_Result")

_FEWEST_TIMES: Final = 4
"""Starting processes takes longer than fewer times the items that each takes at once."""


def process_map(
    function: Callable[[_Item], _Result], items: Sequence[_Item], *, workers: int = 1, at_once: int = 8
) -> Iterator[_Result]:
    """Yield the function's results in the order of the items, whatever the number of processes.

    Args:
        function: can be pickled, as its items and results can.
        items: what it is called with.
        workers: processes; with 1, or for a few items, the caller's own.
        at_once: items that a process takes at once: 1 where each takes a second or more.

    Raises:
        CadetError: `workers` is not a whole number from 1 to 1024, or a process died.
    """
    check_number("", "workers", workers, 1, 1024, whole=True)
    if workers == 1 or len(items) < _FEWEST_TIMES * at_once:
        yield from map(function, items)
        return
    # Most programs need no pool, and these take a tenth of the time of `import cadet`.
    from concurrent.futures import ProcessPoolExecutor
    from concurrent.futures.process import BrokenProcessPool

    from cadet._util.worker_processes import WorkerContext

    pool = ProcessPoolExecutor(int(workers), mp_context=WorkerContext(), initializer=_leave_interrupts_to_the_parent)
    try:
        yield from pool.map(function, items, chunksize=at_once)
    except BrokenProcessPool:
        raise CadetError("a worker process died; is there enough memory? One worker takes the least") from None
    finally:
        pool.shutdown(cancel_futures=True)


def _leave_interrupts_to_the_parent() -> None:
    signal.signal(signal.SIGINT, signal.SIG_IGN)
