"""Path drop: in training, a frame may lose its image or its bird's-eye view, never both."""

from __future__ import annotations

import torch
from torch import Tensor

from avod.config import PathDropConfig


def draw_masks(config: PathDropConfig, generator: torch.Generator) -> tuple[float, float]:
    """Draw which modalities a frame keeps.

    Args:
        config: the probabilities.
        generator: on the CPU; three numbers are taken from it.

    Returns:
        (image, bird's-eye view), each 0 or 1, at least one of them 1.
    """
    image, bev, coin = torch.rand(3, generator=generator).tolist()
    has_image, has_bev = image < config.keep_image, bev < config.keep_bev
    if not has_image and not has_bev:
        has_image = coin > 0.5
        has_bev = not has_image
    return float(has_image), float(has_bev)


def detection_masks(config: PathDropConfig) -> tuple[float, float]:
    """Return what detection sees: both modalities, except one that training never kept."""
    image, bev = float(config.keep_image > 0.0), float(config.keep_bev > 0.0)
    return (image, bev) if image + bev > 0.0 else (1.0, 1.0)


def fuse(image_crops: Tensor, bev_crops: Tensor, masks: tuple[float, float]) -> Tensor:
    """Average the crops of the modalities that are kept."""
    image, bev = masks
    return (image_crops * image + bev_crops * bev) / (image + bev)
