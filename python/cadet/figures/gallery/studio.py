"""One actor alone on an empty street, photographed."""

from __future__ import annotations

import math
from collections.abc import Iterable, Iterator
from dataclasses import dataclass
from typing import Final

import numpy as np
from numpy.typing import NDArray

from cadet._util import style
from cadet.errors import CadetError
from cadet.sensors.camera import Camera
from cadet.sensors.extrinsics import Extrinsics
from cadet.sensors.rig import Rig
from cadet.simulation.scene import Scene

# A focal length as a portrait has it: little perspective, and more pixels on an actor than the finest level needs.
_CAMERA: Final = Camera(width=1920, height=1080, fx=2400.0, fy=2400.0, cx=959.5, cy=539.5)
_STUDIO: Final = Rig(
    name="studio",
    camera=_CAMERA,
    extrinsics=Extrinsics.aligned(),
    velo_in_ego_m=(0.0, 0.0, 1.6),
    velo_roll_pitch_yaw_deg=(0.0, 0.0, 0.0),
)
# Half of the image's width stays free, so that the longest actor fits at any yaw.
_SPAN: Final = 0.5 * _CAMERA.width / _CAMERA.fx
# Near enough for a face, far enough for feet.
_LEAST_DISTANCE_M: Final = 7.8
_SURVEY_STEP_M: Final = 40.0
_MARGIN: Final = 0.08
# The camera meters the whole image, the sky too; a portrait is exposed for its actor: its mean, and the most gain.
_ACTOR_LUMA: Final = 85.0
_MOST_GAIN: Final = 3.0
# From ahead and the left, from behind and the right, from the side, and from ahead and the right.
_YAWS_DEG: Final = (145.0, -35.0, 90.0, -145.0)


@dataclass(frozen=True)
class Sitter:
    """An actor that is photographed: what `Scene.add` takes, and what it made of it."""

    kind: str
    """As `Scene.add` takes it."""
    model_seed: int
    """As `Scene.add` takes it."""
    family: str
    """The part of the model's name that many seeds share."""
    length_m: float
    """Of its box."""


def survey(kind: str, seeds: Iterable[int]) -> Iterator[Sitter]:
    """Say what `Scene.add` makes of a kind and each of the seeds."""
    for seed in seeds:
        scene = Scene.empty(rig=_STUDIO)
        actor_id = scene.add(kind, x_m=_SURVEY_STEP_M, y_m=0.0, yaw_rad=0.0, model_seed=seed)
        agent = next(agent for agent in scene.capture(sensors=()).agents if agent.id == actor_id)
        yield Sitter(kind, seed, agent.model.split("/")[0], agent.size_lwh[0])


def portrait(sitter: Sitter, number: int = 0, *, speed_mps: float | None = None) -> style.Image:
    """Photograph an actor alone at noon, cut out to its outline with some room around it.

    Args:
        sitter: the actor.
        number: chooses the side that it shows, by turns.
        speed_mps: how fast it goes; None for one that stands.

    Returns:
        (H, W, 3) uint8 RGB.

    Raises:
        CadetError: an unknown kind, or an actor of which no pixel shows.
    """
    distance_m = max(sitter.length_m / _SPAN, _LEAST_DISTANCE_M)
    yaw = math.radians(_YAWS_DEG[number % len(_YAWS_DEG)])
    scene = Scene.empty(rig=_STUDIO)
    # Looking west, away from the sun.
    scene.move_ego(x_m=0.0, y_m=0.0, yaw_rad=math.pi)
    actor_id = scene.add(
        sitter.kind, x_m=-distance_m, y_m=0.0, yaw_rad=yaw + math.pi, model_seed=sitter.model_seed, speed_mps=speed_mps
    )
    frame = scene.capture(sensors=())
    if frame.instance is None or not (is_sitter := np.asarray(frame.instance == actor_id)).any():
        raise CadetError(f"{sitter.kind} {sitter.model_seed}: not seen from {distance_m:.0f} m")
    rows, columns = np.nonzero(is_sitter)
    room = round(_MARGIN * max(np.ptp(rows), np.ptp(columns))) + 1
    top, bottom = max(rows.min() - room, 0), rows.max() + room + 1
    left, right = max(columns.min() - room, 0), columns.max() + room + 1
    return _exposed_for(frame.image[top:bottom, left:right], is_sitter[top:bottom, left:right])


def _exposed_for(image: style.Image, is_actor: NDArray[np.bool_]) -> style.Image:
    """Lift an image until the actor's pixels have the mean wanted; values are proportional to light."""
    gain = min(max(_ACTOR_LUMA / max(float(image[is_actor].mean()), 1.0), 1.0), _MOST_GAIN)
    exposed: style.Image = np.minimum(image * gain, 255.0).astype(np.uint8)
    return exposed
