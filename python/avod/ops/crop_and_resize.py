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
    indices = _by_sample([row[:, None] * width + column for row in rows for column in columns])
    weights = _by_sample([row[:, None] * column for row in row_weights for column in column_weights])
    # Pixels are the rows of an embedding; a sample is the weighted sum of its four neighbors.
    pixels = features.permute(1, 2, 0).reshape(height * width, channels).to(boxes.dtype)
    samples = functional.embedding_bag(indices, pixels, per_sample_weights=weights, mode="sum")
    return samples.reshape(len(boxes), size, size, channels).permute(0, 3, 1, 2)


def _neighbors(low: Tensor, high: Tensor, num_pixels: int, size: int) -> tuple[list[Tensor], list[Tensor]]:
    """Find the two pixels beside each sample of an axis: their indices and weights, each (size, N); 0 outside."""
    steps = torch.arange(size, dtype=low.dtype, device=low.device)[:, None]
    last = num_pixels - 1
    samples = low * last + steps * ((high - low) * last / (size - 1))
    is_inside = (samples >= 0) & (samples <= last)
    # Zeros in place of what is outside, so that neither values nor gradients of NaN and infinity come in.
    samples = torch.where(is_inside, samples, torch.zeros_like(samples))
    floor = samples.detach().floor()
    share = samples - floor
    index = floor.int()
    return [index, (index + 1).clamp(max=last)], [(1.0 - share) * is_inside, share * is_inside]


def _by_sample(neighbors: list[Tensor]) -> Tensor:
    """Bring four (size, size, N) to (N * size * size, 4): loops over boxes are long, over a crop's samples short."""
    return torch.stack(neighbors, dim=-1).permute(2, 0, 1, 3).reshape(-1, 4)
