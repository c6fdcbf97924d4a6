"""Frames whose bytes are promised on Linux and x86-64: of each policy and rig, in the rain, in a crowd, of a fisheye.

`make golden` renews `golden_frames.json`, which holds their hashes.
"""

from __future__ import annotations

import json
from dataclasses import dataclass, replace
from functools import lru_cache
from hashlib import sha256
from pathlib import Path
from typing import Final

import numpy as np

from cadet.formats.kitti import Frame
from cadet.sensors.camera import Camera
from cadet.sensors.lidar import Lidar
from cadet.sensors.mounted import MountedCamera
from cadet.sensors.pose import Pose
from cadet.sensors.rig import Rig
from cadet.simulation.scene import Scene
from cadet.worlds.config import SceneConfig
from cadet.worlds.policy import ResetPolicy

FILE: Final = Path(__file__).with_suffix(".json")
_DIGITS: Final = 12


@dataclass(frozen=True)
class Case:
    """A frame of seed 0."""

    policy: str = "kitti"
    rig: str = "kitti"
    weather: str | None = None
    """Drawn by the policy if None."""
    image_size: tuple[int, int] | None = None
    """Of every camera; the rig's own if None."""
    lidar: str | None = None
    """In place of the rig's first one."""
    more: tuple[MountedCamera, ...] = ()
    """Cameras beside the rig's."""
    config: SceneConfig | None = None
    """How full the scene is; drawn by the policy if None."""
    after_s: float = 0.0
    """Seconds of driving before it."""

    def capture(self) -> Frame:
        """Make the frame, with all its maps."""
        rig = Rig.named(self.rig)
        if self.image_size is not None:
            rig = _resized(rig, self.image_size)
        if self.lidar is not None:
            rig = replace(rig, lidar=Lidar.named(self.lidar))
        rig = rig.with_sensors(*self.more)
        policy = ResetPolicy.named(self.policy)
        scene = Scene.random(seed=0, policy=policy, rig=rig, weather=self.weather, config=self.config)
        if self.after_s:
            scene.step(self.after_s)
        return scene.capture()


_POSE: Final = Pose.of_camera((0.5, 0.9, 1.1), yaw_deg=70.0, pitch_deg=15.0)
_FISHEYE: Final = MountedCamera(name="fisheye", camera=Camera.fisheye(160, 160), pose=_POSE)

CASES: Final = {
    "kitti": Case(),
    "paper": Case(policy="paper", rig="paper"),
    "cadet": Case(rig="cadet"),
    "rain": Case(weather="hard_rain_noon"),
    # Six cameras: small ones, since an emulated processor makes them too.
    "nuscenes": Case(rig="nuscenes", weather="clear_noon", image_size=(320, 180)),
    # Where everybody's way has hung on everybody else's for a while.
    "crowd": Case(
        weather="clear_noon",
        image_size=(320, 96),
        lidar="vlp16",
        config=SceneConfig(num_cars=25, num_pedestrians=80, num_cyclists=6),
        after_s=6.0,
    ),
    "fisheye": Case(weather="clear_noon", image_size=(320, 96), lidar="vlp16", more=(_FISHEYE,)),
}


def _resized(rig: Rig, size: tuple[int, int]) -> Rig:
    more = tuple(
        replace(one, camera=one.camera.resized(*size)) if isinstance(one, MountedCamera) else one for one in rig.more
    )
    return replace(rig, camera=rig.camera.resized(*size), more=more)


def digest(frame: Frame) -> str:
    """Hash all that a frame holds."""
    found = sha256()
    maps = (frame.depth, frame.instance, frame.semantic)
    others = [*frame.images][1:]
    for part in (frame.image, frame.points_velo, frame.plane, *maps, *(frame.images[name] for name in others)):
        assert part is not None
        found.update(f"{part.dtype} {part.shape}".encode())
        found.update(np.ascontiguousarray(part).tobytes())
    labels = [*frame.labels, *(label for name in others for label in frame.camera_labels[name])]
    texts = [frame.calib.to_text(), *(label.to_line() for label in labels)]
    texts.append(json.dumps(frame.meta, sort_keys=True))
    found.update("\n".join(texts).encode())
    return found.hexdigest()


def stored() -> dict[str, str]:
    """Return the hashes that are promised."""
    held: dict[str, str] = json.loads(FILE.read_text(encoding="utf-8"))
    return held


@lru_cache(maxsize=1)
def generator() -> str:
    """Name what frames this build makes of a seed: twelve digits, others for a build whose golden frames are others."""
    return sha256(json.dumps(stored(), sort_keys=True).encode("utf-8")).hexdigest()[:_DIGITS]
