"""A trained detector for frames in memory."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any, Final

import numpy as np
import torch
from numpy.typing import ArrayLike, NDArray

from avod.config import Config
from avod.config.tables import changed_config, differences, table_from_config
from avod.data.build import build_sample
from avod.data.sample import Sample
from avod.device import resolve_device
from avod.model.network import AnyNetwork
from avod.results import detections
from avod.train.checkpoint import read_checkpoint, trained_network
from cadet._util.arrays import as_array
from cadet._util.summary import summary
from cadet.errors import CadetError, ShapeError
from cadet.formats.kitti import Calibration, Frame, Label

_FREE: Final = ("detection.", "rpn.proposals", "rpn.nms_iou", "refinement.passes", "ground")
"""Settings that no weight depends on."""


class Detector:
    """A trained network, ready to detect.

    Args:
        network: a checkpoint's folder, a training's folder, whose last checkpoint is meant, or the name of a packaged
            one; no code of it is run. Or a network, whose weights are those of a training; it is put into evaluation
            mode.
        device: where the network runs; None for a CUDA GPU if there is one, else the CPU.
        precision: of the arithmetic of layers, None for float32.

    Attributes:
        config: the network's configuration, with what `configure` changed for this detector alone.

    Raises:
        MissingFileError: no checkpoint there.
        CadetError: a damaged one, or a device that is unknown, or that this machine lacks.
    """

    config: Config

    def __init__(
        self,
        network: str | Path | AnyNetwork,
        *,
        device: str | torch.device | None = None,
        precision: torch.dtype | None = None,
    ) -> None:
        self.device = resolve_device(device)
        if isinstance(network, str | Path):
            network = trained_network(read_checkpoint(network))
        self.network = network.to(self.device).eval()
        self.network.precision = precision
        self.config = network.config

    def configure(self, changes: Mapping[str, Any]) -> None:
        """Change settings of detection, which no weight depends on, for this detector alone.

        Args:
            changes: tables as a configuration's file has them: `{"detection": {"min_score": 0.3}, "ground": "file"}`.

        Raises:
            CadetError: an unknown key, a value that is refused, or one that training has settled.
        """
        config = changed_config(self.config, changes)
        for name, was, now in differences(table_from_config(self.config), table_from_config(config)):
            if not config.has_camera and name.startswith("rpn."):
                raise CadetError(
                    f"{name}: a center detector has no proposals; detection.min_score and nms_iou change it"
                )
            if not name.startswith(_FREE):
                raise CadetError(f"{name}: expected {was!r}, with which the weights were trained, got {now!r}")
        self.config = config

    def __repr__(self) -> str:
        num_weights = sum(parameter.numel() for parameter in self.network.parameters())
        return summary(self, classes=self.config.class_names, num_weights=num_weights, device=str(self.device))

    def __call__(
        self,
        image: NDArray[np.uint8],
        points_velo: NDArray[np.float32],
        calib: Calibration,
        plane: NDArray[np.float64] | None = None,
    ) -> tuple[Label, ...]:
        """Detect objects in an image (H, W, 3) and a scan (N, 4): see `detect_frames`, which takes batches."""
        return self.detect_frame(Frame(image, points_velo, (), calib, plane))

    def detect(
        self,
        points_velo: NDArray[Any],
        image: NDArray[np.uint8],
        K: ArrayLike,  # noqa: N803 - by its usual name
        cam_from_velo: ArrayLike,
        *,
        plane: NDArray[np.float64] | None = None,
    ) -> tuple[Label, ...]:
        """Detect objects in a point cloud and an image of one pinhole camera.

        Args:
            points_velo: (N, 3) or wider, meters, in the LIDAR's frame; columns past the third are not looked at.
            image: (H, W, 3) uint8 RGB.
            K: (3, 3) intrinsics of the image, as for `cadet.Calibration.from_pinhole`.
            cam_from_velo: (4, 4) or (3, 4), from the LIDAR's frame into the camera's, likewise.
            plane: (4,) ground plane in the camera's frame; it is estimated from the points if None.

        Returns:
            Labels with scores, best first: boxes in the camera's frame.

        Raises:
            ShapeError: an array of another shape or dtype.
            NonFiniteError: NaN or infinity among the points.
            CadetError: a camera that is none, or a plane that is no ground.
        """
        points = as_array(points_velo, "points_velo", ("N", "C"), finite=True)
        if points.shape[1] < 3:
            raise ShapeError(f"points_velo: expected (N, 3) or wider, got {points.shape}")
        xyz0 = np.zeros((len(points), 4), np.float32)
        xyz0[:, :3] = points[:, :3]
        return self.detect_frame(Frame(image, xyz0, (), Calibration.from_pinhole(K, cam_from_velo), plane))

    def detect_frame(self, frame: Frame) -> tuple[Label, ...]:
        """Detect objects in a frame: see `detect_frames`."""
        return self.detect_frames([frame])[0]

    def detect_frames(self, frames: Sequence[Frame]) -> list[tuple[Label, ...]]:
        """Detect objects in frames, all in one pass through the network; their labels are not looked at.

        Args:
            frames: one or more, of any image size that fits their calibration. The ground is that of their plane; it is
                estimated from the points if that is None, or if the configuration's `ground` is "estimated" and they
                show ground.

        Returns:
            Each frame's labels with scores, best first. Without points nothing is found.

        Raises:
            CadetError: a plane that is no ground, or the network's outputs are no numbers.
        """
        if not frames:
            return []
        samples = [build_sample(f.points_velo, f.image, f.calib, f.plane, self.config) for f in frames]
        return self.detect_samples(samples, [frame.calib for frame in frames])

    def detect_samples(self, samples: Sequence[Sample], calibs: Sequence[Calibration]) -> list[tuple[Label, ...]]:
        """Detect objects in samples of this detector's configuration.

        Raises:
            CadetError: the network's outputs are no numbers.
        """
        samples = [sample.to(self.device) for sample in samples]
        return [
            detections(self.network, outputs, sample, calib, self.config)
            for outputs, sample, calib in zip(self.run(samples), samples, calibs, strict=True)
        ]

    def run(self, samples: Sequence[Sample]) -> list[Any]:
        """Run the network on samples that are on its device.

        Raises:
            CadetError: the network's outputs are no numbers.
        """
        with torch.inference_mode():
            found: list[Any] = self.network(samples, config=self.config)
            for sample, outputs in zip(samples, found, strict=True):
                if not outputs.is_finite:
                    raise CadetError(f"frame {sample.frame_id}: the network's outputs are not finite")
        return found
