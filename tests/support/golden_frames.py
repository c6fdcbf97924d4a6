"""Frames whose bytes are held, one for each policy and rig of `cadet-gen` and one in the rain.

    make golden                               # prints what differs and rewrites tests/support/golden_frames.json
    python tests/support/golden_frames.py             # prints the digests

A digest that changes is a change of every dataset: renew them once for a change that is meant, and say so in
CHANGELOG.md.
"""

from __future__ import annotations

import hashlib
import json
import sys
from dataclasses import dataclass, replace
from pathlib import Path

import numpy as np

import cadet

FILE = Path(__file__).with_suffix(".json")


@dataclass(frozen=True)
class Case:
    """The first frame of seed 0."""

    policy: str = "kitti"
    rig: str = "kitti"
    weather: str | None = None
    """Drawn by the policy if None."""
    image_size: tuple[int, int] | None = None
    """Of every camera; the rig's own if None."""

    def capture(self) -> cadet.Frame:
        """Make the frame, with all its maps."""
        policy, rig = getattr(cadet.ResetPolicy, self.policy)(), getattr(cadet.Rig, self.rig)()
        if self.image_size is not None:
            rig = _resized(rig, self.image_size)
        return cadet.Scene.random(seed=0, policy=policy, rig=rig, weather=self.weather).capture()


CASES = {
    "kitti": Case(),
    "paper": Case(policy="paper", rig="paper"),
    "cadet": Case(rig="cadet"),
    "rain": Case(weather="hard_rain_noon"),
    # Six cameras: small ones, since an emulated processor makes them too.
    "nuscenes": Case(rig="nuscenes", weather="clear_noon", image_size=(320, 180)),
}


def _resized(rig: cadet.Rig, size: tuple[int, int]) -> cadet.Rig:
    more = tuple(
        replace(one, camera=one.camera.resized(*size)) if isinstance(one, cadet.MountedCamera) else one
        for one in rig.more
    )
    return replace(rig, camera=rig.camera.resized(*size), more=more)


def digest(frame: cadet.Frame) -> str:
    """Hash all that a frame holds."""
    found = hashlib.sha256()
    maps = (frame.depth, frame.instance, frame.semantic)
    others = [image for name, image in frame.images.items() if name != next(iter(frame.images))]
    for part in (frame.image, frame.points_velo, frame.plane, *maps, *others):
        assert part is not None
        found.update(f"{part.dtype} {part.shape}".encode())
        found.update(np.ascontiguousarray(part).tobytes())
    texts = [frame.calib.to_text(), *(label.to_line() for label in frame.labels)]
    texts.append(json.dumps(frame.meta, sort_keys=True))
    found.update("\n".join(texts).encode())
    return found.hexdigest()


def digests() -> dict[str, str]:
    """Make and hash the frame of every case."""
    return {name: digest(case.capture()) for name, case in CASES.items()}


def stored() -> dict[str, str]:
    """Return the digests that are held."""
    held: dict[str, str] = json.loads(FILE.read_text())
    return held


def _renew() -> None:
    before = stored() if FILE.is_file() else {}
    after = digests()
    for name in sorted({*before, *after}):
        if before.get(name) != after.get(name):
            sys.stdout.write(f"{name}: {before.get(name)} -> {after.get(name)}\n")
    FILE.write_text(json.dumps(after, indent=2) + "\n")
    sys.stdout.write(f"wrote {FILE.name}: {sum(before.get(n) != d for n, d in after.items())} changed\n")


if __name__ == "__main__":
    if sys.argv[1:] == ["--write"]:
        _renew()
    elif not sys.argv[1:]:
        sys.stdout.write(json.dumps(digests(), indent=2) + "\n")
    else:
        sys.exit("expected --write or nothing")
