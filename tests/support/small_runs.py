"""`cadet-gen` on worlds that are quick to make: a straight road, small images and scans, four samples an episode.

`CADET_FAULT` makes a run misbehave where its worlds are drawn: "die=E", "panic=E" and "object=E" in episode E, "slow=S"
seconds before each world, "empty" for worlds whose objects get no label, "stand=E" for frames that count as taken at a
standstill in the episodes before E, "readonly" for a folder in which nothing can be written.
"""

from __future__ import annotations

import errno
import os
import signal
import time
from collections.abc import Sequence
from dataclasses import fields, replace
from pathlib import Path
from typing import Any, NoReturn

from cadet import CadetError, District, LabelConfig, Lidar, ResetPolicy, RoadMap
from cadet._util.sink import LocalSink
from cadet.cli import run_cadet_gen
from cadet.generate import Settings
from cadet.generate.engines import worker
from cadet.generate.engines.engine import Made
from cadet.generate.folder import open_folder
from cadet.generate.manifest import put_manifest
from cadet.worlds.policy import EpisodeSpec
from fuzz.road_text import map_of, road

FAULTS = dict(part.partition("=")[::2] for part in os.environ.get("CADET_FAULT", "").split(",") if part)
NUM_SAMPLES = 4
"""Samples of an episode."""
ROAD = RoadMap("straight.xodr", map_of(road(0, length_m=200.0)))
STREET = District(name="street", parking_occupancy=(0.2, 0.5), num_cars=(4, 6), num_pedestrians=(4, 6))
KITTI = ResetPolicy.kitti()


class Panic(BaseException):
    """What a panic of the core looks like from Python."""


class SmallPolicy(ResetPolicy):
    """A policy that misbehaves as `CADET_FAULT` says, in whatever process it draws."""

    def draw(self, seed: int, episode: int, attempt: int = 0) -> EpisodeSpec:
        time.sleep(float(FAULTS.get("slow", 0)))
        if FAULTS.get("die") == str(episode):
            os.kill(os.getpid(), signal.SIGKILL)
        if FAULTS.get("panic") == str(episode):
            raise Panic("index out of bounds:\n the len is 3")
        if FAULTS.get("object") == str(episode):
            raise CadetError("scene: no ground ahead of the camera")
        spec = super().draw(seed, episode, attempt)
        if "empty" not in FAULTS:
            return spec
        return replace(spec, config=replace(spec.config, label=LabelConfig(min_points=10**6)))


def small_policy() -> ResetPolicy:
    """Return KITTI's policy on a straight road, with few rays and samples."""
    lidar = Lidar.vlp16()
    quick = replace(KITTI, maps=(ROAD,), samples_per_episode=NUM_SAMPLES, attempts_limit=6)
    quick = quick.with_weathers("clear_noon").with_districts(STREET).with_each_rig(lambda rig: rig.with_lidar(lidar))
    return SmallPolicy(**{f.name: getattr(quick, f.name) for f in fields(quick)})


def small_settings(num_frames: int, **others: Any) -> Settings:
    """Return what `cadet-gen -n NUM_FRAMES --seed 3 --image-size 64x32` asks for."""
    policy = small_policy().with_each_rig(lambda rig: rig.with_image_size(64, 32))
    return Settings(policy=policy, seed=3, num_frames=num_frames, **others)


def make(root: Path, num_frames: int, *, episodes: Sequence[int] | None = None, **others: Any) -> list[Made]:
    """Do what `cadet-gen` does with `small_settings`, in this process; also go on with what is there.

    Args:
        root: the dataset's folder.
        num_frames: all frames, those that are there too.
        episodes: their order; as they come if None.
        others: of `Settings`, besides.

    Returns:
        Each frame, and whether it is new.
    """
    made: list[Made] = []
    settings = small_settings(num_frames, **others)
    with open_folder(root, settings, resume=root.exists()) as sink:
        for episode in episodes or range(settings.num_episodes):
            worker.make_episode(sink, settings, episode, made.append)
        put_manifest(sink, settings, sum(frame.is_standing for frame in made))
    return made


def _refuse(self: LocalSink, name: str, data: object) -> NoReturn:
    raise OSError(errno.EROFS, os.strerror(errno.EROFS), str(self.root / name))


if "readonly" in FAULTS:
    LocalSink.put = _refuse  # type: ignore[method-assign]
if "stand" in FAULTS:
    worker._is_standing = lambda record: record["episode"] < int(FAULTS["stand"])


def main() -> None:
    """Be `cadet-gen`, which draws from the small policy where KITTI's is asked for."""
    ResetPolicy.kitti = staticmethod(small_policy)  # type: ignore[method-assign]
    run_cadet_gen()
