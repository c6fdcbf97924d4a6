"""Axis-aligned boxes: overlap, and suppression of the lesser ones."""

from __future__ import annotations

import torch
from torch import Tensor

_LARGEST_BLOCK = 1024


def axis_aligned_iou(a: Tensor, b: Tensor) -> Tensor:
    """Compute the intersection over union of each pair of boxes.

    Args:
        a: (N, 4) [y1, x1, y2, x2] in any unit. May be empty.
        b: (M, 4) likewise.

    Returns:
        (N, M) in [0, 1]; 0 where a box has no area.
    """
    overlap = _shared(a, b, 0).mul_(_shared(a, b, 1))
    union = _areas(a)[:, None] + _areas(b)[None, :] - overlap
    return torch.where(overlap > 0.0, overlap / union.clamp(min=torch.finfo(union.dtype).tiny), 0.0)


def nms(boxes: Tensor, scores: Tensor, iou_threshold: float, max_kept: int) -> Tensor:
    """Keep the boxes that no kept box of higher score overlaps by more than a threshold.

    Exactly the greedy rule, a block of boxes at a time, small blocks first, as few may suffice: a block is compared
    with all boxes kept so far, and within itself the greedy choice is found as the fixed point of "kept if no kept
    better box overlaps", which is reached from all-kept after as many rounds as the longest chain of suppressions has
    links.

    Args:
        boxes: (N, 4) [y1, x1, y2, x2] in any unit. May be empty.
        scores: (N,), higher is better; of equal scores the first is better.
        iou_threshold: boxes of exactly this overlap are both kept.
        max_kept: no more than this many are kept.

    Returns:
        (K,) int64 indices of the kept boxes, best first.
    """
    boxes, scores = boxes.detach(), scores.detach()
    order = torch.argsort(scores, descending=True, stable=True)
    kept, start, size = order[:0], 0, 2 * max_kept
    while start < len(order) and len(kept) < max_kept:
        size = min(size, _LARGEST_BLOCK)
        block = order[start : start + size]
        start, size = start + size, 2 * size
        if len(kept) > 0:
            is_free = ~(axis_aligned_iou(boxes[block], boxes[kept]) > iou_threshold).any(dim=1)
            block = block[is_free]
        kept = torch.cat([kept, block[_greedy(boxes[block], iou_threshold)]])
    return kept[:max_kept]


def _greedy(boxes: Tensor, iou_threshold: float) -> Tensor:
    """Tell which boxes of a block, best first, the greedy rule keeps: (N,) bool."""
    suppresses = (axis_aligned_iou(boxes, boxes) > iou_threshold).triu(diagonal=1)
    is_kept = torch.ones(len(boxes), dtype=torch.bool, device=boxes.device)
    while True:
        now_kept = ~(suppresses & is_kept[:, None]).any(dim=0)
        if torch.equal(now_kept, is_kept):
            return is_kept
        is_kept = now_kept


def _shared(a: Tensor, b: Tensor, axis: int) -> Tensor:
    """Compute the length that each pair of boxes shares along an axis: (N, M)."""
    high = torch.minimum(a[:, None, axis + 2], b[None, :, axis + 2])
    return high.sub_(torch.maximum(a[:, None, axis], b[None, :, axis])).clamp_(min=0.0)


def _areas(boxes: Tensor) -> Tensor:
    return (boxes[:, 2:] - boxes[:, :2]).clamp(min=0.0).prod(dim=-1)
