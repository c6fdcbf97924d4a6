"""`cadet-gen` under failures: the same bytes in the end, and nothing half-written at any time.

    python benches/failures.py DIR -n 2000 --workers 2 --failures 20 -- --image-size 621x188

What follows `--` goes to `cadet-gen`. DIR gets an undisturbed set (`whole`) and one (`disturbed`) whose runs meet, at
random times: `kill -9` of a worker, `kill -9` of the command, SIGINT to the group as a terminal sends it, SIGTERM to
the command, and a full disk. After each end every file that is there must be the undisturbed set's, byte by byte, and
the run is resumed. A full disk needs a DIR that may be filled:

    mount -t tmpfs -o size=2g none DIR

and `--fill`. The script ends with exit code 1 at the first difference.
"""

from __future__ import annotations

import argparse
import contextlib
import errno
import os
import random
import shutil
import signal
import subprocess
import sys
import tempfile
import time
from hashlib import sha256
from pathlib import Path
from typing import Final

from worker_processes import workers_of

RUN: Final = "from cadet.cli import run_cadet_gen\nif __name__ == '__main__':\n    run_cadet_gen()"
SIGNALS: Final = {"SIGINT to the group": 130, "SIGTERM to the command": 143, "kill -9 of the command": -9}
"""The exit code that each leads to."""
WORKER: Final = "kill -9 of a worker"
FULL: Final = "full disk"
FAILED: Final = 2
POLL_S: Final = 0.05


class Run:
    """A `cadet-gen` in a group of processes of its own."""

    def __init__(self, out: Path, arguments: list[str]) -> None:
        # Not on the disk that gets filled.
        self.log = Path(tempfile.gettempdir()) / f"cadet-failures-{os.getpid()}.log"
        with self.log.open("w") as log:
            self.process = subprocess.Popen(
                [sys.executable, "-c", RUN, str(out), *arguments],
                stdout=log,
                stderr=log,
                start_new_session=True,
                preexec_fn=lambda: signal.signal(signal.SIGINT, signal.default_int_handler),
            )
        self.peak_bytes = 0

    def is_over(self, after_s: float) -> bool:
        """Wait so long at most, watching the workers' memory; tell whether the run has ended."""
        end_s = time.monotonic() + after_s
        while self.process.poll() is None and time.monotonic() < end_s:
            for pid in workers_of(self.process.pid):
                with contextlib.suppress(FileNotFoundError, ProcessLookupError):
                    status = Path(f"/proc/{pid}/status").read_text()
                    peak = [line.split()[1] for line in status.splitlines() if line.startswith("VmHWM")]
                    self.peak_bytes = max(self.peak_bytes, 1024 * int(peak[0]) if peak else 0)
            time.sleep(POLL_S)
        return self.process.poll() is not None

    def end(self) -> int:
        """Wait for the end of the command and of its workers; return the exit code."""
        self.is_over(float("inf"))
        code = self.process.wait()
        while _is_group_alive(self.process.pid):
            time.sleep(POLL_S)
        return code


def _is_group_alive(group: int) -> bool:
    try:
        os.killpg(group, 0)
    except ProcessLookupError:
        return False
    return True


def hashes(root: Path) -> dict[str, str]:
    """Return the hash of each file below a folder, but of what lies aside."""
    files = (path for path in root.rglob("*") if path.is_file() and ".partial" not in path.parts)
    return {str(path.relative_to(root)): sha256(path.read_bytes()).hexdigest() for path in files}


def check(out: Path, wanted: dict[str, str], what: str) -> int:
    """Return how many files are there; end the script if one of them is not the undisturbed set's."""
    found = hashes(out)
    wrong = [name for name, digest in found.items() if wanted.get(name) != digest]
    if wrong:
        sys.exit(f"after {what}: {len(wrong)} files differ, such as {wrong[0]}")
    return len(found)


def fill(folder: Path) -> Path:
    """Leave no room on a folder's disk."""
    filler = folder / "filler"
    with filler.open("wb", buffering=0) as file, contextlib.suppress(OSError):
        while True:
            try:
                file.write(bytes(2**20))
            except OSError as error:
                if error.errno != errno.ENOSPC:
                    raise
                file.write(bytes(1))
    return filler


def disturb(run: Run, what: str, draws: random.Random, folder: Path) -> int | None:
    """Let a failure happen.

    Returns:
        The exit code that it must lead to; None if the run goes on.
    """
    if what == WORKER:
        workers = workers_of(run.process.pid)
        if workers:
            with contextlib.suppress(ProcessLookupError):
                os.kill(draws.choice(workers), signal.SIGKILL)
        return None
    if what == FULL:
        filler = fill(folder)
        try:
            run.end()
        finally:
            filler.unlink()
        return FAILED
    with contextlib.suppress(ProcessLookupError):
        if what == "SIGINT to the group":
            os.killpg(run.process.pid, signal.SIGINT)
        else:
            run.process.send_signal(signal.SIGKILL if "kill" in what else signal.SIGTERM)
    return SIGNALS[what]


def main() -> None:
    """Write both sets and compare them."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("folder", type=Path, metavar="DIR")
    parser.add_argument("-n", dest="num_frames", type=int, default=2000)
    parser.add_argument("--workers", type=int, default=2)
    parser.add_argument("--failures", type=int, default=20)
    parser.add_argument("--seed", type=int, default=0, help="of kinds and times of failures, and of the set")
    parser.add_argument("--fill", action="store_true", help="fill the disk of DIR, too")
    at = sys.argv.index("--") if "--" in sys.argv else len(sys.argv)
    options = parser.parse_args(sys.argv[1:at])
    common = [f"-n{options.num_frames}", f"--workers={options.workers}", f"--seed={options.seed}", *sys.argv[at + 1 :]]
    options.folder.mkdir(parents=True, exist_ok=True)
    whole, disturbed = options.folder / "whole", options.folder / "disturbed"
    start_s = time.monotonic()
    first = Run(whole, common)
    if first.end() != 0:
        sys.exit(first.log.read_text())
    seconds = time.monotonic() - start_s
    wanted = hashes(whole)
    shutil.rmtree(whole)
    rate = options.num_frames / seconds
    print(f"undisturbed: {len(wanted)} files, {seconds:.1f} s, {rate:.1f} samples a second", end=", ")
    print(f"a worker's memory up to {first.peak_bytes / 1e6:.0f} MB")
    draws = random.Random(options.seed)
    kinds = [*SIGNALS, WORKER, *([FULL] if options.fill else [])]
    left = [kinds[index % len(kinds)] for index in range(options.failures)]
    draws.shuffle(left)
    num_resumed = 0
    run = Run(disturbed, common)
    while True:
        if not left or run.is_over(draws.uniform(0.5, max(2.0, 2.0 * seconds / options.failures))):
            code = run.end()
            check(disturbed, wanted, "the end")
            if code == 0:
                break
            # Two workers were killed in one episode: the run names it.
            if code != FAILED or "as the one before it did" not in run.log.read_text():
                sys.exit(f"exit code {code}: {run.log.read_text()}")
        else:
            what = left.pop()
            expected = disturb(run, what, draws, options.folder)
            if expected is None:
                print(f"{what}: the run goes on", flush=True)
                continue
            code = run.end()
            # A command that is still starting, or at its end, has other codes.
            if code not in (expected, 0) and not (code < 0 and expected > 128):
                sys.exit(f"after {what}: exit code {code}, expected {expected}: {run.log.read_text()}")
            num_files = check(disturbed, wanted, what)
            print(f"{what}: exit code {code}, {num_files} of {len(wanted)} files, all whole", flush=True)
        num_resumed += 1
        # Who was killed before its beginning was written has left no run to go on with.
        is_begun = (disturbed / "run.json").exists()
        run = Run(disturbed, [*common, *(["--resume"] if is_begun else [])])
    missing = set(wanted) - set(hashes(disturbed))
    if missing:
        sys.exit(f"{len(missing)} files are missing")
    print(f"{options.failures - len(left)} failures, {num_resumed} times resumed", end="; ")
    print(f"{len(wanted)} files, all with the undisturbed set's hashes")


if __name__ == "__main__":
    main()
