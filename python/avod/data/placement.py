"""Where an object of a bank may stand in another frame, and what it hides there.

Directions are seen from the LIDAR as (x / z, y / z) in axes of the cam frame, so that outlines of straight edges stay
straight. What lies behind the LIDAR takes no part.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Final

import cv2
import numpy as np
from numpy.typing import NDArray

from cadet.boxes import points_in_boxes, project_boxes, wrap_angle
from cadet.evaluation.overlaps import box_iou_bev
from cadet.kitti import Calibration
from cadet.object_bank import BankObject

_NEAR_M: Final = 0.5
_ROOM_M: Final = 0.3
"""Between an object and all others."""
_FREE_ABOVE_M: Final = 0.3
"""Points higher than this over the ground stand where the object is to stand."""
_MOST_IN_THE_WAY: Final = 2
_GROUND_M: Final = 0.4
"""Ground within this of the plane is the ground under the object."""
_LEAST_GROUND: Final = 5
_HALF_BEAM: Final = 0.0035
"""A fifth of a degree: half the angle between two beams of KITTI's LIDAR, by which an outline is wider than points."""
_CELL: Final = (0.004, 0.008)
"""Of directions in which one thing hides another: two beams across and one down."""
_BEHIND_M: Final = 0.5
"""What is this much farther is hidden."""
_MOST_HIDDEN: Final = 0.1
"""Of an object's points, and of the directions within its outline."""
_MOST_COVERED: Final = 0.5
"""Of the points of any object that was there before."""


@dataclass(frozen=True, eq=False)
class Scene:
    """What placing needs to know of a frame.

    Attributes:
        points_cam: (N, 3), those ahead of the LIDAR that objects in the image may hide, or that may hide them.
        boxes_cam: (M, 7) of all labels.
        plane: (4,) ground plane, unit normal, b < 0.
        calib: the calibration.
        image_size: width and height in pixels.
    """

    points_cam: NDArray[np.float64]
    boxes_cam: NDArray[np.float64]
    plane: NDArray[np.float64]
    calib: Calibration
    image_size: tuple[int, int]

    @property
    def lidar_cam(self) -> NDArray[np.float64]:
        """(3,), where the LIDAR stands in the cam frame."""
        return self.calib.cam_from_velo[:3, 3]


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
        is_behind: (N,) bool, the scene's points that it hides.
        hidden: the share of its points that something hides.
        covered: (M,) the share of each other object's points that it hides.
    """

    box_cam: NDArray[np.float64]
    points_cam: NDArray[np.float64]
    corners_cam: NDArray[np.float64]
    is_behind: NDArray[np.bool_]
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
    seen = _Outline.of(points_cam - scene.lidar_cam)
    scene_scan = scene.points_cam - scene.lidar_cam
    is_before, is_behind = seen.before_and_behind(scene_scan)
    if is_before.sum() > _MOST_HIDDEN * (is_before.sum() + is_behind.sum()):
        return None
    is_hidden = seen.is_hidden_by(scene_scan[is_before])
    covered = _shares(is_behind, scene)
    if is_hidden.mean() > _MOST_HIDDEN or (covered > _MOST_COVERED).any():
        return None
    kept = np.column_stack([points_cam, item.points_scan[:, 3]])[~is_hidden]
    return Placement(box_cam, kept, corners, is_behind, float(is_hidden.mean()), covered)


def _has_room(box_cam: NDArray[np.float64], scene: Scene) -> bool:
    grown = box_cam + [0.0, 0.0, 0.0, 2.0 * _ROOM_M, 2.0 * _ROOM_M, 0.0, 0.0]
    return not box_iou_bev(grown[None], scene.boxes_cam).any()


def _ground_y(box_cam: NDArray[np.float64], scene: Scene) -> float:
    """Return the ground's y under an object: the plane's, moved to the median of the ground points about it."""
    a, b, c, d = scene.plane
    on_plane = -(a * box_cam[0] + c * box_cam[2] + d) / b
    reach = 0.5 * max(box_cam[3], box_cam[4]) + _ROOM_M
    is_near = np.abs(scene.points_cam[:, [0, 2]] - box_cam[[0, 2]]).max(axis=1, initial=0.0) < reach
    heights = scene.points_cam[is_near] @ scene.plane[:3] + d
    ground = heights[np.abs(heights) < _GROUND_M]
    return float(on_plane + (np.median(ground) / b if len(ground) >= _LEAST_GROUND else 0.0))


def _is_in_image(box_cam: NDArray[np.float64], scene: Scene) -> bool:
    left, top, right, bottom = project_boxes(box_cam[None], scene.calib)[0]
    width, height = scene.image_size
    return bool(left >= 0.0 and top >= 0.0 and right <= width - 1.0 and bottom <= height - 1.0)


def _is_taken(box_cam: NDArray[np.float64], scene: Scene) -> bool:
    # The room above the ground, and no lower.
    raised = box_cam - [0.0, _FREE_ABOVE_M, 0.0, 0.0, 0.0, _FREE_ABOVE_M, 0.0]
    reach = np.hypot(box_cam[3], box_cam[4])
    is_near = np.abs(scene.points_cam[:, [0, 2]] - box_cam[[0, 2]]).max(axis=1, initial=0.0) < reach
    near = scene.points_cam[is_near]
    return int(points_in_boxes(near, raised[None]).sum()) > _MOST_IN_THE_WAY


def _shares(is_behind: NDArray[np.bool_], scene: Scene) -> NDArray[np.float64]:
    """Return the share of each label's points that are behind; 0 for a label without points."""
    shares = np.zeros(len(scene.boxes_cam))
    hidden_cam = scene.points_cam[is_behind]
    if not len(hidden_cam):
        return shares
    hidden = points_in_boxes(hidden_cam, scene.boxes_cam).sum(axis=0)
    for index in np.flatnonzero(hidden):
        box = scene.boxes_cam[index]
        is_near = np.abs(scene.points_cam[:, [0, 2]] - box[[0, 2]]).max(axis=1) < 0.5 * np.hypot(box[3], box[4]) + 0.1
        shares[index] = hidden[index] / points_in_boxes(scene.points_cam[is_near], box[None]).sum()
    return shares


@dataclass(frozen=True, eq=False)
class _Outline:
    """An object as the LIDAR sees it.

    Attributes:
        directions: (K, 2) of its points.
        range_m: (K,) of its points.
        edges: (E, 3) [a, b, c] of the convex hull: a x + b y <= c inside.
    """

    directions: NDArray[np.float64]
    range_m: NDArray[np.float64]
    edges: NDArray[np.float64]

    @classmethod
    def of(cls, points_scan: NDArray[np.float64]) -> _Outline:
        directions = points_scan[:, :2] / points_scan[:, 2:]
        hull = np.asarray(cv2.convexHull(directions.astype(np.float32)), np.float64)[:, 0]
        middle = hull.mean(axis=0)
        along = np.roll(hull, -1, axis=0) - hull
        lengths = np.linalg.norm(along, axis=1)
        hull, along, lengths = hull[lengths > 0.0], along[lengths > 0.0], lengths[lengths > 0.0]
        normals = np.column_stack([along[:, 1], -along[:, 0]]) / lengths[:, None]
        offsets = (normals * hull).sum(axis=1)
        # Outward, whichever way the hull turns.
        sign = np.where(normals @ middle > offsets, -1.0, 1.0)
        edges = np.column_stack([normals * sign[:, None], offsets * sign + _HALF_BEAM])
        return cls(directions, np.linalg.norm(points_scan, axis=1), edges)

    def before_and_behind(self, points_scan: NDArray[np.float64]) -> tuple[NDArray[np.bool_], NDArray[np.bool_]]:
        """Tell which points (N, 3) within the outline are nearer than the object, and which lie beyond its front."""
        low = self.directions.min(axis=0) - _HALF_BEAM
        high = self.directions.max(axis=0) + _HALF_BEAM
        x, y, z = points_scan.T
        is_in = (z > 0.0) & (x >= low[0] * z) & (x <= high[0] * z) & (y >= low[1] * z) & (y <= high[1] * z)
        at = np.flatnonzero(is_in)
        inside = points_scan[at]
        directions = inside[:, :2] / inside[:, 2:]
        is_within = (directions @ self.edges[:, :2].T <= self.edges[:, 2]).all(axis=1)
        range_m, front_m = np.linalg.norm(inside, axis=1), self.range_m.min()
        is_before, is_behind = np.zeros((2, len(points_scan)), np.bool_)
        is_before[at[is_within & (range_m < front_m - _BEHIND_M)]] = True
        is_behind[at[is_within & (range_m > front_m)]] = True
        return is_before, is_behind

    def is_hidden_by(self, points_scan: NDArray[np.float64]) -> NDArray[np.bool_]:
        """Tell which of the object's points (K,) lie behind points (N, 3) of its outline in the same direction."""
        low, cell = self.directions.min(axis=0), np.array(_CELL)
        columns, rows = (np.floor((self.directions.max(axis=0) - low) / cell).astype(np.intp) + 1).tolist()
        nearest = np.full(columns * rows, np.inf)
        directions = points_scan[:, :2] / points_scan[:, 2:]
        np.minimum.at(nearest, _cells(directions, low, columns, rows), np.linalg.norm(points_scan, axis=1))
        hidden: NDArray[np.bool_] = nearest[_cells(self.directions, low, columns, rows)] < self.range_m - _BEHIND_M
        return hidden


def _cells(directions: NDArray[np.float64], low: NDArray[np.float64], columns: int, rows: int) -> NDArray[np.intp]:
    column, row = np.floor((directions - low) / np.array(_CELL)).astype(np.intp).T
    cells: NDArray[np.intp] = np.clip(row, 0, rows - 1) * columns + np.clip(column, 0, columns - 1)
    return cells
