"""From a frame in memory to a sample."""

from __future__ import annotations

from typing import Any, Final

import numpy as np
import torch
from numpy.typing import NDArray

from avod.config import Config
from avod.data import mirror
from avod.data.augmentation import UNCHANGED, Augmentation
from avod.data.images import jitter_colors, resize_bilinear, shift_colors
from avod.data.object_sizes import resize_objects
from avod.data.sample import Sample
from avod.data.scan_changes import drop_points, shift_ranges
from avod.data.world import WorldChange
from avod.geometry.anchors import anchors_over, occupancy
from cadet import bev
from cadet._util.arrays import check_array
from cadet._util.notices import notice
from cadet.errors import CadetError
from cadet.formats.kitti import Calibration, Label, boxes_cam_from_labels, estimate_plane, points_in_image
from cadet.formats.kitti.label import kitti_spelling

_MIN_UPRIGHT: Final = 0.5
_ROUGH_ERROR: Final = 2e-6
"""Of sums of four products in single precision, as a share of the greatest product: sixteen times its precision."""
_PART: Final = 8192
_MAX_ROUGH: Final = 1e30
_HEIGHT_M: Final = 1.65
"""Of KITTI's camera over the road."""
_NO_IMAGE: Final = torch.zeros((3, 0, 0), dtype=torch.uint8)
_NO_ANCHORS: Final = torch.zeros((0, 6))
_NO_POINTS: Final = torch.zeros((0, 3))
_FLAT_GROUND: Final = np.array([0.0, -1.0, 0.0, _HEIGHT_M])


def build_sample(
    points_velo: NDArray[np.float32],
    image: NDArray[np.uint8],
    calib: Calibration,
    plane: NDArray[np.float64] | None,
    config: Config,
    *,
    labels: tuple[Label, ...] = (),
    augmentation: Augmentation = UNCHANGED,
    ground: NDArray[np.float64] | None = None,
    maps: NDArray[np.float32] | None = None,
    frame_id: str = "in memory",
) -> Sample:
    """Make a sample: points that the image sees, maps, anchors over occupied ground, the image resized.

    A mirrored sample is made from the mirrored points, plane, labels and camera, so everything in it, the anchors'
    heights too, belongs to one mirrored world.

    Args:
        points_velo: (N, 4) float32. May be empty.
        image: (H, W, 3) uint8 RGB.
        calib: the calibration.
        plane: (4,) float64 ground plane in the cam frame, of any length and sign; it is estimated from the
            points if None, or if the configuration says so and the points show ground.
        config: the detector.
        labels: those of the config's classes become the sample's objects.
        augmentation: changes of training.
        ground: what `ground_plane` gave for these arguments, where that is known.
        maps: memory for the sample's maps, (C, H, W) float32; fresh memory costs as much as the maps.
        frame_id: names the frame in messages.

    Raises:
        ShapeError, NonFiniteError: an array of another shape, dtype, or with NaN.
        CadetError: a plane that is no ground, or an image without pixels.
    """
    check_array(points_velo, "points_velo", ("N", 4), np.float32, finite=True)
    check_array(image, "image", ("H", "W", 3), np.uint8)
    height, width = image.shape[:2]
    if min(height, width) < 2:
        raise CadetError(f"image: expected at least 2 x 2 pixels, got {width} x {height}")
    plane = ground_plane(points_velo, calib, plane, config, frame_id) if ground is None else ground
    points_cam = _points_cam_in_image(points_velo, calib, (width, height))
    projection, boxes_cam, classes = calib.P2, *_objects(labels, config)
    points_cam = shift_ranges(points_cam, calib.cam_from_velo[:3, 3], augmentation)
    points_cam = drop_points(points_cam, augmentation)
    points_cam, boxes_cam = resize_objects(points_cam, boxes_cam, classes, augmentation)
    if augmentation.has_jitter:
        image = jitter_colors(image, np.random.default_rng(augmentation.seed))
    if augmentation.is_mirrored:
        image, projection = mirror.mirror_image(image), mirror.mirror_projection(projection, width)
        points_cam, plane = mirror.mirror_points(points_cam), mirror.mirror_plane(plane)
        boxes_cam = mirror.mirror_boxes(boxes_cam)
    if (change := WorldChange.drawn(augmentation)) is not None:
        points_cam, boxes_cam = change.points(points_cam), change.boxes(boxes_cam)
        plane, projection = change.plane(plane), change.projection(projection)
    return Sample(
        frame_id=frame_id,
        bev=torch.from_numpy(bev.maps(points_cam, plane, config.bev, maps)),
        image=_resized(image, config, augmentation) if config.has_camera else _NO_IMAGE,
        anchors=_tensor("anchors", _anchors(points_cam, plane, config)) if config.has_camera else _NO_ANCHORS,
        points_cam=_tensor("points_cam", points_cam) if config.refinement.max_points else _NO_POINTS,
        plane=_tensor("plane", plane),
        projection=_tensor("projection", projection),
        image_size=(width, height),
        boxes_cam=_tensor("boxes_cam", boxes_cam[classes > 0]),
        classes=torch.from_numpy(classes[classes > 0]),
        ignored_cam=_tensor("ignored_cam", boxes_cam[classes == 0]),
    )


def normal_plane(plane: NDArray[Any]) -> NDArray[np.float64]:
    """Bring a ground plane (4,) to a unit normal that points up, b < 0.

    Raises:
        ShapeError, NonFiniteError: not four numbers.
        CadetError: a plane steeper than 60 degrees.
    """
    check_array(plane, "plane", (4,), finite=True)
    length = float(np.linalg.norm(plane[:3]))
    if length <= 0.0 or abs(plane[1]) < _MIN_UPRIGHT * length:
        raise CadetError(f"plane: expected a ground plane a b c d with its normal along y, got {plane.tolist()}")
    unit: NDArray[np.float64] = plane.astype(np.float64) / (length if plane[1] < 0.0 else -length)
    return unit


def ground_plane(
    points_velo: NDArray[np.float32],
    calib: Calibration,
    plane: NDArray[np.float64] | None,
    config: Config,
    frame_id: str = "in memory",
) -> NDArray[np.float64]:
    """Return the ground (4,) that a sample stands on: the frame's plane, or one estimated from the points.

    Where no points show ground it is level, 1.65 m below the camera, with one warning that names the frame.

    Raises:
        CadetError: a plane that is no ground.
    """
    given = None if plane is None else normal_plane(plane)
    if given is not None and config.ground == "file":
        return given
    if not len(points_velo):
        return _FLAT_GROUND  # Without points there are no anchors, whatever they would stand on.
    try:
        return estimate_plane(points_velo, calib)
    except CadetError as error:
        if given is None:
            level = f"taken as level {_HEIGHT_M} m below the camera; a file in planes/ gives another"
            notice(
                [f"frame {frame_id}: no ground is found in the scan ({error}): {level}"], about="ground", key=frame_id
            )
        return _FLAT_GROUND if given is None else given


def _points_cam_in_image(
    points_velo: NDArray[np.float32], calib: Calibration, image_size: tuple[int, int]
) -> NDArray[np.float64]:
    """Return the points (M, 3) that the image sees, cam frame.

    Most are dropped in single precision first, by limits so wide that no point is lost, in parts that stay in the cache
    and take a single thread of NumPy's: a tenth of the time.
    """
    img_from_velo = calib.P2 @ calib.cam_from_velo
    largest = max(float(points_velo.max(initial=1.0)), -float(points_velo.min(initial=-1.0)))
    reach = float(np.abs(img_from_velo).max()) * largest
    if reach < _MAX_ROUGH:
        margin = np.float32(_ROUGH_ERROR * reach)
        # All four columns, as they lie in memory: the intensity counts for nothing.
        weights = np.hstack([img_from_velo[:, :3], np.zeros((3, 1))]).astype(np.float32)
        offset, (width, height) = img_from_velo[:, 3:].astype(np.float32), map(np.float32, image_size)
        kept = []
        for start in range(0, len(points_velo), _PART):
            part = points_velo[start : start + _PART]
            u_times_z, v_times_z, z = weights @ part.T + offset
            is_near = (u_times_z > -margin) & (u_times_z < width * (z + margin))
            is_near &= (v_times_z > -margin) & (v_times_z < height * (z + margin))
            kept.append(part.take(np.flatnonzero(is_near), axis=0))
        points_velo = np.concatenate([points_velo[:0], *kept])
    points_cam = calib.points_cam_from_velo(points_velo)
    return points_cam[points_in_image(points_cam, calib, image_size)]


def _anchors(points_cam: NDArray[np.float64], plane: NDArray[np.float64], config: Config) -> NDArray[np.float64]:
    cells = occupancy(points_cam, plane, config.anchors, config.bev)
    return anchors_over(cells, plane, config.classes, config.anchors, config.bev)


def _resized(image: NDArray[np.uint8], config: Config, augmentation: Augmentation) -> torch.Tensor:
    """Resize an image, and change the colors of what is then left of it: (3, h, w)."""
    resized, settings = resize_bilinear(image, config.image.size), augmentation.settings
    if settings.brightness or settings.contrast or settings.hue_deg:
        brightness, contrast, hue = augmentation.stream("colors").uniform(-1.0, 1.0, 3)
        resized = shift_colors(
            resized, settings.brightness * brightness, 1.0 + settings.contrast * contrast, settings.hue_deg * hue
        )
    return torch.from_numpy(resized).permute(2, 0, 1)


def _objects(labels: tuple[Label, ...], config: Config) -> tuple[NDArray[np.float64], NDArray[np.int64]]:
    """Return boxes (M, 7) and classes (M,) of labels, 0 for those of a type that is ignored."""
    numbers = dict.fromkeys(map(kitti_spelling, config.ignored_types), 0)
    numbers |= {name: number for number, name in enumerate(config.class_names, start=1)}
    chosen = [label for label in labels if label.type in numbers]
    return boxes_cam_from_labels(chosen), np.array([numbers[label.type] for label in chosen], np.int64)


def _tensor(name: str, array: NDArray[np.float64]) -> torch.Tensor:
    largest = float(np.abs(array).max(initial=0.0))
    if largest > float(np.finfo(np.float32).max):
        raise CadetError(f"{name}: expected numbers that single precision holds, got {largest:g}")
    return torch.from_numpy(np.ascontiguousarray(array, dtype=np.float32))
