"""Where the time of a written sample goes: `python benches/sample_parts.py [-n 200] [--seed 0] [--write LIST]`.

Makes the samples of `cadet-gen -n N --workers 1` in this process, and prints milliseconds of processor time a sample,
with all threads' time: the core is told to use one.

* World: drawn, built, and settled; one serves an episode, if it shows labeled objects.
* Driving: between two views.
* Views passed over: without a labeled object, or without motion since the view before.
* Capture: image, scan, labels, and what was asked for besides.
* Scan: once more by itself, in no other row than this.
* Writing: encoding, hashes, and files; the image's PNG is encoded here.
"""

from __future__ import annotations

import argparse
import os
import time
from collections.abc import Callable
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import TypeVar

os.environ["RAYON_NUM_THREADS"] = "1"

import cadet
from cadet.episode import build_scene, request
from cadet.generate import Settings
from cadet.generate.frames import put_sample
from cadet.sample import Sample
from cadet.sink import LocalSink

T = TypeVar("T")


class Clock:
    """Processor time by part."""

    def __init__(self) -> None:
        self.seconds: dict[str, float] = {}

    def time(self, part: str, work: Callable[[], T]) -> T:
        """Do some work for a part."""
        start = time.process_time()
        done = work()
        self.seconds[part] = self.seconds.get(part, 0.0) + time.process_time() - start
        return done


def make_episode(settings: Settings, episode: int, sink: LocalSink, clock: Clock) -> None:
    """Write an episode as `cadet.episode.Episode` takes its views."""
    policy, wanted = settings.policy, settings.exporter.wanted(settings.extras)
    places = settings.places_of(episode)
    number, attempt = 0, 0
    while number < len(places):
        spec = policy.draw(settings.seed, episode, attempt)
        scene = clock.time("world", lambda spec=spec: build_scene(spec))
        num_empty, is_first = 0, True
        while number < len(places) and num_empty < policy.empty_views_limit:
            if not is_first:
                clock.time("driving", lambda scene=scene: scene.drive(policy.distance_m, policy.blocked_s))
            is_first = False
            wants = request(spec.mounted_rig, number, wanted)
            start = time.process_time()
            captured = scene.capture_labeled(wants)
            part = "views passed over" if captured is None else "capture"
            clock.seconds[part] = clock.seconds.get(part, 0.0) + time.process_time() - start
            if captured is None:
                num_empty += 1
                continue
            num_empty = 0
            clock.time("scan", lambda scene=scene, number=number: scene.scan(None, False, number))
            origin = {"seed": settings.seed, "episode": episode, "sample": number, "attempt": attempt}
            sample = Sample(captured, spec.mounted_rig, {**origin, "policy": policy.name, "district": spec.district})
            clock.time("writing", lambda sample=sample, place=places[number]: put_sample(sink, settings, place, sample))
            number += 1
        attempt += 1


def main() -> None:
    """Print the table."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("-n", type=int, default=200)
    parser.add_argument("--seed", type=int, default=0)
    parser.add_argument("--write", default="")
    options = parser.parse_args()
    extras = tuple(options.write.split(",")) if options.write else ()
    settings = Settings(
        seed=options.seed, num_frames=options.n, policy=cadet.ResetPolicy.kitti(), format="kitti", extras=extras
    )
    clock = Clock()
    with TemporaryDirectory() as folder:
        sink = LocalSink(Path(folder))
        for episode in range(-(-options.n // settings.policy.samples_per_episode)):
            make_episode(settings, episode, sink, clock)
    for part, seconds in clock.seconds.items():
        print(f"{part:<20}{1000 * seconds / options.n:8.1f}")
    print(f"{'sum without scan':<20}{1000 * (sum(clock.seconds.values()) - clock.seconds['scan']) / options.n:8.1f}")


if __name__ == "__main__":
    main()
