from __future__ import annotations

import math
import os
import sys
import time
from concurrent.futures import ThreadPoolExecutor
from contextlib import suppress
from multiprocessing.context import SpawnProcess
from threading import Barrier, BrokenBarrierError

import pytest

from cadet._util.process_map import process_map
from cadet._util.worker_processes import WorkerProcess
from cadet.errors import CadetError


@pytest.mark.parametrize("workers", [1, 2])
def test_results_come_in_the_order_of_the_items(workers: int) -> None:
    items = [float(number) for number in range(100, 0, -1)]
    assert list(process_map(math.sqrt, items, workers=workers)) == [math.sqrt(item) for item in items]


def test_a_process_that_dies_is_one_line() -> None:
    with pytest.raises(CadetError, match=r"^a worker process died"):
        list(process_map(os._exit, [3] * 40, workers=2))


def test_an_error_of_the_function_is_raised() -> None:
    with pytest.raises(ValueError, match=r"math domain error|expected a nonnegative input"):
        list(process_map(math.sqrt, [-1.0] * 40, workers=2))


@pytest.mark.parametrize("of_user", [{}, {"OPENBLAS_NUM_THREADS": "3"}, {"OMP_NUM_THREADS": "2"}])
def test_workers_compute_with_one_thread_unless_the_user_says_otherwise(
    of_user: dict[str, str], monkeypatch: pytest.MonkeyPatch
) -> None:
    for name in ("OPENBLAS_NUM_THREADS", "GOTO_NUM_THREADS", "OMP_NUM_THREADS"):
        monkeypatch.delenv(name, raising=False)
    for name, value in of_user.items():
        monkeypatch.setenv(name, value)
    expected = of_user or {"OPENBLAS_NUM_THREADS": "1"}
    for name in ("OPENBLAS_NUM_THREADS", "OMP_NUM_THREADS"):
        assert set(process_map(os.getenv, [name] * 40, workers=2)) == {expected.get(name)}
        assert os.environ.get(name) == of_user.get(name)


def test_threads_that_start_workers_at_once_leave_the_script_and_the_environment_alone(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    for name in ("OPENBLAS_NUM_THREADS", "GOTO_NUM_THREADS", "OMP_NUM_THREADS"):
        monkeypatch.delenv(name, raising=False)
    script, both_start = sys.modules["__main__"], Barrier(2)

    def start(process: SpawnProcess) -> None:
        # Of two that start at once the first to begin is the first to end.
        with suppress(BrokenBarrierError):
            time.sleep(0.2 * both_start.wait(timeout=1.0))

    monkeypatch.setattr(SpawnProcess, "start", start)
    with ThreadPoolExecutor(2) as threads:
        list(threads.map(lambda _: WorkerProcess().start(), range(2)))
    assert sys.modules["__main__"] is script
    assert "OPENBLAS_NUM_THREADS" not in os.environ


@pytest.mark.parametrize("workers", [0, 1.5, 2000])
def test_a_number_of_processes_that_is_none_is_refused(workers: float) -> None:
    with pytest.raises(CadetError, match="workers"):
        list(process_map(math.sqrt, [1.0], workers=workers))  # type: ignore[arg-type]
