"""Making the network that a configuration asks for."""

from __future__ import annotations

from typing import Final

import torch

from avod.config import Config
from avod.model.avod.network import AvodNetwork
from avod.model.center.network import CenterNetwork
from avod.model.network import AnyNetwork

_KINDS: Final[dict[str, type[AnyNetwork]]] = {"avod": AvodNetwork, "center": CenterNetwork}


def make_network(config: Config) -> AnyNetwork:
    """Make the network of a configuration, its weights drawn from PyTorch's own generator."""
    # Channels last is what convolutions on processors with bf16 and on GPUs like, and what crops read.
    return _KINDS[config.network](config).to(memory_format=torch.channels_last)


def abstract_network(config: Config) -> AnyNetwork:
    """Make a network of shapes alone, on PyTorch's "meta" device: its weights take no memory."""
    with torch.device("meta"):
        return make_network(config)
