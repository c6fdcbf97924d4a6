"""The layers that both pyramids are made of."""

from __future__ import annotations

import itertools
from typing import cast

import torch
from torch import Tensor, nn
from torch.nn import functional

from avod.config import ExtractorConfig


class ShiftBatchNorm(nn.Module):
    """Batch normalization that learns a shift but no scale, which the next layer would undo.

    Args:
        channels: of the feature map.
        config: decay of the moving averages and epsilon.
    """

    running_mean: Tensor
    running_var: Tensor
    scale: Tensor

    def __init__(self, channels: int, config: ExtractorConfig) -> None:
        super().__init__()
        self.bias = nn.Parameter(torch.zeros(channels))
        self.register_buffer("running_mean", torch.zeros(channels))
        self.register_buffer("running_var", torch.ones(channels))
        # Kernels that take a shift want a scale as well.
        self.register_buffer("scale", torch.ones(channels), persistent=False)
        self.momentum = 1.0 - config.batch_norm_decay
        self.epsilon = config.batch_norm_epsilon

    def forward(self, features: Tensor) -> Tensor:
        """Normalize with the batch's statistics in training, else with the moving averages."""
        return functional.batch_norm(
            features,
            self.running_mean,
            self.running_var,
            self.scale,
            self.bias,
            self.training,
            self.momentum,
            self.epsilon,
        )

    def folded(self) -> tuple[Tensor, Tensor]:
        """Return the scale and the shift of each channel that normalising by the moving averages comes to."""
        scale = torch.rsqrt(self.running_var + self.epsilon)
        return scale, self.bias - self.running_mean * scale


class Convolution(nn.Module):
    """Convolution without bias; then batch normalization and ReLU.

    Args:
        num_in: channels that come in.
        num_out: channels that go out.
        config: of the batch normalization.
        kernel: side of the kernel, odd.
        stride: 1 keeps the size, 2 halves it.
    """

    def __init__(self, num_in: int, num_out: int, config: ExtractorConfig, kernel: int = 3, stride: int = 1) -> None:
        super().__init__()
        self.convolution = nn.Conv2d(num_in, num_out, kernel, stride, padding=kernel // 2, bias=False)
        self.norm = ShiftBatchNorm(num_out, config)
        nn.init.xavier_uniform_(self.convolution.weight)

    def forward(self, *features: Tensor) -> Tensor:
        """Map one or more (B, c, H, W), whose channels are `num_in` together, to (B, num_out, H / s, W / s)."""
        if self.training:
            return functional.relu_(cast("Tensor", self.norm(self._convolved(features, self.convolution.weight))))
        scale, shift = self.norm.folded()
        return functional.relu_(self._convolved(features, self.convolution.weight * scale[:, None, None, None], shift))

    def _convolved(self, features: tuple[Tensor, ...], weight: Tensor, bias: Tensor | None = None) -> Tensor:
        # The sum over maps equals the convolution of their concatenation, which is never made.
        weights = torch.split(weight, [part.shape[1] for part in features], dim=1)
        stride, padding = self.convolution.stride, self.convolution.padding
        convolved = functional.conv2d(features[0], weights[0], bias, stride, padding)
        for part, its_weight in zip(features[1:], weights[1:], strict=True):
            convolved = convolved.add_(functional.conv2d(part, its_weight, None, stride, padding))
        return convolved


class UpConvolution(nn.Module):
    """Transposed 3 x 3 convolution of stride 2 without bias; then batch normalization and ReLU.

    Pixel i of the input goes to pixels 2 i, 2 i + 1 and 2 i + 2 of the output, which is trimmed at its end to twice the
    size: TensorFlow's "SAME". PyTorch's usual padding of 1 would shift it by one pixel.

    Args:
        num_in: channels that come in.
        num_out: channels that go out.
        config: of the batch normalization.
    """

    def __init__(self, num_in: int, num_out: int, config: ExtractorConfig) -> None:
        super().__init__()
        self.convolution = nn.ConvTranspose2d(num_in, num_out, 3, stride=2, bias=False)
        self.norm = ShiftBatchNorm(num_out, config)
        nn.init.xavier_uniform_(self.convolution.weight)

    def forward(self, features: Tensor) -> Tensor:
        """Map (B, num_in, H, W) to (B, num_out, 2 H, 2 W)."""
        if self.training:
            return functional.relu_(cast("Tensor", self.norm(self._grown(features, self.convolution.weight))))
        scale, shift = self.norm.folded()
        return functional.relu_(self._grown(features, self.convolution.weight * scale[:, None, None], shift))

    @staticmethod
    def _grown(features: Tensor, weight: Tensor, bias: Tensor | None = None) -> Tensor:
        # A row and a column of zeros before the input, and four pixels less before the output, for a trimmed end: a
        # slice of the output would be no contiguous memory, and what follows would be slow.
        padded = functional.pad(features, (1, 0, 1, 0))
        return functional.conv_transpose2d(padded, weight, bias, stride=2, padding=2, output_padding=1)


class Dropout(nn.Module):
    """Dropout from uniform numbers, which PyTorch draws on a CPU four times as fast as its own Bernoulli ones.

    Args:
        keep: probability of keeping a unit in training.
    """

    def __init__(self, keep: float) -> None:
        super().__init__()
        self.keep = keep

    def forward(self, values: Tensor) -> Tensor:
        """Zero some units in training and scale the others up; else change nothing."""
        if not self.training or self.keep >= 1.0:
            return values
        if values.device.type != "cpu":
            return functional.dropout(values, 1.0 - self.keep)
        return values * (torch.rand(values.shape) < self.keep) * (1.0 / self.keep)


class Head(nn.Module):
    """Fully connected layers with ReLU and dropout, ended by linear outputs of one or more sizes.

    Args:
        num_in: numbers that come in.
        hidden: widths of the hidden layers.
        num_out: widths of the outputs, each from the last hidden layer.
        dropout_keep: probability of keeping a hidden unit in training.
    """

    def __init__(self, num_in: int, hidden: tuple[int, ...], num_out: tuple[int, ...], dropout_keep: float) -> None:
        super().__init__()
        widths = (num_in, *hidden)
        self.layers = nn.ModuleList(nn.Linear(a, b) for a, b in itertools.pairwise(widths))
        self.outputs = nn.ModuleList(nn.Linear(widths[-1], count) for count in num_out)
        self.dropout = Dropout(dropout_keep)
        for layer in (*self.layers, *self.outputs):
            assert isinstance(layer, nn.Linear)
            nn.init.xavier_uniform_(layer.weight)
            nn.init.zeros_(layer.bias)

    def forward(self, values: Tensor) -> tuple[Tensor, ...]:
        """Map (N, num_in) to one (N, k) for each output."""
        for layer in self.layers:
            values = self.dropout(functional.relu(layer(values)))
        return tuple(output(values) for output in self.outputs)
