"""Crops of a feature map as TensorFlow takes them: one bilinear sample a bin, corners on corners."""

from __future__ import annotations

import torch
from torch import Tensor
from torch.nn import functional


def crop_and_resize(features: Tensor, boxes: Tensor, size: int) -> Tensor:
    """Crop boxes out of a feature map, each resized to `size` x `size`.

    Sample i of a box lies at y1 (H - 1) + i (y2 - y1) (H - 1) / (size - 1), so 0 and 1 are the centers of the first and
    the last pixel. A sample outside the map is 0 as a whole: nothing blends with a border. Differentiable in both
    arguments.

    Args:
        features: (C, H, W) floats.
        boxes: (N, 4) [y1, x1, y2, x2], in fractions of the map, at least float32. May be empty, and may reach beyond
            the map; NaN samples count as outside.
        size: samples along each axis, at least 2.

    Returns:
        (N, C, size, size) in the boxes' dtype.

    Reference: tf.image.crop_and_resize, method "bilinear", extrapolation_value 0.
    """
    channels, height, width = features.shape
    rows, row_weights = _neighbors(boxes[:, 0], boxes[:, 2], height, size)
    columns, column_weights = _neighbors(boxes[:, 1], boxes[:, 3], width, size)
    indices = rows[:, :, None, :, None] * width + columns[:, None, :, None, :]
    weights = row_weights[:, :, None, :, None] * column_weights[:, None, :, None, :]
    # Pixels are the rows of an embedding; a sample is the weighted sum of its four neighbors.
    pixels = features.permute(1, 2, 0).reshape(height * width, channels).to(boxes.dtype)
    samples = functional.embedding_bag(
        indices.reshape(-1, 4), pixels, per_sample_weights=weights.reshape(-1, 4), mode="sum"
    )
    return samples.reshape(len(boxes), size, size, channels).permute(0, 3, 1, 2)


def _neighbors(low: Tensor, high: Tensor, num_pixels: int, size: int) -> tuple[Tensor, Tensor]:
    """Find the two pixels beside each sample of an axis: (N, size, 2) indices and weights, 0 for samples outside."""
    steps = torch.arange(size, dtype=low.dtype, device=low.device)
    last = num_pixels - 1
    samples = low[:, None] * last + steps * ((high - low) * last / (size - 1))[:, None]
    is_inside = (samples >= 0) & (samples <= last)
    # Zeros in place of what is outside, so that neither values nor gradients of NaN and infinity come in.
    samples = torch.where(is_inside, samples, torch.zeros_like(samples))
    floor = samples.detach().floor()
    share = samples - floor
    weights = torch.stack([1.0 - share, share], dim=-1) * is_inside[..., None]
    index = floor.long()
    return torch.stack([index, (index + 1).clamp(max=last)], dim=-1), weights
