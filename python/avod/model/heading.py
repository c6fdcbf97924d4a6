"""The heading of objects, by their points as the sensor sees them.

Seen along the line of sight an object from behind always looks alike, which it does not in the frame of a found box,
whose heading may be any.
"""

from __future__ import annotations

import math
from typing import Final, cast

import torch
from torch import Tensor, nn

from avod.config import RefinementConfig
from avod.model.box_points import BoxPoints, PointLayers, turned
from avod.model.layers import Head
from avod.model.parts import EXAMPLE_ROWS, Part

NUM_HEADINGS: Final = 12
"""Observation angles (KITTI's alpha) that are told apart, evenly from 0 on."""
_SHARPNESS: Final = 8.0
"""Of what is wanted of them: the greater, the less of it lies beside the true one."""
_MARGIN_M: Final = 0.35
_LOWEST_M: Final = 0.1
"""Points farther from the box or nearer to the ground are of something else."""
_WAVES_PER_M: Final = (4.0, 10.0)
"""Of sines and cosines of places, in radians: shapes of a few centimeters are learned sooner by them."""
_POINT_FEATURES: Final = 3 * (1 + 2 * len(_WAVES_PER_M))
_BOX_FEATURES: Final = 7


class PointHeading(nn.Module):
    """Tells where the objects in boxes are headed.

    Args:
        config: of the stage that corrects boxes.

    Reference: Tancik et al., "Fourier Features Let Networks Learn High Frequency Functions" (NeurIPS 2020).
    """

    def __init__(self, config: RefinementConfig) -> None:
        super().__init__()
        self.max_points = config.max_points
        self.points = PointLayers(_POINT_FEATURES, config.channels)
        self.head = Head(config.channels[-1] + _BOX_FEATURES, config.hidden, (NUM_HEADINGS,), 1.0)

    def forward(self, near: BoxPoints, boxes_cam: Tensor, seen: Tensor) -> Tensor:
        """Judge boxes (N, 7) by the points near them, and by `box_features` (N, 9): (N, 12) logits, as `judge`."""
        half = boxes_cam[near.box, 3:5] / 2.0 + _MARGIN_M
        is_inside = (near.along.abs() < half[:, 0]) & (near.across.abs() < half[:, 1])
        body = near.where(is_inside & (near.height > _LOWEST_M)).at_most(self.max_points)
        bearing = _bearing(boxes_cam)
        cos, sin = turned(torch.sin(bearing), torch.cos(bearing), boxes_cam[:, 6])
        cos, sin = cos[body.box], sin[body.box]
        away, aside = cos * body.along + sin * body.across, cos * body.across - sin * body.along
        places = torch.stack([away, aside, body.height], dim=1)
        # What is left out tells where the box is headed, which the points are to say.
        return self.judge(places, body.box, torch.cat([seen[:, :1], seen[:, 3:]], dim=1))

    def judge(self, places: Tensor, box: Tensor, seen: Tensor) -> Tensor:
        """Run the layers.

        Args:
            places: (P, 3) of points from the box's center, away from the sensor and across, and over the ground.
            box: (P,) int64, whose point it is.
            seen: (N, 7) features of boxes that say nothing of their headings.

        Returns:
            (N, 12) logits of observation angles.
        """
        waves = [wave for rate in _WAVES_PER_M for wave in (torch.sin(rate * places), torch.cos(rate * places))]
        whole = self.points(torch.cat([places, *waves], dim=1), box, seen)
        (logits,) = cast("tuple[Tensor]", self.head(whole))
        return logits

    def part(self) -> Part:
        """Describe what `judge` computes."""
        inputs = {
            "places": torch.zeros((EXAMPLE_ROWS, 3)),
            "box": torch.zeros(EXAMPLE_ROWS, dtype=torch.int64),
            "seen": torch.zeros((EXAMPLE_ROWS, _BOX_FEATURES)),
        }
        return Part("heading", lambda *values: (self.judge(*values),), inputs, ("heading_logits",), has_rows=True)


def reversals(reversed_logits: Tensor, boxes_cam: Tensor) -> Tensor:
    """Turn logits (N,) of whether the front is the rear of boxes (N, 7) into logits (N, 12) of observation angles."""
    apart = _angles(reversed_logits) - (boxes_cam[:, 6] - _bearing(boxes_cam))[:, None]
    return -0.5 * reversed_logits[:, None] * torch.cos(apart)


def heading_loss(logits: Tensor, boxes_cam: Tensor) -> Tensor:
    """Compute the cross entropies of (N, 12) logits and the observation angles of true boxes (N, 7): (N,)."""
    alphas = boxes_cam[:, 6] - _bearing(boxes_cam)
    wanted = torch.softmax(_SHARPNESS * torch.cos(alphas[:, None] - _angles(logits)), dim=1)
    return -(wanted * torch.log_softmax(logits, dim=1)).sum(dim=1)


def heading_vectors(logits: Tensor, boxes_cam: Tensor) -> Tensor:
    """Give the mean direction of headings as [cos, sin] of rotation_y, of any length: (N, 12) and (N, 7) to (N, 2)."""
    rotations_y = _angles(logits) + _bearing(boxes_cam)[:, None]
    units = torch.stack([torch.cos(rotations_y), torch.sin(rotations_y)], dim=2)
    return (torch.softmax(logits, dim=1)[:, :, None] * units).sum(dim=1)


def _angles(logits: Tensor) -> Tensor:
    return torch.arange(NUM_HEADINGS, device=logits.device) * (2.0 * math.pi / NUM_HEADINGS)


def _bearing(boxes_cam: Tensor) -> Tensor:
    """Give the angle of the line of sight, by which rotation_y exceeds the observation angle."""
    return torch.atan2(boxes_cam[:, 0], boxes_cam[:, 2])
