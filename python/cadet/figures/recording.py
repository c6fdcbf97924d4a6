"""Episodes as recordings for Rerun: scan, image, boxes, and tracks over time.

Importing this module needs Rerun (`pip install 'cadet-sim[view]'`).
"""

from __future__ import annotations

import os
from collections.abc import Iterable, Iterator
from pathlib import Path
from typing import Any, Final

import numpy as np
from numpy.typing import NDArray

from cadet._util import style
from cadet._util.user_files import check_out_path
from cadet.errors import CadetError, MissingFileError
from cadet.formats.kitti import Frame, Label, boxes_cam_from_labels, read_frame, read_meta
from cadet.formats.kitti.boxes import boxes_velo_from_cam
from cadet.formats.kitti.files.folder import check_id, frame_ids, sample_folder
from cadet.formats.kitti.image_sets import check_not_empty

try:
    import rerun
except ModuleNotFoundError as error:
    if error.name != "rerun":
        raise
    raise CadetError("cadet view --rerun needs rerun: pip install 'cadet-sim[view]'") from None

_SUFFIX: Final = ".rrd"
_FRAME: Final = "frame"
_TIME: Final = "time"
_POINT_M: Final = 0.03
_IMAGE_PLANE_M: Final = 3.0
_TRACK_M: Final = 0.05
_EGO_COLOR: Final[style.Color] = (255, 255, 255)


def view_episode(root: str | Path, frame_id: str | int | None, out_path: str | Path) -> Path:
    """Write the episode of a frame as a recording, whole or not at all.

    Args:
        root: a dataset in KITTI's format.
        frame_id: a frame of the episode; the dataset's first if None. Without a `meta` it is an episode of its own.
        out_path: ends in .rrd.

    Returns:
        The path.

    Raises:
        CadetError: a name that does not end in .rrd, no frames, or a damaged file.
        MissingFileError: no such folder or frame.
    """
    ids = frame_ids(sample_folder(root))
    check_not_empty(ids, root, None)
    frame_id = ids[0] if frame_id is None else check_id(frame_id)
    if frame_id not in ids:
        raise MissingFileError(f"{root}: no frame {frame_id}")
    return write_recording(
        (read_frame(root, name, has_extras=True) for name in _episode(root, ids, frame_id)), out_path
    )


def write_recording(frames: Iterable[Frame], out_path: str | Path) -> Path:
    """Write frames as a recording with the timelines "frame" and, where it is known, "time" in seconds.

    Entities: "world/ego" carries the ego's pose, "world/ego/velo/points" the scan, "world/ego/velo/boxes" the labels'
    boxes, "world/ego/velo/camera" the image with the labels' rectangles, "world/path" the ego's way, and
    "world/tracks/ID" the way of each agent's box.

    Args:
        frames: read from a folder or generated, in the order of time.
        out_path: ends in .rrd.

    Returns:
        The path.

    Raises:
        CadetError: a name that does not end in .rrd.
        MissingFileError: the folder is not there.
    """
    path = check_out_path(out_path, (_SUFFIX,))
    aside = path.with_name(f".{path.name}.{os.getpid()}.tmp")
    try:
        with rerun.RecordingStream("cadet") as stream:
            stream.save(aside)
            stream.log("world", rerun.ViewCoordinates.RIGHT_HAND_Z_UP, static=True)
            recorder = _Recorder(stream)
            for number, frame in enumerate(frames):
                recorder.add(number, frame)
            stream.flush()
            stream.disconnect()
        aside.replace(path)
    finally:
        aside.unlink(missing_ok=True)
    return path


class _Recorder:
    """Logs frames; keeps the ways of ego and agents from frame to frame."""

    def __init__(self, stream: rerun.RecordingStream) -> None:
        self._stream = stream
        self._ways: dict[str, list[list[float]]] = {}

    def add(self, number: int, frame: Frame) -> None:
        meta = frame.meta or {}
        self._stream.set_time(_FRAME, sequence=number)
        if "time_s" in meta:
            self._stream.set_time(_TIME, duration=float(meta["time_s"]))
        world_from_ego = np.array(meta.get("world_from_ego", np.eye(4)), np.float64)
        ego_from_velo = np.array(meta.get("ego_from_velo", np.eye(4)), np.float64)
        self._log_pose("world/ego", world_from_ego)
        self._log_pose("world/ego/velo", ego_from_velo)
        self._log_points(frame)
        self._log_image(frame)
        labels, boxes_velo = self._log_boxes(frame)
        self._log_way("world/path", world_from_ego[:3, 3], _EGO_COLOR)
        for label, box_velo, agent in zip(labels, boxes_velo, _agents_of(frame), strict=True):
            if agent is not None:
                place = (world_from_ego @ ego_from_velo @ [*box_velo[:3], 1.0])[:3]
                self._log_way(f"world/tracks/{agent}", place, style.class_color(label.type))

    def _log_pose(self, entity: str, pose: NDArray[np.float64]) -> None:
        self._stream.log(entity, rerun.Transform3D(translation=pose[:3, 3], mat3x3=pose[:3, :3]))

    def _log_points(self, frame: Frame) -> None:
        colors = style.turbo(frame.points_velo[:, 3])
        self._stream.log(
            "world/ego/velo/points", rerun.Points3D(frame.points_velo[:, :3], colors=colors, radii=_POINT_M)
        )

    def _log_image(self, frame: Frame) -> None:
        velo_from_camera = frame.calib.velo_from_cam.copy()
        velo_from_camera[:3, 3] = frame.calib.points_velo_from_cam(frame.calib.eye_cam[None])[0]
        self._log_pose("world/ego/velo/camera", velo_from_camera)
        width, height = frame.image_size
        pinhole = rerun.Pinhole(
            image_from_camera=frame.calib.P2[:, :3],
            width=width,
            height=height,
            camera_xyz=rerun.ViewCoordinates.RDF,
            image_plane_distance=_IMAGE_PLANE_M,
        )
        self._stream.log("world/ego/velo/camera", pinhole)
        self._stream.log("world/ego/velo/camera/image", rerun.Image(frame.image).compress())

    def _log_boxes(self, frame: Frame) -> tuple[list[Label], NDArray[np.float64]]:
        rectangles = np.array([label.bbox for label in frame.labels], np.float64).reshape(-1, 4)
        # From KITTI's pixels, whose centers are whole, to Rerun's, whose edges are.
        boxes = rerun.Boxes2D(
            mins=rectangles[:, :2] + 0.5,
            sizes=rectangles[:, 2:] - rectangles[:, :2],
            colors=[style.class_color(label.type) for label in frame.labels],
            labels=[label.type for label in frame.labels],
        )
        self._stream.log("world/ego/velo/camera/boxes", boxes)
        labels = [label for label in frame.labels if not label.is_dont_care]
        boxes_velo = boxes_velo_from_cam(boxes_cam_from_labels(labels), frame.calib)
        half_yaw = boxes_velo[:, 6] / 2
        names = zip(labels, _agents_of(frame), strict=True)
        cuboids = rerun.Boxes3D(
            centers=boxes_velo[:, :3],
            sizes=boxes_velo[:, 3:6],
            quaternions=np.column_stack([np.zeros((len(labels), 2)), np.sin(half_yaw), np.cos(half_yaw)]),
            colors=[style.class_color(label.type) for label in labels],
            labels=[label.type if agent is None else f"{label.type} {agent}" for label, agent in names],
        )
        self._stream.log("world/ego/velo/boxes", cuboids)
        return labels, boxes_velo

    def _log_way(self, entity: str, place: NDArray[np.float64], color: style.Color) -> None:
        way = self._ways.setdefault(entity, [])
        way.append(place.tolist())
        # A line needs two places.
        line = way if len(way) > 1 else way * 2
        self._stream.log(entity, rerun.LineStrips3D([line], colors=[color], radii=_TRACK_M))


def _agents_of(frame: Frame) -> list[int | None]:
    """Return the agent of each label that is no DontCare region; None where it is not known."""
    objects: list[dict[str, Any]] = (frame.meta or {}).get("objects") or []
    if len(objects) != len(frame.labels):
        return [None for label in frame.labels if not label.is_dont_care]
    return [seen.get("actor_id") for seen, label in zip(objects, frame.labels, strict=True) if not label.is_dont_care]


def _episode(root: str | Path, ids: tuple[str, ...], frame_id: str) -> Iterator[str]:
    """Yield the ids of the frames of an episode: those next to each other whose `meta` names the same."""
    at = ids.index(frame_id)
    number = _episode_of(root, frame_id)
    if number is None:
        yield frame_id
        return
    while at > 0 and _episode_of(root, ids[at - 1]) == number:
        at -= 1
    while at < len(ids) and _episode_of(root, ids[at]) == number:
        yield ids[at]
        at += 1


def _episode_of(root: str | Path, frame_id: str) -> tuple[Any, Any] | None:
    meta = read_meta(root, frame_id) or {}
    return (meta.get("seed"), meta["episode"]) if "episode" in meta else None
