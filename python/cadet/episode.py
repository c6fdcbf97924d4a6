"""One reset and its samples: draws the world, drives, and looks until something labelled is in view."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import numpy as np
from numpy.typing import NDArray

from cadet import _cadet
from cadet.errors import CadetError
from cadet.frame import Frame
from cadet.kitti import Calibration, Label
from cadet.kitti.calib import is_at_zero_depth
from cadet.notices import notice
from cadet.policy import EpisodeSpec, ResetPolicy


def build_scene(spec: EpisodeSpec) -> _cadet.Scene:
    """Build the core's scene of a draw, settled and ready to sense.

    Raises:
        CadetError: a map that can't be read or driven.
    """
    scene = _cadet.Scene.random(
        spec.seed,
        spec.episode,
        spec.attempt,
        map_name=None if spec.road_map is None else spec.road_map.name,
        map_xodr=None if spec.road_map is None else spec.road_map.xodr,
        weather=spec.weather,
        rig=spec.rig.pitched(spec.car_pitch_deg).to_native(),
        config=spec.config.to_native(spec.rig.camera.image_scale),
        assets=None if spec.assets is None else spec.assets.to_native(),
    )
    if spec.road_map is not None:
        notice(scene.map_warnings(), about=spec.road_map)
    return scene


def frame_from_native(captured: dict[str, Any], extra_meta: dict[str, Any]) -> Frame:
    """Make a frame of what the core captured, its metadata led by `extra_meta`."""
    calib = Calibration(**captured["calib"])
    return Frame(
        image=captured["image"],
        points_velo=move_off_zero_depth(captured["points_velo"], calib),
        labels=tuple(Label(**line) for line in captured["labels"]),
        calib=calib,
        plane=captured["plane"],
        depth=captured.get("depth"),
        instance=captured.get("instance"),
        semantic=captured.get("semantic"),
        meta={**extra_meta, **captured["meta"]},
    )


def move_off_zero_depth(points_velo: NDArray[np.float32], calib: Calibration) -> NDArray[np.float32]:
    """Round points with z = 0 in the cam frame to the next millimetre outwards: other programs divide by z.

    Coordinates are whole millimetres, so with LIDAR and camera in one point every point whose x rounds to 0 has no
    depth; `Rig.cadet()` has two columns of such beams, to the left and to the right.

    Args:
        points_velo: (N, 4) float32 [x, y, z, intensity], metres, velo frame.
        calib: the calibration.

    Returns:
        (N, 4) float32; the same array if no point lies there.
    """
    is_zero = is_at_zero_depth(points_velo, calib)
    if not is_zero.any():
        return points_velo
    axis = int(np.argmax(np.abs(calib.cam_from_velo[2, :3])))
    moved = points_velo.copy()
    millimetres = np.rint(moved[is_zero, axis].astype(np.float64) * 1e3)
    moved[is_zero, axis] = (millimetres + np.where(millimetres < 0.0, -1.0, 1.0)) / 1e3
    return moved


class Episode:
    """The samples of one episode, in order. The same arguments give the same frames.

    Args:
        policy: draws world and rig, and says how far apart views are.
        seed: the dataset's seed.
        episode: the episode's number.
        draw: replaces the policy's own draw.
        maps: give frames their depth, instance and semantic maps.
    """

    def __init__(
        self,
        policy: ResetPolicy,
        seed: int,
        episode: int,
        draw: Callable[[int, int, int], EpisodeSpec] | None = None,
        *,
        maps: bool = True,
    ) -> None:
        self.policy = policy
        self.seed = seed
        self.number = episode
        self.scene: _cadet.Scene | None = None
        self._draw = draw or policy.draw
        self._maps = maps
        self._attempt = 0
        self._num_empty = 0
        self._spec: EpisodeSpec | None = None

    def next_frame(self, sample: int) -> Frame:
        """Drive on and return the next view with a labelled object as frame `sample` of the episode.

        The first view of a world is taken where the ego stands. A view in which nothing has moved since the last one
        (docs/labels.md) is passed over like one without a labelled object, and both count towards the world's redraw.

        Raises:
            CadetError: no world showed a labelled object.
        """
        while True:
            scene, spec = self._advance()
            captured = scene.capture_labelled(sample, self._maps)
            if captured is None:
                self._num_empty += 1
                if self._num_empty >= self.policy.empty_views_limit:
                    self._redraw()
                continue
            self._num_empty = 0
            origin = {
                "seed": self.seed,
                "episode": self.number,
                "sample": sample,
                "attempt": self._attempt,
                "policy": self.policy.name,
                "district": spec.district,
            }
            return frame_from_native(captured, origin)

    def _advance(self) -> tuple[_cadet.Scene, EpisodeSpec]:
        if self.scene is None or self._spec is None:
            self._spec = self._draw(self.seed, self.number, self._attempt)
            self.scene = build_scene(self._spec)
        else:
            self.scene.drive(float(self.policy.distance_m), float(self.policy.blocked_s))
        return self.scene, self._spec

    def _redraw(self) -> None:
        self.scene = None
        self._num_empty = 0
        self._attempt += 1
        if self._attempt >= self.policy.attempts_limit:
            raise CadetError(
                f"episode {self.number}: no labelled object in sight in {self._attempt} worlds of "
                f"{self.policy.empty_views_limit} views each; allow more traffic or labels"
            )
