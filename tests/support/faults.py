"""Generation under faults, each schedule of them a function of its number.

    python tests/support/faults.py --first 0 --count 1000
    python tests/support/faults.py --only 417          # the same faults again, told one by one

A schedule draws a format and one to three faults. A fault strikes a process (the command, or a worker) at its k-th
operation on the dataset's folder or its k-th start of a worker: the system refuses it (no room, no descriptors, a
read error), a file is cut while it is written and its writer lives on or dies of it, or a signal comes to that process
or, as Ctrl-C, to all. After each run that a fault has ended, what stands under a final name must be the undisturbed
set's, byte by byte; resuming must end with all of it.

Operations are seen through Python's audit events, so that nothing in the package knows of this. Worlds are driven once
a format; each run is a forked process that writes their samples again.
"""

from __future__ import annotations

import argparse
import contextlib
import errno
import multiprocessing
import os
import random
import resource
import shutil
import signal
import sys
import tempfile
import time
import traceback
from collections.abc import Callable, Iterator
from dataclasses import dataclass, replace
from hashlib import sha256
from itertools import count
from pathlib import Path
from types import SimpleNamespace
from typing import Any, Final

import cadet
from cadet.cli.signals import signals_end
from cadet.errors import CadetError, InternalError
from cadet.generate import Settings, generate
from cadet.generate.engines import local_engine, worker
from cadet.simulation.episode import Episode

FORMATS: Final = ("kitti", "webdataset", "nuscenes", "kitti_tracking", "kitti_raw")
ASIDE: Final = {".partial", ".staged"}
"""Folders in which unfinished files, and samples of shards that are not full, lie aside."""
OK, REFUSED, UNFORESEEN, INTERRUPTED = 0, 2, 70, 130
SECONDS_A_RUN: Final = 60.0
_SPAWN: Final = "cadet.spawn"
_EVENTS: Final = {"open", "os.rename", "os.remove", "os.mkdir", "os.listdir", "os.scandir", _SPAWN}
"""Python's audit events of what touches a folder, and ours of a worker's start."""
_ERRORS: Final = {"no room": errno.ENOSPC, "read error": errno.EIO, "no descriptors": errno.EMFILE}
_KINDS: Final = (*_ERRORS, "cut", "torn", "SIGKILL", "SIGTERM", "SIGINT")
_CUT_BYTES: Final = 100
_MAX_OPERATION: Final = 150
"""About as many as a process of these sets has."""


@dataclass(frozen=True)
class Fault:
    """One fault.

    Attributes:
        process: 0 for the command, k for the k-th worker that it starts.
        operation: the number of the operation, from 0, that it strikes.
        kind: one of `_KINDS`.
    """

    process: int
    operation: int
    kind: str


@dataclass(frozen=True)
class Schedule:
    """What happens to a dataset: one fault a run, then a run without."""

    format: str
    num_workers: int
    faults: tuple[Fault, ...]


def schedule_of(number: int, formats: tuple[str, ...] = FORMATS) -> Schedule:
    """Return the schedule of a number."""
    draws = random.Random(f"faults {number}")
    num_workers = draws.randint(1, 2)
    faults = tuple(
        Fault(draws.randint(0, num_workers), int(_MAX_OPERATION ** draws.random()) - 1, draws.choice(_KINDS))
        for _ in range(draws.randint(1, 3))
    )
    return Schedule(formats[number % len(formats)], num_workers, faults)


def settings_of(dataset_format: str) -> Settings:
    """Return a set of three episodes of two small frames."""
    policy = replace(cadet.ResetPolicy.kitti(), samples_per_episode=2)
    policy = policy.with_each_rig(lambda rig: rig.with_lidar(cadet.Lidar.vlp16()).with_image_size(124, 38))
    rig = None
    if dataset_format == "nuscenes":
        rig = cadet.Rig.nuscenes().with_image_size(80, 45)
    if dataset_format not in ("kitti", "webdataset"):
        policy = replace(policy.as_sequence(hz=2.0, length_s=1.0), samples_per_episode=2)
    shard_size = 4 if dataset_format == "webdataset" else None
    return Settings(seed=3, num_frames=6, policy=policy, rig=rig, format=dataset_format, shard_size=shard_size)


class Undisturbed:
    """A set without faults: its samples, kept for the runs to come, and the hash of each of its files."""

    def __init__(self, dataset_format: str, folder: Path) -> None:
        self.settings = settings_of(dataset_format)
        self._samples: dict[tuple[int, int], Any] = {}
        wanted = self.settings.wanted
        for episode in range(self.settings.num_episodes):
            views = Episode(self.settings.policy, self.settings.seed, episode, wanted=wanted)
            for number in range(self.settings.num_samples(episode)):
                self._samples[episode, number] = views.next_sample(number)
        code = self.run(folder, 1, None)
        assert code == OK, f"exit code {code} without a fault"
        self.hashes = hashes(folder)
        shutil.rmtree(folder)

    def run(self, folder: Path, num_workers: int, fault: Fault | None) -> int:
        """Generate in a forked process, go on with what is there, and return its exit code; negative for a signal."""
        pid = os.fork()
        if pid == 0:
            os.setpgid(0, 0)
            os._exit(_generate(self, folder, num_workers, fault))
        end_s = time.monotonic() + SECONDS_A_RUN
        while (found := os.waitpid(pid, os.WNOHANG))[0] == 0:
            if time.monotonic() > end_s:
                os.killpg(pid, signal.SIGKILL)
                os.waitpid(pid, 0)
                raise AssertionError(f"the run has not ended within {SECONDS_A_RUN:g} s")
            time.sleep(0.005)
        # Workers of a killed command end by themselves.
        while _is_group_alive(pid):
            assert time.monotonic() < end_s, "workers go on without the command"
            time.sleep(0.005)
        return os.waitstatus_to_exitcode(found[1])

    def episode(self, settings: Any, seed: int, number: int, **_: Any) -> _Kept:
        """Stand in for `Episode`."""
        return _Kept(self._samples, number)


@dataclass(frozen=True)
class _Kept:
    samples: dict[tuple[int, int], Any]
    number: int

    def next_sample(self, sample: int) -> Any:
        return self.samples[self.number, sample]


def hashes(folder: Path) -> dict[str, str]:
    """Return the hash of each file of a folder that has its final name."""
    files = (path for path in folder.rglob("*") if path.is_file() and not ASIDE & set(path.parts))
    return {str(path.relative_to(folder)): sha256(path.read_bytes()).hexdigest() for path in files}


def play(schedule: Schedule, undisturbed: Undisturbed, folder: Path, tell: Callable[[str], object]) -> None:
    """Let a schedule's faults happen, then resume without.

    Raises:
        AssertionError: what should not have happened.
    """
    for fault in (*schedule.faults, None):
        code = undisturbed.run(folder, schedule.num_workers, fault)
        found = hashes(folder) if folder.exists() else {}
        tell(f"{fault}: exit code {code}, {len(found)} of {len(undisturbed.hashes)} files")
        wrong = sorted(name for name, digest in found.items() if undisturbed.hashes.get(name) != digest)
        assert not wrong, f"after {fault}: {len(wrong)} files differ, such as {wrong[0]}"
        allowed = {OK} if fault is None else {OK, REFUSED, INTERRUPTED, -signal.SIGKILL, -signal.SIGXFSZ}
        assert code in allowed, f"after {fault}: exit code {code}"
    missing = sorted(set(undisturbed.hashes) - set(found))
    assert not missing, f"{len(missing)} files are missing, such as {missing[0]}"
    left = ASIDE & {path.name for path in folder.iterdir()}
    assert not left, f"{left} is left"


def _generate(undisturbed: Undisturbed, folder: Path, num_workers: int, fault: Fault | None) -> int:
    """Do what `cadet-gen` does, in this process that nothing else uses; return the exit code."""
    processes, operations = count(), count()
    here = next(processes)

    def strike(event: str, arguments: tuple[Any, ...]) -> None:
        is_here = fault is not None and fault.process == here and _is_ours(event, arguments, folder)
        if is_here and fault is not None and next(operations) == fault.operation:
            _happen(fault.kind)

    fork = multiprocessing.get_context("fork")
    ends: list[Any] = []
    usual = worker.work

    def work(number: int, *arguments: Any) -> None:
        nonlocal here
        here = number
        signal.signal(signal.SIGTERM, signal.SIG_DFL)
        # A fork holds the command's ends of all pipes, too, so that no worker would see one close.
        for end in ends:
            end.close()
        usual(*arguments)

    def pipe() -> tuple[Any, Any]:
        ours, theirs = fork.Pipe()
        ends.append(ours)
        return ours, theirs

    def process(target: object, args: tuple[Any, ...], daemon: bool) -> Any:
        sys.audit(_SPAWN, str(folder))
        return fork.Process(target=work, args=(next(processes), *args), daemon=daemon)

    # Forked workers have the samples and this process's audit hook; those of the package start anew.
    vars(local_engine)["WorkerContext"] = lambda: SimpleNamespace(Pipe=pipe, Process=process)
    vars(worker)["Episode"] = undisturbed.episode
    resume = (folder / "run.json").exists()
    if not resume:
        shutil.rmtree(folder, ignore_errors=True)
    sys.addaudithook(strike)
    try:
        with signals_end():
            generate(folder, undisturbed.settings, workers=num_workers, resume=resume)
    except KeyboardInterrupt:
        return INTERRUPTED
    except InternalError:
        traceback.print_exc()
        return UNFORESEEN
    except (CadetError, OSError) as error:
        return REFUSED if str(error) and "\n" not in str(error) else UNFORESEEN
    except BaseException:  # noqa: BLE001 - whatever else comes is what we look for
        traceback.print_exc()
        return UNFORESEEN
    return OK


def _is_ours(event: str, arguments: tuple[Any, ...], folder: Path) -> bool:
    path = arguments[0] if event in _EVENTS and arguments else None
    return isinstance(path, (str, os.PathLike)) and os.fspath(path).startswith(str(folder))


def _happen(kind: str) -> None:
    if kind in _ERRORS:
        raise OSError(_ERRORS[kind], os.strerror(_ERRORS[kind]))
    if kind in ("cut", "torn"):
        # The system cuts what is written next, and every file from here on; a torn file's writer dies of it.
        signal.signal(signal.SIGXFSZ, signal.SIG_IGN if kind == "cut" else signal.SIG_DFL)
        resource.setrlimit(resource.RLIMIT_CORE, (0, 0))
        resource.setrlimit(resource.RLIMIT_FSIZE, (_CUT_BYTES, resource.RLIM_INFINITY))
        return
    if kind == "SIGINT":
        # As a terminal sends it.
        os.killpg(0, signal.SIGINT)
    else:
        os.kill(os.getpid(), signal.Signals[kind])


def _is_group_alive(group: int) -> bool:
    """Tell whether a process of a group runs; one that only waits for its end to be noticed does not."""
    for path in Path("/proc").glob("[0-9]*/stat"):
        with contextlib.suppress(OSError):
            state, _, found = path.read_text().rpartition(")")[2].split()[:3]
            if int(found) == group and state != "Z":
                return True
    return False


def failures(numbers: Iterator[int], formats: tuple[str, ...], tell: Callable[[str], object]) -> list[str]:
    """Play schedules, and return what should not have happened."""
    undisturbed: dict[str, Undisturbed] = {}
    found = []
    with tempfile.TemporaryDirectory() as scratch:
        for number in numbers:
            schedule = schedule_of(number, formats)
            if schedule.format not in undisturbed:
                undisturbed[schedule.format] = Undisturbed(schedule.format, Path(scratch) / "whole")
            folder = Path(scratch) / f"{number}"
            tell(f"{number}: {schedule.format}, {schedule.num_workers} workers")
            try:
                play(schedule, undisturbed[schedule.format], folder, tell)
            except AssertionError as error:
                found.append(f"{number}: {schedule}: {error}")
            shutil.rmtree(folder, ignore_errors=True)
    return found


def _print(text: str) -> None:
    sys.stdout.write(f"{text}\n")
    sys.stdout.flush()


def main() -> None:
    """Play schedules by number; the exit code is 1 if one failed."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--first", type=int, default=0)
    parser.add_argument("--count", type=int, default=1000)
    parser.add_argument("--only", type=int)
    options = parser.parse_args()
    numbers = range(options.first, options.first + options.count) if options.only is None else [options.only]
    found = failures(iter(numbers), FORMATS, _print if options.only is not None else lambda text: None)
    _print("".join(f"{line}\n" for line in found) + f"{len(numbers)} schedules, {len(found)} failed")
    sys.exit(1 if found else 0)


if __name__ == "__main__":
    main()
