"""Memory over a long stream of frames: of the process that takes them and of the workers that make them.

    python benches/stream_memory.py town.toml -n 5000 --workers 2

prints, every so many frames, the rate since the beginning and the resident megabytes. A worker's grow while designs of
vehicles and people are made for the first time, then stay; the taker's stay.
"""

from __future__ import annotations

import argparse
import itertools
import os
import time
from pathlib import Path

from worker_processes import workers_of

from cadet.simulation.simulation import Simulation


def resident_mb(pid: int) -> float:
    """Return the resident memory of a process in megabytes."""
    pages = int(Path(f"/proc/{pid}/statm").read_text().split()[1])
    return pages * os.sysconf("SC_PAGE_SIZE") / 1e6


def main() -> None:
    """Take the frames and print a row now and then."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("simulation", type=Path, help="a simulation's TOML file")
    parser.add_argument("-n", dest="count", type=int, default=5000)
    parser.add_argument("--workers", type=int, default=2)
    parser.add_argument("--every", type=int, default=500)
    options = parser.parse_args()
    begun_s = time.monotonic()
    print("frames   a second   taker, MB   workers, MB")
    with Simulation.read(options.simulation).stream(workers=options.workers) as frames:
        for number, _ in enumerate(itertools.islice(frames, options.count), 1):
            if number % options.every == 0:
                rate = number / (time.monotonic() - begun_s)
                workers = ", ".join(f"{resident_mb(pid):.0f}" for pid in workers_of(os.getpid()))
                print(f"{number:6}   {rate:8.1f}   {resident_mb(os.getpid()):9.0f}   {workers}", flush=True)


if __name__ == "__main__":
    main()
