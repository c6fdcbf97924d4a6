"""Where the time of a written sample goes: `python benches/sample_parts.py [-n 200] [--seed 0] [--write LIST]`.

Makes the samples of `cadet-gen -n N --workers 1` in this process, and prints milliseconds of processor time a sample.

* World: drawn, built, and settled; one serves an episode, if it shows labeled objects.
* Driving: between two views.
* Capture: image, scan, labels, and what was asked for besides; views that are passed over too.
* Scan: taken once more by itself, and not in the sum.
* Writing: encoding, hashes, and files; the image's PNG is encoded here.
"""

from __future__ import annotations

import argparse
import contextlib
import os
import time
from collections.abc import Iterator
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import Final

os.environ["RAYON_NUM_THREADS"] = "1"

import cadet
from cadet._util.sink import LocalSink
from cadet.generate import Settings
from cadet.generate.frames import put_sample
from cadet.sensors.sample import Sample
from cadet.simulation.episode import build_scene, request

SCAN: Final = "of these the scan"
PARTS: Final = ("world", "driving", "capture", SCAN, "writing")


class Clock:
    """Processor time by part."""

    def __init__(self) -> None:
        self.seconds = dict.fromkeys(PARTS, 0.0)

    @contextlib.contextmanager
    def part(self, name: str) -> Iterator[None]:
        """Count what is done meanwhile to a part."""
        start = time.process_time()
        yield
        self.seconds[name] += time.process_time() - start


def make_episode(settings: Settings, episode: int, sink: LocalSink, clock: Clock) -> None:
    """Write an episode as `cadet.simulation.episode.Episode` takes its views."""
    policy, wanted = settings.policy, settings.wanted
    places = settings.places_of(episode)
    number, attempt = 0, 0
    while number < len(places):
        spec = policy.draw(settings.seed, episode, attempt)
        with clock.part("world"):
            scene = build_scene(spec)
        num_empty, is_first = 0, True
        while number < len(places) and num_empty < policy.empty_views_limit:
            if not is_first:
                with clock.part("driving"):
                    scene.drive(policy.distance_m, policy.blocked_s)
            is_first = False
            with clock.part("capture"):
                captured = scene.capture_labeled(request(spec.mounted_rig, number, wanted))
            if captured is None:
                num_empty += 1
                continue
            num_empty = 0
            with clock.part(SCAN):
                scene.scan(None, ideal=False, surfaces=False, sample=number)
            origin = {"seed": settings.seed, "episode": episode, "sample": number, "attempt": attempt}
            sample = Sample(captured, spec.mounted_rig, {**origin, "policy": policy.name, "district": spec.district})
            with clock.part("writing"):
                put_sample(sink, settings, places[number], sample)
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
        seed=options.seed, num_frames=options.n, policy=cadet.ResetPolicy.kitti(), format="kitti", write=extras
    )
    clock, start = Clock(), time.process_time()
    with TemporaryDirectory() as folder:
        sink = LocalSink(Path(folder))
        for episode in range(-(-options.n // settings.policy.samples_per_episode)):
            make_episode(settings, episode, sink, clock)
    total = sum(clock.seconds.values()) - clock.seconds[SCAN]
    whole = time.process_time() - start - clock.seconds[SCAN]
    for part, seconds in [*clock.seconds.items(), ("sum", total), ("whole", whole)]:
        print(f"{part:<20}{1000 * seconds / options.n:8.1f}")


if __name__ == "__main__":
    main()
