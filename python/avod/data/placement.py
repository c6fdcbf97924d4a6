"""Where an object of a bank may stand in another frame, and what it hides there."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Final

import numpy as np
from numpy.typing import NDArray

from avod.data.outline import HALF_BEAM, Outline
from cadet.datasets.object_bank import BankObject
from cadet.evaluation.overlaps import box_iou_bev
from cadet.formats.kitti import Calibration
from cadet.formats.kitti.boxes import points_in_boxes, project_boxes, wrap_angle

_NEAR_M: Final = 0.5
_ROOM_M: Final = 0.3
"""Between an object and all others."""
_AROUND_M: Final = 0.4
_MOST_SIDEWAYS: Final = 1.4
"""Radians from ahead; beyond, slopes grow without end."""
_FREE_ABOVE_M: Final = 0.3
"""Points higher than this over the ground stand where the object is to stand."""
_MOST_IN_THE_WAY: Final = 2
_GROUND_M: Final = 0.4
"""Ground within this of the plane is the ground under the object."""
_LEAST_GROUND: Final = 5
_MOST_HIDDEN: Final = 0.1
"""Of an object's points, and of the directions within its outline."""
_MOST_COVERED: Final = 0.5
"""Of the points of any object that was there before."""


@dataclass(frozen=True, eq=False)
class Scene:
    """What placing needs to know of a frame.

    Attributes:
        points_cam: (N, 3), those ahead of the LIDAR that objects in the image may hide, or that may hide them; from
            left to right as the LIDAR sees them.
        order: (N,) their indices in the order that they were given in.
        slopes: (N,) x / z of them, seen from the LIDAR.
        boxes_cam: (M, 7) of all labels.
        plane: (4,) ground plane, unit normal, b < 0.
        calib: the calibration.
        image_size: width and height in pixels.
    """

    points_cam: NDArray[np.float64]
    order: NDArray[np.intp]
    slopes: NDArray[np.float64]
    boxes_cam: NDArray[np.float64]
    plane: NDArray[np.float64]
    calib: Calibration
    image_size: tuple[int, int]

    @classmethod
    def of(
        cls,
        points_cam: NDArray[np.float64],
        boxes_cam: NDArray[np.float64],
        plane: NDArray[np.float64],
        calib: Calibration,
        image_size: tuple[int, int],
    ) -> Scene:
        """Sort points, all ahead of the LIDAR, from left to right."""
        lidar_cam = calib.cam_from_velo[:3, 3]
        slope = (points_cam[:, 0] - lidar_cam[0]) / (points_cam[:, 2] - lidar_cam[2])
        order = np.argsort(slope, kind="stable")
        return cls(points_cam.take(order, axis=0), order, slope.take(order), boxes_cam, plane, calib, image_size)

    @property
    def lidar_cam(self) -> NDArray[np.float64]:
        """(3,), where the LIDAR stands in the cam frame."""
        return self.calib.cam_from_velo[:3, 3]

    def between(self, low: float, high: float) -> slice:
        """Return the places of the points between two slopes."""
        first, last = np.searchsorted(self.slopes, (low, high)).tolist()
        return slice(first, last)

    def about(self, box_cam: NDArray[np.float64]) -> NDArray[np.float64]:
        """Return the points (K, 3) about a box: all of those over its ground and 40 cm around it, and more."""
        x, _, z = box_cam[:3] - self.lidar_cam
        share = (0.5 * math.hypot(box_cam[3], box_cam[4]) + _AROUND_M) / math.hypot(x, z)
        middle, half = math.atan2(x, z), math.asin(min(share, 1.0))
        if max(abs(middle - half), abs(middle + half)) > _MOST_SIDEWAYS:
            return self.points_cam
        return self.points_cam[self.between(math.tan(middle - half), math.tan(middle + half))]


def slopes(calib: Calibration, image_size: tuple[int, int]) -> tuple[float, float]:
    """Return x / z of the rays through the image's left and right edges, about halfway down."""
    width, height = image_size
    edges = np.array([[0.0, 0.5 * height, 1.0], [width - 1.0, 0.5 * height, 1.0]])
    rays = np.linalg.solve(calib.P2[:, :3], edges.T)
    left, right = (rays[0] / rays[2]).tolist()
    return left, right


@dataclass(frozen=True, eq=False)
class Placement:
    """An object in its place.

    Attributes:
        box_cam: (7,).
        points_cam: (K, 4) with intensity, without those that something hides.
        corners_cam: (4, 3) of its crop.
        behind: indices of the scene's points that it hides, in the order that they were given in.
        hidden: the share of its points that something hides.
        covered: (M,) the share of each other object's points that it hides.
    """

    box_cam: NDArray[np.float64]
    points_cam: NDArray[np.float64]
    corners_cam: NDArray[np.float64]
    behind: NDArray[np.intp]
    hidden: float
    covered: NDArray[np.float64]


def place(item: BankObject, turn_rad: float, scene: Scene) -> Placement | None:
    """Put an object on the ground at its own distance, turned about the LIDAR; None where it has no room.

    Turned so, it shows its sensor the side that it showed before, in the same density of points. It has no room where
    it leaves the image, touches another object or something that stands there, where more than a tenth of it were
    hidden, or where it would hide more than half the points of another object.

    Args:
        item: the object.
        turn_rad: about the y axis of the cam frame, as rotation_y counts.
        scene: the frame.
    """
    cos, sin = np.cos(turn_rad), np.sin(turn_rad)
    turn = np.array([[cos, 0.0, sin], [0.0, 1.0, 0.0], [-sin, 0.0, cos]])
    box_cam = item.box_scan.copy()
    box_cam[:3] = turn @ item.box_scan[:3] + scene.lidar_cam
    box_cam[6] = float(wrap_angle(item.box_scan[6] + turn_rad))
    if box_cam[2] < _NEAR_M or not _has_room(box_cam, scene):
        return None
    rise_m = _ground_y(box_cam, scene) - box_cam[1]
    box_cam[1] += rise_m
    if not _is_in_image(box_cam, scene) or _is_taken(box_cam, scene):
        return None
    shift_cam = scene.lidar_cam + [0.0, rise_m, 0.0]
    points_cam = item.points_scan[:, :3].astype(np.float64) @ turn.T + shift_cam
    corners = item.corners_scan @ turn.T + shift_cam
    if min(points_cam[:, 2].min() - scene.lidar_cam[2], corners[:, 2].min()) < _NEAR_M:
        return None
    seen = Outline.of(points_cam - scene.lidar_cam)
    across = seen.directions[:, 0]
    window = scene.between(across.min() - HALF_BEAM, across.max() + HALF_BEAM)
    scene_scan = scene.points_cam[window] - scene.lidar_cam
    before, behind = seen.before_and_behind(scene_scan)
    if len(before) > _MOST_HIDDEN * (len(before) + len(behind)):
        return None
    is_hidden = seen.is_hidden_by(scene_scan[before])
    behind += window.start
    covered = _shares(scene.points_cam[behind], scene)
    if is_hidden.mean() > _MOST_HIDDEN or (covered > _MOST_COVERED).any():
        return None
    kept = np.column_stack([points_cam, item.points_scan[:, 3]])[~is_hidden]
    return Placement(box_cam, kept, corners, scene.order[behind], float(is_hidden.mean()), covered)


def _has_room(box_cam: NDArray[np.float64], scene: Scene) -> bool:
    grown = box_cam + [0.0, 0.0, 0.0, 2.0 * _ROOM_M, 2.0 * _ROOM_M, 0.0, 0.0]
    return not box_iou_bev(grown[None], scene.boxes_cam).any()


def _ground_y(box_cam: NDArray[np.float64], scene: Scene) -> float:
    """Return the ground's y under an object: the plane's, moved to the median of the ground points about it."""
    a, b, c, d = scene.plane
    on_plane = -(a * box_cam[0] + c * box_cam[2] + d) / b
    reach = 0.5 * max(box_cam[3], box_cam[4])
    points_cam = scene.about(box_cam)
    is_near = (np.abs(points_cam[:, 0] - box_cam[0]) < reach) & (np.abs(points_cam[:, 2] - box_cam[2]) < reach)
    heights = points_cam[is_near] @ scene.plane[:3] + d
    ground = heights[np.abs(heights) < _GROUND_M]
    return float(on_plane + (np.median(ground) / b if len(ground) >= _LEAST_GROUND else 0.0))


def _is_in_image(box_cam: NDArray[np.float64], scene: Scene) -> bool:
    left, top, right, bottom = project_boxes(box_cam[None], scene.calib)[0]
    width, height = scene.image_size
    return bool(left >= 0.0 and top >= 0.0 and right <= width - 1.0 and bottom <= height - 1.0)


def _is_taken(box_cam: NDArray[np.float64], scene: Scene) -> bool:
    # The room above the ground, and no lower.
    raised = box_cam - [0.0, _FREE_ABOVE_M, 0.0, 0.0, 0.0, _FREE_ABOVE_M, 0.0]
    return int(points_in_boxes(scene.about(box_cam), raised[None]).sum()) > _MOST_IN_THE_WAY


def _shares(hidden_cam: NDArray[np.float64], scene: Scene) -> NDArray[np.float64]:
    """Return the share of each label's points that are among the hidden ones; 0 for a label without points."""
    shares = np.zeros(len(scene.boxes_cam))
    hidden = points_in_boxes(hidden_cam, scene.boxes_cam).sum(axis=0)
    for index in np.flatnonzero(hidden):
        box = scene.boxes_cam[index]
        shares[index] = hidden[index] / points_in_boxes(scene.about(box), box[None]).sum()
    return shares
