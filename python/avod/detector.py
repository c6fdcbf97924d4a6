"""A trained detector for frames in memory."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import numpy as np
import torch
from numpy.typing import NDArray

from avod.config import Config
from avod.data.build import build_sample
from avod.data.sample import Sample
from avod.device import resolve_device
from avod.model.network import AvodNetwork, FrameOutputs
from avod.results import detections
from avod.train.checkpoint import read_checkpoint, trained_network
from cadet._util.summary import summary
from cadet.errors import CadetError
from cadet.formats.kitti import Calibration, Label


class Detector:
    """AVOD-FPN, ready to detect.

    Args:
        network: its weights are those of a training; it is put into evaluation mode.
        device: where the network runs.
        precision: of the arithmetic of layers, None for float32.

    Attributes:
        config: the network's configuration, with what `configure` changed for this detector alone.

    Raises:
        CadetError: a device that is unknown, or that this machine lacks.
    """

    config: Config

    def __init__(
        self,
        network: AvodNetwork,
        *,
        device: str | torch.device = "cpu",
        precision: torch.dtype | None = None,
    ) -> None:
        self.device = resolve_device(device)
        self.network = network.to(self.device).eval()
        self.network.precision = precision
        self.config = network.config

    @classmethod
    def load(
        cls,
        path: str | Path,
        *,
        device: str | torch.device = "cpu",
        precision: torch.dtype | None = None,
    ) -> Detector:
        """Load a checkpoint; no code of it is run.

        Args:
            path: its folder, a training's folder, whose last checkpoint is meant, or the name of a packaged one.
            device: where the network runs.
            precision: of the arithmetic of layers, None for float32.

        Raises:
            MissingFileError: no checkpoint there.
            CadetError: a damaged one, or a device that cannot be used.
        """
        device = resolve_device(device)
        return cls(trained_network(read_checkpoint(path)), device=device, precision=precision)

    def configure(
        self, *, proposals: int | None = None, min_score: float | None = None, nms_iou: float | None = None
    ) -> None:
        """Change settings of detection, which no weight depends on; None leaves one as it is.

        Args:
            proposals: that the second stage looks at (`rpn.proposals`).
            min_score: detections below this are left out (`detection.min_score`).
            nms_iou: boxes that overlap a better one by more than this are left out (`detection.nms_iou`).

        Raises:
            CadetError: a number outside its range.
        """
        config = self.config
        rpn = config.rpn if proposals is None else replace(config.rpn, proposals=proposals)
        detection = config.detection
        if min_score is not None:
            detection = replace(detection, min_score=min_score)
        if nms_iou is not None:
            detection = replace(detection, nms_iou=nms_iou)
        self.config = replace(config, rpn=rpn, detection=detection)

    def __repr__(self) -> str:
        num_weights = sum(parameter.numel() for parameter in self.network.parameters())
        return summary(self, classes=self.config.class_names, num_weights=num_weights, device=str(self.device))

    def detect(
        self,
        points_velo: NDArray[np.float32],
        image: NDArray[np.uint8],
        calib: Calibration,
        plane: NDArray[np.float64] | None = None,
    ) -> tuple[Label, ...]:
        """Detect objects in a frame.

        Args:
            points_velo: (N, 4) float32 [x, y, z, intensity], meters, velo frame. Without points nothing is found.
            image: (H, W, 3) uint8 RGB, of any size that fits the calibration.
            calib: the calibration.
            plane: (4,) ground plane in the cam frame; it is estimated from the points if None, or if the
                configuration's `ground` is "estimated" and they show ground.

        Returns:
            Labels with scores, best first.

        Raises:
            ShapeError: an array of another shape or dtype.
            NonFiniteError: NaN or infinity among the points.
            CadetError: a plane that is no ground, or no ground to be found where it is estimated.
        """
        sample = build_sample(points_velo, image, calib, plane, self.config)
        return self.detect_sample(sample, calib)

    def detect_sample(self, sample: Sample, calib: Calibration) -> tuple[Label, ...]:
        """Detect objects in a sample of this detector's configuration.

        Raises:
            CadetError: the network's outputs are no numbers.
        """
        outputs = self.run(sample.to(self.device))
        return detections(outputs, sample.plane.to(self.device), calib, sample.image_size, self.config)

    def run(self, sample: Sample) -> FrameOutputs:
        """Run the network on a sample that is on its device.

        Raises:
            CadetError: the network's outputs are no numbers.
        """
        with torch.inference_mode():
            outputs: FrameOutputs = self.network([sample], config=self.config)[0]
            if not bool(torch.isfinite(outputs.class_logits).all() & torch.isfinite(outputs.box_offsets).all()):
                raise CadetError(f"frame {sample.frame_id}: the network's outputs are not finite")
        return outputs
