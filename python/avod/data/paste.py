"""Objects of a bank, pasted into frames: points, pixels, and labels."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from typing import Final

import cv2
import numpy as np
from numpy.typing import NDArray

from avod.config import Config
from avod.data.augmentation import Augmentation
from avod.data.placement import Placement, Scene, place, slopes
from cadet.datasets.object_bank import BankObject, ObjectBank
from cadet.errors import CadetError
from cadet.formats.kitti import Calibration, Label, boxes_cam_from_labels
from cadet.formats.kitti.boxes import alpha_from_boxes, corners_cam, project_boxes
from cadet.formats.kitti.frame import Frame

_TRIES: Final = 6
"""Places that an object is tried in before it is given up."""
_MARGIN_M: Final = 5.0
"""Beside what the image shows: half of a long object."""
_PARTLY: Final = 0.1
"""Of an object's points: where more are hidden, the object is partly occluded."""


def check_bank(bank: ObjectBank | None, config: Config) -> None:
    """Refuse a bank that is missing, that nothing asks for, or that holds none of the classes.

    Raises:
        CadetError: naming the switch.
    """
    count = config.augmentation.pasted_objects
    if bank is None:
        if count:
            raise CadetError(f"augmentation.pasted_objects is {count}, which needs --bank: `cadet bank DATA -o BANK`")
        return
    if not count:
        raise CadetError(f"{bank.root}: augmentation.pasted_objects is 0: say in the configuration how many to paste")
    if not set(bank.types) & set(config.class_names):
        raise CadetError(f"{bank.root}: none of its {len(bank)} objects is a {' or '.join(config.class_names)}")


class DamagedBankError(CadetError):
    """An object of a bank that cannot be read, whatever frame it was meant for."""


def paste_objects(
    frame: Frame,
    plane: NDArray[np.float64],
    bank: ObjectBank,
    names: Sequence[str],
    augmentation: Augmentation,
) -> Frame:
    """Paste up to `pasted_objects` objects into a frame, each where it has room.

    Points behind an object are taken out, its own that something nearer hides too; its crop is pasted by its
    silhouette, nearer objects stay in front of it, and it gets a label. Maps of depth and instances stay as they were.

    Args:
        frame: the frame.
        plane: (4,) its ground, unit normal, b < 0.
        bank: the objects.
        names: the classes that are pasted, drawn evenly among those that the bank has.
        augmentation: how many at most, and the random numbers.

    Raises:
        CadetError: a damaged bank.
    """
    by_class = [numbers for name in names if (numbers := [i for i, t in enumerate(bank.types) if t == name])]
    if not augmentation.settings.pasted_objects or not by_class:
        return frame
    rng = augmentation.stream("paste")
    count = int(rng.integers(augmentation.settings.pasted_objects + 1))
    if not count:
        return frame
    pasted = _Pasted(frame, plane)
    for _ in range(count):
        numbers = by_class[int(rng.integers(len(by_class)))]
        item = _object(bank, numbers[int(rng.integers(len(numbers)))])
        for azimuth in rng.uniform(*pasted.azimuths, _TRIES):
            now = float(np.arctan2(item.box_scan[0], item.box_scan[2]))
            placement = place(item, azimuth - now, pasted.scene)
            if placement is not None:
                pasted.add(item, placement)
                break
    return pasted.frame()


def _object(bank: ObjectBank, number: int) -> BankObject:
    try:
        return bank[number]
    except (CadetError, OSError) as error:
        raise DamagedBankError(str(error)) from None


class _Pasted:
    """A frame on its way to having more objects."""

    def __init__(self, frame: Frame, plane: NDArray[np.float64]) -> None:
        self._frame = frame
        calib = frame.calib
        left, right = slopes(calib, frame.image_size)
        # In single precision, which is enough for so wide a margin.
        weights = np.hstack([calib.cam_from_velo[[0, 2], :3], np.zeros((2, 1))]).astype(np.float32)
        x, z = weights @ frame.points_velo.T + calib.cam_from_velo[[0, 2], 3:].astype(np.float32)
        is_near = (z > calib.cam_from_velo[2, 3]) & (x > left * z - _MARGIN_M) & (x < right * z + _MARGIN_M)
        self._far_velo = frame.points_velo.take(np.flatnonzero(~is_near), axis=0)
        self._points_velo = frame.points_velo.take(np.flatnonzero(is_near), axis=0)
        self._points_cam = calib.points_cam_from_velo(self._points_velo)
        self._image = frame.image.copy()
        self._labels = list(frame.labels)
        boxes_cam = boxes_cam_from_labels(label for label in frame.labels if not label.is_dont_care)
        self.scene = Scene.of(calib.points_cam_from_velo(self._points_velo), boxes_cam, plane, calib, frame.image_size)
        self.azimuths = float(np.arctan(left)), float(np.arctan(right))

    def add(self, item: BankObject, placement: Placement) -> None:
        """Add an object in its place."""
        scene = self.scene
        box_cam = placement.box_cam
        distance_m = np.hypot(box_cam[0], box_cam[2])
        is_nearer = np.hypot(scene.boxes_cam[:, 0], scene.boxes_cam[:, 2]) < distance_m
        paste_crop(self._image, item.crop, placement.corners_cam, scene.calib, scene.boxes_cam[is_nearer])
        self._mark_covered(placement)
        velo = scene.calib.points_velo_from_cam(placement.points_cam)
        new = np.column_stack([velo, placement.points_cam[:, 3]]).astype(np.float32)
        self._points_velo = np.concatenate([np.delete(self._points_velo, placement.behind, axis=0), new])
        self._labels.append(_label(item.type, placement, scene.calib))
        self._points_cam = np.concatenate(
            [np.delete(self._points_cam, placement.behind, axis=0), placement.points_cam[:, :3]]
        )
        boxes_cam = np.concatenate([scene.boxes_cam, box_cam[None]])
        self.scene = Scene.of(self._points_cam, boxes_cam, scene.plane, scene.calib, scene.image_size)

    def frame(self) -> Frame:
        """Return the frame as it now is."""
        if len(self._labels) == len(self._frame.labels):
            return self._frame
        points_velo = np.concatenate([self._points_velo, self._far_velo])
        return replace(self._frame, image=self._image, points_velo=points_velo, labels=tuple(self._labels))

    def _mark_covered(self, placement: Placement) -> None:
        covered = iter(placement.covered > _PARTLY)
        for index, label in enumerate(self._labels):
            if not label.is_dont_care and next(covered) and label.occluded == 0:
                self._labels[index] = replace(label, occluded=1)


def paste_crop(
    image: NDArray[np.uint8],
    crop: NDArray[np.uint8],
    crop_corners_cam: NDArray[np.float64],
    calib: Calibration,
    nearer_cam: NDArray[np.float64],
) -> None:
    """Paste a crop into an image, in place.

    Args:
        image: (H, W, 3), written to.
        crop: (h, w, 4) RGB and opacity.
        crop_corners_cam: (4, 3), where its outer corners (top left, top right, bottom right, bottom left) lie.
        calib: projects them.
        nearer_cam: (M, 7) boxes of objects that stay in front.
    """
    height, width = image.shape[:2]
    corners = calib.project(crop_corners_cam)
    low = np.maximum(np.floor(corners.min(axis=0)), 0.0).astype(int)
    high = np.minimum(np.ceil(corners.max(axis=0)) + 1.0, (width, height)).astype(int)
    columns, rows = (high - low).tolist()
    if min(columns, rows) < 1:
        return
    rows_px, columns_px = crop.shape[:2]
    edges = np.array([[0, 0], [columns_px, 0], [columns_px, rows_px], [0, rows_px]], np.float32) - np.float32(0.5)
    warp = cv2.getPerspectiveTransform(edges, (corners - low).astype(np.float32))
    opacity = crop[..., 3:].astype(np.float32) / 255.0
    # Colors times opacity, so that what is transparent does not bleed into the border.
    solid = np.concatenate([crop[..., :3] * opacity, opacity], axis=2, dtype=np.float32)
    warped = np.asarray(cv2.warpPerspective(solid, warp, (columns, rows), flags=cv2.INTER_LINEAR))
    mask = np.zeros((rows, columns), np.uint8)
    for box in nearer_cam:
        outline = project_outline(box, calib) - low
        cv2.fillConvexPoly(mask, np.rint(np.asarray(cv2.convexHull(outline.astype(np.float32)))).astype(np.int32), 1)
    warped[mask > 0] = 0.0
    window = image[low[1] : high[1], low[0] : high[0]]
    window[:] = np.rint(warped[..., :3] + window * (1.0 - warped[..., 3:])).astype(np.uint8)


def project_outline(box_cam: NDArray[np.float64], calib: Calibration) -> NDArray[np.float64]:
    """Return the pixels (K, 2) of those corners of a box (7,) that the camera sees."""
    points_img = calib.project(corners_cam(box_cam[None])[0])
    # What lies far outside is as good as at the border of what OpenCV can draw.
    outline: NDArray[np.float64] = np.clip(points_img[np.isfinite(points_img).all(axis=1)], -1e4, 1e4)
    return outline


def _label(kind: str, placement: Placement, calib: Calibration) -> Label:
    box = placement.box_cam
    x, y, z, length, width, height, rotation_y = box.tolist()
    left, top, right, bottom = project_boxes(box[None], calib)[0].tolist()
    return Label(
        type=kind,
        truncated=0.0,
        occluded=int(placement.hidden > 0.0),
        alpha=float(alpha_from_boxes(box[None])[0]),
        bbox=(left, top, right, bottom),
        dimensions_hwl=(height, width, length),
        location_cam=(x, y, z),
        rotation_y=rotation_y,
    )
