"""The parts of a sample, of an image, and of a scan, as the pages of `docs/` have them: `make bench-tables`.

A sample's parts are timed one after the other (`sample_parts.py`). An image's and a scan's are shares of a profile
(Linux's `perf`) of one thread in suburbs 0 to 3, by the module of the core that runs; what the compiler puts into
another module counts as that one's. A table's rows add up to its whole.
"""

from __future__ import annotations

import argparse
import collections
import os
import re
import signal
import subprocess
import sys
import time
from collections.abc import Callable, Sequence
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import Final

os.environ["RAYON_NUM_THREADS"] = "1"

import cadet

REST: Final = "the rest: memory, Python"
IMAGE: Final = {
    "visibility": ("visibility_pass", "sense"),
    "binning": ("fragment_binning", "coverage", "face_cache", "face", "shading_queue"),
    "shadow maps and lookup": ("shadow",),
    "sky probes": ("sky_visibility",),
    "ambient terms": ("ambient_cache", "gather"),
    "contact occlusion": ("contact_occlusion",),
    "shading": ("deferred_shading", "shading_pass", "textures", "value_noise", "windows", "surface_cover", "light"),
    "sky": ("sky", "sky_rows"),
    "distortion, color filters, noise": ("distortion", "mosaic", "noise", "development"),
    "depth, instances, classes": ("maps", "surface_maps"),
    "labels, but for outlines": ("label", "samples_of_actor"),
    "the scan of a few beams for them": ("lidar", "beams"),
    "the rest of the camera": ("camera", "night_lights", "block_sums"),
}
SCAN: Final = {
    "visibility": ("sense",),
    "reflection, echoes, returns": (
        "reflection",
        "echo",
        "echo_batch",
        "intensity",
        "receiver",
        "laser_receiver",
        "ring_receiver",
        "arrivals",
    ),
    "halos": ("blooming",),
    "the rest of the LIDAR": ("lidar",),
}
"""Modules and functions of the core by part; the innermost that any part names decides."""

_LINE: Final = re.compile(r"^\s*([\d.]+)%\s+(.*\S)")


def main() -> None:
    """Print the tables."""
    parser = argparse.ArgumentParser(description="Print the parts of a sample, of an image, and of a scan.")
    parser.add_argument("-n", type=int, default=200, help="samples that are timed")
    parser.add_argument("--rounds", type=int, default=60, help="images and scans of each suburb")
    args = parser.parse_args()
    print("A sample, ms of processor time", flush=True)
    script = Path(__file__).with_name("sample_parts.py")
    subprocess.run([sys.executable, script, "-n", str(args.n)], check=True)
    # A frame needs some points for its labels.
    rings = tuple(cadet.Laser(elevation_deg=-0.5 * ring) for ring in range(16))
    few_beams = cadet.BeamTable(name="few_beams", rings=rings, firing=cadet.UniformFiring(columns=200))
    few = cadet.Rig(lidar=cadet.Lidar.custom(few_beams))
    scenes = {rig: [cadet.Scene.random(seed=seed, rig=rig) for seed in range(4)] for rig in (None, few)}
    images: list[Callable[[], object]] = [scene.capture for scene in scenes[few]]
    scans: list[Callable[[], object]] = [scene.scan for scene in scenes[None]]
    for name, calls, parts in (("An image with its labels", images, IMAGE), ("A scan", scans, SCAN)):
        moved = [scene.step for scene in scenes[few if parts is IMAGE else None]]
        whole_ms, shares = profiled(calls, moved, args.rounds)
        print(f"\n{name}, ms of processor time")
        print_table(whole_ms, by_part(shares, parts))


def profiled(
    calls: Sequence[Callable[[], object]], moves: Sequence[Callable[[float], object]], rounds: int
) -> tuple[float, dict[str, float]]:
    """Time and profile calls by turns; milliseconds of one, and the share of each function."""
    with TemporaryDirectory() as folder:
        data = f"{folder}/perf.data"
        command = ["perf", "record", "-q", "-F", "999", "-p", str(os.getpid()), "-o", data]
        with subprocess.Popen(command) as perf:
            time.sleep(1.0)  # until it looks
            start = time.process_time()
            for _ in range(rounds):
                for move, call in zip(moves, calls, strict=True):
                    move(0.0)  # no time passes, but what was posed is forgotten
                    call()
            seconds = time.process_time() - start
            perf.send_signal(signal.SIGINT)
        report = ["perf", "report", "-i", data, "--stdio", "-F", "overhead,symbol", "--percent-limit", "0"]
        text = subprocess.run(report, check=True, capture_output=True, text=True).stdout
    found = (_LINE.match(line) for line in text.splitlines())
    shares: dict[str, float] = collections.defaultdict(float)
    for match in found:
        if match is not None:
            shares[match[2]] += float(match[1]) / 100.0
    return 1e3 * seconds / (rounds * len(calls)), shares


def by_part(shares: dict[str, float], parts: dict[str, tuple[str, ...]]) -> dict[str, float]:
    """Add up the shares of functions by the part of their module."""
    part_of = {module: part for part, modules in parts.items() for module in modules}
    sums = dict.fromkeys([*parts, REST], 0.0)
    for function, share in shares.items():
        modules = re.findall(r"\w+", function) if "cadet_sensors" in function else []
        sums[next((part_of[name] for name in reversed(modules) if name in part_of), REST)] += share
    return sums


def print_table(whole_ms: float, shares: dict[str, float]) -> None:
    """Print each part's milliseconds and percent, and the whole."""
    for part, share in [*shares.items(), ("sum", sum(shares.values()))]:
        print(f"{part:<34}{whole_ms * share:7.2f}{100 * share:6.1f} %")
    print(f"{'whole':<34}{whole_ms:7.2f}")


if __name__ == "__main__":
    main()
