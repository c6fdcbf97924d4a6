"""Crops against a scalar loop written from the definition; suppression against the greedy rule."""

from __future__ import annotations

import math
from typing import Any

import numpy as np
import pytest
import torch
from hypothesis import given, settings
from hypothesis import strategies as st
from numpy.typing import NDArray

from avod.ops import axis_aligned_iou, crop_and_resize, nms


def scalar_crops(features: NDArray[Any], boxes: NDArray[Any], size: int) -> NDArray[np.float64]:
    """Crop one sample at a time, as tf.image.crop_and_resize is documented to."""
    channels, height, width = features.shape
    crops = np.zeros((len(boxes), channels, size, size))
    for n, (y1, x1, y2, x2) in enumerate(boxes):
        for i in range(size):
            y = y1 * (height - 1) + i * (y2 - y1) * (height - 1) / (size - 1)
            for j in range(size):
                x = x1 * (width - 1) + j * (x2 - x1) * (width - 1) / (size - 1)
                if not (0 <= y <= height - 1 and 0 <= x <= width - 1):
                    continue
                top, left = math.floor(y), math.floor(x)
                bottom, right = math.ceil(y), math.ceil(x)
                upper = features[:, top, left] + (features[:, top, right] - features[:, top, left]) * (x - left)
                lower = features[:, bottom, left] + (features[:, bottom, right] - features[:, bottom, left]) * (
                    x - left
                )
                crops[n, :, i, j] = upper + (lower - upper) * (y - top)
    return crops


CORNER_CASES = [
    [0.0, 0.0, 1.0, 1.0],
    [1.0, 1.0, 0.0, 0.0],  # turned over
    [-0.2, 0.1, 0.5, 1.3],  # partly outside
    [1.5, 1.5, 2.0, 2.0],  # outside
    [0.4, 0.3, 0.4, 0.3],  # a point
    [0.25, 0.5, 0.75, 0.5],  # a line
    [-1e6, -1e6, 1e6, 1e6],
]


@pytest.mark.parametrize("size", [2, 3, 7])
def test_crops_agree_with_the_definition(size: int) -> None:
    rng = np.random.default_rng(0)
    features = rng.normal(size=(3, 9, 13))
    boxes = np.concatenate([np.array(CORNER_CASES), rng.uniform(-0.3, 1.3, (200, 4))])
    found = crop_and_resize(torch.from_numpy(features), torch.from_numpy(boxes), size)
    assert found.shape == (len(boxes), 3, size, size)
    np.testing.assert_allclose(found.numpy(), scalar_crops(features, boxes, size), atol=1e-12)
    single = crop_and_resize(torch.from_numpy(features).float(), torch.from_numpy(boxes).float(), size)
    inside = (boxes >= 0.01).all(axis=1) & (boxes <= 0.99).all(axis=1)  # where rounding cannot cross the border
    np.testing.assert_allclose(single.numpy()[inside], scalar_crops(features, boxes, size)[inside], atol=2e-5)


def test_the_whole_map_is_cropped_onto_itself() -> None:
    features = torch.arange(2 * 5 * 5, dtype=torch.float32).reshape(2, 5, 5)
    assert torch.equal(crop_and_resize(features, torch.tensor([[0.0, 0.0, 1.0, 1.0]]), 5)[0], features)


def test_gradients_of_crops_agree_with_finite_differences() -> None:
    generator = torch.Generator().manual_seed(1)
    features = torch.rand((2, 6, 8), dtype=torch.float64, generator=generator).requires_grad_()
    # No sample may lie on a pixel's center or the border, where the left and the right slope differ.
    boxes = torch.tensor([[0.11, 0.17, 0.73, 0.91], [-0.33, 0.21, 0.64, 1.37]], dtype=torch.float64).requires_grad_()
    assert torch.autograd.gradcheck(lambda f, b: crop_and_resize(f, b, 3), (features, boxes))


def test_crops_of_nothing_and_of_nan() -> None:
    features = torch.rand((2, 6, 8)).requires_grad_()
    assert crop_and_resize(features, torch.zeros((0, 4)), 3).shape == (0, 2, 3, 3)
    boxes = torch.tensor([[math.nan, 0.0, 1.0, 1.0], [math.inf, 0.0, 1.0, 1.0]]).requires_grad_()
    crops = crop_and_resize(features, boxes, 3)
    crops.sum().backward()  # type: ignore[no-untyped-call]
    assert (crops == 0).all()
    assert features.grad is not None and (features.grad == 0).all()


def greedy(boxes: NDArray[Any], scores: NDArray[Any], threshold: float) -> list[int]:
    kept: list[int] = []
    for index in np.argsort(-scores, kind="stable"):
        if all(scalar_iou(boxes[index], boxes[other]) <= threshold for other in kept):
            kept.append(int(index))
    return kept


def scalar_iou(a: NDArray[Any], b: NDArray[Any]) -> float:
    high, wide = min(a[2], b[2]) - max(a[0], b[0]), min(a[3], b[3]) - max(a[1], b[1])
    if high <= 0 or wide <= 0:
        return 0.0
    areas = [(box[2] - box[0]) * (box[3] - box[1]) for box in (a, b)]
    return float(high * wide / (sum(areas) - high * wide))


@settings(deadline=None, max_examples=60)
@given(
    seed=st.integers(0, 2**32 - 1),
    count=st.integers(0, 60),
    threshold=st.sampled_from([0.0, 0.01, 0.3, 0.8, 1.0]),
    max_kept=st.integers(1, 70),
)
def test_suppression_is_greedy(seed: int, count: int, threshold: float, max_kept: int) -> None:
    rng = np.random.default_rng(seed)
    low = rng.uniform(0, 4, (count, 2))
    boxes = np.concatenate([low, low + rng.uniform(0, 3, (count, 2))], axis=1)
    scores = rng.integers(0, 8, count) / 8.0  # many are equal
    found = nms(torch.from_numpy(boxes), torch.from_numpy(scores), threshold, max_kept)
    assert found.tolist() == greedy(boxes, scores, threshold)[:max_kept]


def test_suppression_beyond_one_block_is_greedy() -> None:
    rng = np.random.default_rng(2)
    low = rng.uniform(0, 30, (2600, 2))
    boxes = np.concatenate([low, low + rng.uniform(0.5, 3, (2600, 2))], axis=1)
    scores = rng.uniform(size=2600)
    found = nms(torch.from_numpy(boxes), torch.from_numpy(scores), 0.3, 10_000)
    assert found.tolist() == greedy(boxes, scores, 0.3)


def test_overlap_of_known_boxes() -> None:
    a = torch.tensor([[0.0, 0.0, 2.0, 2.0], [1.0, 1.0, 1.0, 3.0]])
    b = torch.tensor([[1.0, 0.0, 3.0, 2.0], [0.0, 0.0, 2.0, 2.0], [2.0, 0.0, 3.0, 1.0]])
    np.testing.assert_allclose(axis_aligned_iou(a, b), np.array([[1 / 3, 1.0, 0.0], [0.0, 0.0, 0.0]]), atol=1e-7)
