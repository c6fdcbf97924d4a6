"""Training by several processes, as `torchrun` starts them."""

from __future__ import annotations

import os
from dataclasses import dataclass

import torch
from torch import distributed, nn
from torch.nn.parallel import DistributedDataParallel


@dataclass(frozen=True)
class Processes:
    """This process among the others of a training.

    Attributes:
        rank: this process, from 0.
        world_size: how many there are.
    """

    rank: int = 0
    world_size: int = 1

    @classmethod
    def current(cls) -> Processes:
        """Join the others if `torchrun` started this process; else it is alone."""
        world_size = int(os.environ.get("WORLD_SIZE", "1"))
        if world_size == 1:
            return cls()
        if not distributed.is_initialized():
            distributed.init_process_group("nccl" if torch.cuda.is_available() else "gloo")
        return cls(distributed.get_rank(), world_size)

    @property
    def is_first(self) -> bool:
        """Whether this process writes log and checkpoints."""
        return self.rank == 0

    def wrap(self, network: nn.Module) -> nn.Module:
        """Let gradients be averaged over all processes."""
        if self.world_size == 1:
            return network
        return DistributedDataParallel(network)
