"""A sample as KITTI sees it: one image, one scan, labels and a calibration."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import Any

import numpy as np
from numpy.typing import NDArray

from cadet._util.arrays import check_array
from cadet._util.checks import check_kind
from cadet._util.summary import counts, summary
from cadet.errors import ShapeError
from cadet.formats.kitti.calib import Calibration
from cadet.formats.kitti.files import images
from cadet.formats.kitti.frame_object import FrameObject, objects_of
from cadet.formats.kitti.label import Label
from cadet.sensors.sample import Agent, Sample, Scan


@dataclass(frozen=True, eq=False)
class Frame:
    """What camera and LIDAR saw at one instant, with labels.

    Frames read from disk have None where nothing was written.

    Attributes:
        image: (H, W, 3) uint8, RGB.
        points_velo: (N, 4) float32 [x, y, z, intensity]: meters in the velo frame, intensity 0..1.
        labels: KITTI's labels, DontCare regions among them.
        calib: the calibration.
        plane: (4,) float64 [a, b, c, d]: the ground in the cam frame, unit normal, b < 0, meters.
        depth: (H, W) float32, meters along the optical axis, inf for sky.
        instance: (H, W) int32: -1 sky, 0 static world, >= 1 actors.
        semantic: (H, W) uint8, values of `cadet.Semantic`.
        normals: (H, W, 3) float32: as `cadet.Maps` says, as the next three.
        optical_flow: (H, W, 2) float32, pixels, NaN where it is unknown.
        scene_flow: (H, W, 3) float32, m/s.
        radiance: (H, W, 3) float32, linear RGB, 1 for the image's white.
        camera_labels: the labels of every camera by its name, `labels` among them, each in the camera's own frame and
            image; empty for a frame that was read or made by hand.
        meta: what else the generator knows, as it stands in `meta/ID.json`.
        sample: what it was made from: all sensors and agents; None for a frame that was read or made by hand.

    Raises:
        ShapeError: an array has the wrong shape or dtype.
        NonFiniteError: NaN or infinity in `points_velo`, `plane`, `normals`, `scene_flow`, or `radiance`, NaN in
            `depth`.
        CadetError: labels, a calibration or a `meta` that are none.
    """

    image: NDArray[np.uint8]
    points_velo: NDArray[np.float32]
    labels: tuple[Label, ...]
    calib: Calibration
    plane: NDArray[np.float64] | None = None
    depth: NDArray[np.float32] | None = None
    instance: NDArray[np.int32] | None = None
    semantic: NDArray[np.uint8] | None = None
    normals: NDArray[np.float32] | None = None
    optical_flow: NDArray[np.float32] | None = None
    scene_flow: NDArray[np.float32] | None = None
    radiance: NDArray[np.float32] | None = None
    camera_labels: Mapping[str, tuple[Label, ...]] = field(default_factory=dict)
    meta: dict[str, Any] | None = None
    sample: Sample | None = None

    def __post_init__(self) -> None:
        check_array(self.image, "image", ("H", "W", 3), np.uint8)
        check_array(self.points_velo, "points_velo", ("N", 4), np.float32, finite=True)
        if self.plane is not None:
            check_array(self.plane, "plane", (4,), np.float64, finite=True)
        height, width = self.image.shape[:2]
        if self.depth is not None:
            check_array(self.depth, "depth", (height, width), np.float32)
            if np.isnan(self.depth).any():
                check_array(np.nan_to_num(self.depth, nan=np.nan, posinf=0.0), "depth", ("H", "W"), finite=True)
        if self.instance is not None:
            check_array(self.instance, "instance", (height, width), np.int32)
        if self.semantic is not None:
            check_array(self.semantic, "semantic", (height, width), np.uint8)
        for name, size in (("normals", 3), ("optical_flow", 2), ("scene_flow", 3), ("radiance", 3)):
            if (vectors := getattr(self, name)) is not None:
                check_array(vectors, name, (height, width, size), np.float32, finite=size == 3)
        if not isinstance(self.labels, tuple):
            raise ShapeError(f"labels: expected a tuple of Label, got {type(self.labels).__name__}")
        for label in self.labels:
            check_kind("", "labels", label, Label)
        check_kind("", "calib", self.calib, Calibration)
        if self.meta is not None:
            check_kind("", "meta", self.meta, dict)
        if self.sample is not None:
            check_kind("", "sample", self.sample, Sample)

    def __getstate__(self) -> dict[str, Any]:
        """Return what a pickled frame keeps: all but the core's own capture."""
        return {**self.__dict__, "sample": None}

    @property
    def images(self) -> dict[str, NDArray[np.uint8]]:
        """Every camera's image by its name: this one and those of the rig's other cameras."""
        if self.sample is None:
            return {"image_2": self.image}
        first, *others = self.sample.image_names
        return {first: self.image} | {name: self.sample.image(name) for name in others}

    @property
    def scans(self) -> dict[str, Scan]:
        """Every LIDAR's scan by its name; empty for a frame that was read or made by hand."""
        return {} if self.sample is None else {name: self.sample.scan(name) for name in self.sample.scan_names}

    @property
    def agents(self) -> tuple[Agent, ...]:
        """Every vehicle and person around the ego; empty for a frame that was read or made by hand."""
        return () if self.sample is None else self.sample.agents

    @property
    def objects(self) -> tuple[FrameObject, ...]:
        """Every object that the image shows, those without a label too, as `labels` has them.

        Raises:
            CadetError: `meta` does not fit the labels.
        """
        return objects_of(self.labels, self.meta)

    @property
    def image_size(self) -> tuple[int, int]:
        """Width and height of the image in pixels."""
        return self.image.shape[1], self.image.shape[0]

    def draw(self, width: int = 1600) -> NDArray[np.uint8]:
        """Draw labeled boxes and LIDAR returns in the image, beside the scan from above.

        Args:
            width: of the picture in pixels, 200 to 16384; the height follows.

        Returns:
            (H, width, 3) uint8 RGB.
        """
        # Loaded when a frame is drawn: `import cadet` stays fast.
        from cadet.formats.kitti.drawing.panel import panel

        return panel(self, width)

    def _repr_png_(self) -> bytes:
        """Return the drawing as a PNG file, which notebooks show for a frame."""
        return images.encode_png(self.draw())

    def __repr__(self) -> str:
        return summary(
            self,
            image=self.image,
            points_velo=self.points_velo,
            labels=counts(label.type for label in self.labels),
            plane=self.plane,
            depth=self.depth,
            instance=self.instance,
            semantic=self.semantic,
            normals=self.normals,
            optical_flow=self.optical_flow,
            scene_flow=self.scene_flow,
            radiance=self.radiance,
            meta=None if self.meta is None else list(self.meta),
        )
