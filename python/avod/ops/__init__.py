"""Tensor operations that PyTorch lacks: crops as TensorFlow takes them, suppression of the lesser boxes."""

from avod.ops.crop_and_resize import crop_and_resize
from avod.ops.nms import axis_aligned_iou, nms

__all__ = ["axis_aligned_iou", "crop_and_resize", "nms"]
