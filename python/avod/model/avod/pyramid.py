"""The feature pyramid: an encoder of half VGG-16's width, and a decoder back to full resolution."""

from __future__ import annotations

from torch import Tensor, nn
from torch.nn import functional

from avod.config import ExtractorConfig
from avod.model.layers import Convolution, UpConvolution


class FeaturePyramid(nn.Module):
    """Features of the input's own resolution, made at four scales.

    Rows that the strides do not divide are padded with zeros at the top, which is the far side of a bird's-eye view,
    and cut off again.

    Args:
        num_in: channels of the input.
        config: widths and depths.
    """

    def __init__(self, num_in: int, config: ExtractorConfig) -> None:
        super().__init__()
        self.stride = config.stride
        widths = (num_in, *config.channels)
        self.encoder = nn.ModuleList(
            nn.Sequential(*(Convolution(num_in if k == 0 else num_out, num_out, config) for k in range(depth)))
            for num_in, num_out, depth in zip(widths, config.channels, config.convolutions, strict=False)
        )
        coarse = (config.channels[-1], *config.fused_channels)
        fine = config.channels[-2::-1]
        self.upsample = nn.ModuleList(UpConvolution(a, b, config) for a, b in zip(coarse, fine, strict=False))
        self.fuse = nn.ModuleList(
            Convolution(2 * b, c, config) for b, c in zip(fine, config.fused_channels, strict=True)
        )

    def forward(self, inputs: Tensor) -> Tensor:
        """Map (B, num_in, H, W) to (B, last of fused_channels, H, W)."""
        num_padded = -inputs.shape[2] % self.stride
        features = functional.pad(inputs, (0, 0, num_padded, 0))
        skipped: list[Tensor] = []
        for index, stage in enumerate(self.encoder):
            if index > 0:
                features = functional.max_pool2d(features, 2)
            features = stage(features)
            skipped.append(features)
        skipped.pop()
        for upsample, fuse in zip(self.upsample, self.fuse, strict=True):
            features = fuse(skipped.pop(), upsample(features))
        return features[:, :, num_padded:]
