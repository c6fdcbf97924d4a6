"""Samples on their way from one process to another: maps of the bird's-eye view are nearly all zeros."""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np
import torch
from torch import Tensor

from avod.data.sample import Sample

_PAIR = 2


@dataclass(frozen=True, eq=False)
class PackedSample:
    """A sample whose maps are written down where they are not zero.

    Attributes:
        rest: the sample, without maps.
        shape: (C, H, W) of the maps.
        pairs: (K,) int32, which pairs of neighboring cells have a value in some map.
        values: (C, K, 2) float32, of those.
    """

    rest: Sample
    shape: tuple[int, int, int]
    pairs: Tensor
    values: Tensor

    def pin_memory(self) -> PackedSample:
        """Return the sample in page-locked memory, from where it travels to a GPU faster."""
        return replace(
            self, rest=self.rest.pin_memory(), pairs=self.pairs.pin_memory(), values=self.values.pin_memory()
        )

    def unpacked(self, device: torch.device) -> Sample:
        """Return the sample as it was, on a device."""
        channels, rows, columns = self.shape
        bev = torch.zeros((channels, -(-rows * columns // _PAIR), _PAIR), device=device)
        bev[:, self.pairs.to(device, non_blocking=True).long()] = self.values.to(device, non_blocking=True)
        maps = bev.view(channels, -1)[:, : rows * columns]
        return replace(self.rest.to(device), bev=maps.reshape(self.shape))


def packed(sample: Sample) -> PackedSample:
    """Pack a sample; nothing of it keeps the memory of the sample's maps."""
    channels, rows, columns = sample.bev.shape
    maps = sample.bev.numpy().reshape(channels, -1)
    if rows * columns % _PAIR:
        maps = np.pad(maps, ((0, 0), (0, 1)))
    # Pairs of float32 as one integer: a quarter of the time that comparing floats takes.
    whole = maps.view(np.uint64)
    pairs = np.flatnonzero(np.bitwise_or.reduce(whole, axis=0))
    return PackedSample(
        replace(sample, bev=sample.bev.new_empty(0)),
        (channels, rows, columns),
        torch.from_numpy(pairs.astype(np.int32)),
        torch.from_numpy(whole.take(pairs, axis=1).view(np.float32).reshape(channels, -1, _PAIR)),
    )


def on_device(sample: Sample | PackedSample, device: torch.device) -> Sample:
    """Bring a sample to a device, unpacked."""
    return sample.unpacked(device) if isinstance(sample, PackedSample) else sample.to(device)
