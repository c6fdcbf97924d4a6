"""A stream's frames: those of `Environment`, in the same order for any number of processes, shard, and start."""

from __future__ import annotations

import hashlib
import itertools
import os
import signal
import subprocess
import sys
import time
from collections.abc import Iterable
from dataclasses import replace
from pathlib import Path

import pytest

import cadet
from cadet.errors import WorkerError
from cadet.sensors.camera import Camera

# Three samples an episode and a small image: what is tested is the order.
_RIG = replace(cadet.Rig.kitti(), camera=Camera.kitti().resized(310, 94), lidar=cadet.Lidar("vlp16"))
_POLICY = replace(cadet.ResetPolicy.kitti(), samples_per_episode=3)


def open_stream(*, workers: int, first: int = 0, shard: tuple[int, int] = (0, 1), seed: int = 3) -> cadet.FrameStream:
    return cadet.stream(_POLICY, seed=seed, workers=workers, first=first, shard=shard, rig=_RIG)


def digests(frames: Iterable[cadet.Frame], count: int) -> list[str]:
    return [
        hashlib.sha256(frame.image.tobytes() + frame.points_velo.tobytes() + repr(frame.labels).encode()).hexdigest()
        for frame in itertools.islice(frames, count)
    ]


@pytest.fixture(scope="module")
def expected() -> list[str]:
    environment = cadet.Environment(policy=_POLICY, rig=_RIG)
    environment.reset(seed=3)
    return digests((environment.step() for _ in range(12)), 12)


@pytest.mark.parametrize("workers", [0, 1, 2, 3])
def test_the_frames_are_the_environments_for_any_number_of_processes(workers: int, expected: list[str]) -> None:
    assert len(set(expected)) == 12
    with open_stream(workers=workers) as frames:
        assert digests(frames, 12) == expected
        assert frames.position == 12


@pytest.mark.parametrize(("workers", "first"), [(0, 4), (2, 4), (2, 3), (2, 8)])
def test_a_stream_goes_on_where_another_stopped(workers: int, first: int, expected: list[str]) -> None:
    with open_stream(workers=workers, first=first) as frames:
        assert frames.position == first
        assert digests(frames, 12 - first) == expected[first:]


_IN_A_DAEMON = """
import multiprocessing, sys
import cadet

def open_stream(workers):
    try:
        with cadet.stream(workers=workers) as frames:
            print(next(frames).meta["episode"], flush=True)
    except cadet.CadetError as error:
        print(error, flush=True)

if __name__ == "__main__":
    workers = {"None": None, "1": 1}[sys.argv[1]]
    process = multiprocessing.get_context("spawn").Process(target=open_stream, args=(workers,), daemon=True)
    process.start()
    process.join()
"""


@pytest.mark.parametrize(
    ("workers", "told"),
    [
        ("None", "0"),
        ("1", "a process that is itself a worker, such as a data loader's, can start none: pass workers=0 to a stream"),
    ],
)
def test_a_data_loaders_worker_makes_its_frames_itself(workers: str, told: str, tmp_path: Path) -> None:
    """Processes of `torch.utils.data.DataLoader` are daemons, which can start none."""
    (script := tmp_path / "loads.py").write_text(_IN_A_DAEMON)
    done = subprocess.run([sys.executable, script, workers], capture_output=True, text=True, timeout=100, check=False)
    assert (done.returncode, done.stderr) == (0, "")
    assert done.stdout.startswith(told)


def test_shards_share_the_episodes_without_overlap(expected: list[str]) -> None:
    episodes = [expected[k : k + 3] for k in range(0, 12, 3)]
    for index in range(2):
        with open_stream(workers=1, shard=(index, 2)) as frames:
            assert digests(frames, 6) == episodes[index] + episodes[index + 2]
    # Going on counts the shard's own frames.
    with open_stream(workers=2, shard=(1, 2), first=4) as frames:
        assert digests(frames, 2) == (episodes[1] + episodes[3])[4:]


def test_processes_end_with_the_stream() -> None:
    frames = open_stream(workers=2)
    next(frames)
    pids = [process.pid for _, process in frames._processes]
    frames.close()
    for pid in pids:
        assert pid is not None
        with pytest.raises(ProcessLookupError):
            os.kill(pid, 0)
    with pytest.raises(cadet.CadetError, match="stream: it was closed"):
        next(frames)


def test_a_dead_worker_is_told_of() -> None:
    with open_stream(workers=1) as frames:
        next(frames)
        ((_, process),) = frames._processes
        assert process.pid is not None
        os.kill(process.pid, signal.SIGKILL)
        with pytest.raises(WorkerError, match="a worker died with exit code -9"):
            digests(frames, 100)


def test_what_goes_wrong_in_a_worker_is_told_in_one_line() -> None:
    nothing = replace(_POLICY, districts=((cadet.District(name="none", parking_occupancy=(0.0, 0.0), num_cars=(0, 0),
                      num_pedestrians=(0, 0)), 1.0),), attempts_limit=1, empty_views_limit=1)  # fmt: skip
    with cadet.stream(nothing, workers=1, rig=_RIG) as frames, pytest.raises(cadet.CadetError, match="episode 0"):
        next(frames)


def test_a_worker_runs_no_more_than_an_episode_ahead() -> None:
    with open_stream(workers=1) as frames:
        next(frames)
        ((_, process),) = frames._processes
        for _ in range(120):
            before = _processor_seconds(process.pid)
            time.sleep(1.0)
            if _processor_seconds(process.pid) - before < 0.05:
                break
        else:
            pytest.fail("it works on without end")


def _processor_seconds(pid: int | None) -> float:
    fields = Path(f"/proc/{pid}/stat").read_text().rsplit(")", 1)[1].split()
    return (int(fields[11]) + int(fields[12])) / os.sysconf("SC_CLK_TCK")


@pytest.mark.parametrize("shard", [(1, 1), (-1, 2), (0,), "01", (0.0, 1)])
def test_shards_that_are_none_are_refused(shard: object) -> None:
    with pytest.raises(cadet.CadetError, match=r"stream\.shard: expected"):
        cadet.stream(shard=shard)  # type: ignore[arg-type]
