"""Every number of the detector and its training, by default AVOD-FPN's for cars: frozen, checked when made."""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping
from dataclasses import dataclass, field
from functools import partial
from pathlib import Path
from typing import Annotated, Any, Final, Literal

from avod.config.augmentation import AugmentationConfig
from avod.config.base import CONFIGS, with_base
from avod.config.center import CenterConfig
from avod.config.limits import MAX_ANCHORS, MAX_LAYERS, MAX_PIXELS
from avod.config.refinement import RefinementConfig
from avod.config.training import TrainingConfig
from cadet._util.checks import Limits, check_fields, shown
from cadet._util.plain_tables import object_of_table
from cadet._util.toml_file import NamedFile
from cadet.bev import BevConfig
from cadet.errors import CadetError
from cadet.formats.kitti.label import is_object_type, kitti_spelling

Size = tuple[float, float, float]

CAR_SIZES: Final[tuple[Size, ...]] = ((3.514, 1.581, 1.511), (4.236, 1.653, 1.547))
"""Two clusters (l, w, h) of KITTI's cars, meters."""


@dataclass(frozen=True, kw_only=True)
class ObjectClass:
    """A class to detect, and the sizes that its anchors take.

    Raises:
        CadetError: what can be no object's type, no size, or one that is not positive.
    """

    name: str = "Car"
    """The type of the labels."""
    anchor_sizes_lwh_m: Annotated[tuple[Size, ...], Limits(0.01, 50)] = CAR_SIZES
    """Length, width and height of each cluster."""

    def __post_init__(self) -> None:
        if not is_object_type(self.name):
            raise CadetError(f"ObjectClass.name: expected a type of labels such as Car, got {shown(self.name)}")
        object.__setattr__(self, "name", kitti_spelling(self.name))
        if not self.anchor_sizes_lwh_m:
            raise CadetError("ObjectClass.anchor_sizes_lwh_m: expected at least one size, got none")
        check_fields(self)


@dataclass(frozen=True, kw_only=True)
class ImageConfig:
    """How the camera image reaches the network.

    Raises:
        CadetError: a number outside its range, or more than `MAX_PIXELS` pixels.
    """

    size: Annotated[tuple[int, int], Limits(8, 8192)] = (1200, 360)
    """Width and height in pixels after resizing; the aspect ratio is not kept."""
    mean_rgb: Annotated[tuple[float, float, float], Limits(0, 255)] = (92.8403, 97.7996, 93.5843)
    """Taken off each channel of 0..255; nothing is divided."""

    def __post_init__(self) -> None:
        check_fields(self)
        if math.prod(self.size) > MAX_PIXELS:
            raise CadetError(f"ImageConfig.size: expected at most {MAX_PIXELS:,} pixels, got {self.size!r}")


@dataclass(frozen=True, kw_only=True)
class AnchorConfig:
    """The grid of anchors on the ground plane, over the extent of the bird's-eye view.

    Raises:
        CadetError: a number outside its range.
    """

    stride_m: Annotated[float, Limits(0.05, 20)] = 0.5
    """Between neighbors, in x and in z."""
    min_height_m: Annotated[float, Limits(-100, 100)] = 0.2
    """Points from this height over the ground plane up make a cell occupied ..."""
    max_height_m: Annotated[float, Limits(-100, 100)] = 2.0
    """... and points from this height up do not."""
    min_occupied_cells: Annotated[int, Limits(0)] = 1
    """Anchors over fewer occupied cells are dropped."""

    def __post_init__(self) -> None:
        check_fields(self)
        if self.min_height_m >= self.max_height_m:
            raise CadetError(
                f"AnchorConfig.max_height_m: expected more than {self.min_height_m:g}, got {self.max_height_m!r}"
            )


@dataclass(frozen=True, kw_only=True)
class ExtractorConfig:
    """The feature pyramid, made twice: for the bird's-eye view and for the image.

    Raises:
        CadetError: tuples that do not fit each other, or a number outside its range.
    """

    channels: Annotated[tuple[int, ...], Limits(1, 4096)] = (32, 64, 128, 256)
    """Of each stage of the encoder; a 2 x 2 max pooling lies between two stages."""
    convolutions: Annotated[tuple[int, ...], Limits(1, 32)] = (2, 2, 3, 3)
    """In each stage of the encoder."""
    fused_channels: Annotated[tuple[int, ...], Limits(1, 4096)] = (64, 32, 32)
    """Of the decoder after each fusion, from coarse to fine; the last is what the heads see."""
    batch_norm_decay: Annotated[float, Limits(0, 1)] = 0.999
    """Of the moving averages; PyTorch's momentum is 1 less this."""
    batch_norm_epsilon: Annotated[float, Limits(1e-12, 1)] = 1e-3
    """Added to the variance."""

    def __post_init__(self) -> None:
        if not 2 <= len(self.channels) <= MAX_LAYERS or len(self.convolutions) != len(self.channels):
            raise CadetError(
                f"ExtractorConfig.convolutions: expected one number for each of 2 to {MAX_LAYERS} stages, "
                f"got {len(self.convolutions)} for {len(self.channels)}"
            )
        if len(self.fused_channels) != len(self.channels) - 1:
            raise CadetError(
                f"ExtractorConfig.fused_channels: expected {len(self.channels) - 1}, got {len(self.fused_channels)}"
            )
        check_fields(self)

    @property
    def stride(self) -> int:
        """How many pixels of the input one pixel of the coarsest stage covers, along each axis."""
        return int(2 ** (len(self.channels) - 1))


@dataclass(frozen=True, kw_only=True)
class PathDropConfig:
    """How often a modality is kept in training; if both would be dropped, a fair coin keeps one.

    Raises:
        CadetError: a number outside 0..1.
    """

    keep_image: Annotated[float, Limits(0, 1)] = 0.9
    """Probability of keeping the image."""
    keep_bev: Annotated[float, Limits(0, 1)] = 0.9
    """Probability of keeping the bird's-eye view."""

    def __post_init__(self) -> None:
        check_fields(self)


@dataclass(frozen=True, kw_only=True)
class RpnConfig:
    """The region proposal network.

    Raises:
        CadetError: a number outside its range.
    """

    crop_size: Annotated[int, Limits(2, 64)] = 3
    """Samples of a crop along each axis."""
    bottleneck_channels: Annotated[int, Limits(1, 1024)] = 1
    """Channels that the first stage sees of each modality's feature map: AVOD's 1."""
    hidden: Annotated[int, Limits(1, 65536)] = 256
    """Width of both hidden layers of each head."""
    dropout_keep: Annotated[float, Limits(0.01, 1)] = 0.5
    """Probability of keeping a unit of the hidden layers."""
    nms_iou: Annotated[float, Limits(0, 1)] = 0.8
    """Proposals that overlap a better one by more than this, seen from above, are dropped."""
    train_proposals: Annotated[int, Limits(1)] = 1024
    """Proposals kept in training."""
    proposals: Annotated[int, Limits(1)] = 300
    """Proposals kept in detection: AVOD's 300 for cars, 1024 for people."""
    batch_size: Annotated[int, Limits(2)] = 512
    """Anchors that the loss samples; at most half are positive."""
    negative_iou: Annotated[float, Limits(0, 1)] = 0.3
    """Anchors that overlap every object by less than this are negative ..."""
    positive_iou: Annotated[float, Limits(0, 1)] = 0.5
    """... and those that overlap one by more than this positive."""
    regression_weight: Annotated[float, Limits(0)] = 5.0
    """Of the box loss against the objectness loss."""

    def __post_init__(self) -> None:
        check_fields(self)
        _check_order("RpnConfig", self.negative_iou, self.positive_iou)


@dataclass(frozen=True, kw_only=True)
class SecondStageConfig:
    """The network that classifies and refines proposals.

    Raises:
        CadetError: a number outside its range.
    """

    crop_size: Annotated[int, Limits(2, 64)] = 7
    """Samples of a crop along each axis."""
    hidden: Annotated[tuple[int, ...], Limits(1, 65536)] = (2048, 2048, 2048)
    """Widths of the hidden layers."""
    dropout_keep: Annotated[float, Limits(0.01, 1)] = 0.5
    """Probability of keeping a unit of the hidden layers."""
    gradient: Literal["through", "stopped"] = "through"
    """Whether the second stage's losses reach the first through its boxes, as in AVOD, or only through features."""
    batch_size: Annotated[int, Limits(2)] = 1024
    """Proposals that the loss samples; at most half are positive."""
    truth_proposals: Annotated[int, Limits(0, 1024)] = 0
    """Copies of each true box, moved and scaled a little, that join the proposals in training: with them the second
    stage learns before the first finds objects. Faster R-CNN's implementations add the boxes as they are."""
    truth_steps: Annotated[int, Limits(0)] = 0
    """They join in so many steps from the first; after them the second stage sees what it will see in detection."""
    negative_iou: Annotated[float, Limits(0, 1)] = 0.55
    """Proposals that overlap every object by less than this are background ..."""
    positive_iou: Annotated[float, Limits(0, 1)] = 0.65
    """... and those that overlap one by more than this carry its class."""
    regression_weight: Annotated[float, Limits(0)] = 5.0
    """Of the box loss against the class loss."""
    orientation_weight: Annotated[float, Limits(0)] = 1.0
    """Of the loss of the angle vector."""

    def __post_init__(self) -> None:
        check_fields(self)
        if len(self.hidden) > MAX_LAYERS:
            raise CadetError(f"SecondStageConfig.hidden: expected at most {MAX_LAYERS} layers, got {len(self.hidden)}")
        _check_order("SecondStageConfig", self.negative_iou, self.positive_iou)


@dataclass(frozen=True, kw_only=True)
class DetectionConfig:
    """What becomes of the second stage's boxes.

    Raises:
        CadetError: a number outside its range.
    """

    nms_iou: Annotated[float, Limits(0, 1)] = 0.01
    """Boxes that overlap a better one by more than this, seen from above and turned to the axes, are dropped."""
    suppression: Literal["all", "class"] = "all"
    """Whether a box drops those of all classes, as in AVOD, or those of its own class alone: a pedestrian beside a car
    overlaps it once both are turned to the axes."""
    classes_by_length: bool = False
    """Let the length of a box that the last stage corrected say which class it is of: a cyclist is often found as a
    pedestrian, too, and both boxes are corrected onto one object. For classes whose lengths differ much."""
    max_detections: Annotated[int, Limits(1)] = 100
    """Boxes kept in a frame."""
    min_score: Annotated[float, Limits(0, 1)] = 0.1
    """Detections below this are not written."""
    max_image_fraction: Annotated[float, Limits(0, 1)] = 0.8
    """Detections wider or higher than this share of the image, before clipping, are not written, as in AVOD; 0 for no
    such limit: what is near and cut off by the image's edge is wide."""
    flip: bool = False
    """Look at the mirrored frame, too: boxes that are found in both become their mean, others lose half of their score.
    Needs maps that reach as far to the left as to the right."""
    fix_up: Literal["corrected", "reference"] = "corrected"
    """How the angle vector chooses among a box's four headings: right, or with AVOD's wrong sign at +-90 degrees."""

    def __post_init__(self) -> None:
        check_fields(self)


@dataclass(frozen=True, kw_only=True)
class Config(NamedFile):
    """A detector and its training.

    Raises:
        CadetError: no class, one twice, inputs that the extractor's strides do not divide, more than `MAX_PIXELS` cells
            or `MAX_ANCHORS` anchors.
    """

    _KIND = "configuration"

    classes: tuple[ObjectClass, ...] = (ObjectClass(),)
    """Classes to detect; class k of the network is the k-th, 0 is background."""
    network: Literal["avod", "center"] = "avod"
    """AVOD-FPN, or a network that marks objects' centers in the maps; that has no use for the settings from `image` to
    `second_stage`."""
    ignored_types: tuple[str, ...] = ()
    """Types of labels that are neither objects nor background in training: what looks like them is not learned from."""
    ground: Literal["file", "estimated"] = "file"
    """The ground plane: the frame's plane where it has one, as in AVOD, or estimated from the scan wherever
    that shows ground, so that training meets the errors that frames without a plane have."""
    bev: BevConfig = field(default_factory=BevConfig)
    """The maps of the bird's-eye view."""
    image: ImageConfig = field(default_factory=ImageConfig)
    """The camera image."""
    anchors: AnchorConfig = field(default_factory=AnchorConfig)
    """The anchors."""
    extractor: ExtractorConfig = field(default_factory=ExtractorConfig)
    """Both feature pyramids."""
    path_drop: PathDropConfig = field(default_factory=PathDropConfig)
    """Path drop."""
    rpn: RpnConfig = field(default_factory=RpnConfig)
    """The first stage."""
    second_stage: SecondStageConfig = field(default_factory=SecondStageConfig)
    """The second stage."""
    center: CenterConfig = field(default_factory=CenterConfig)
    """The center detector."""
    refinement: RefinementConfig = field(default_factory=RefinementConfig)
    """The stage that corrects boxes by the points in them."""
    training: TrainingConfig = field(default_factory=TrainingConfig)
    """Training."""
    augmentation: AugmentationConfig = field(default_factory=AugmentationConfig)
    """Changes of training samples that AVOD lacks."""
    detection: DetectionConfig = field(default_factory=DetectionConfig)
    """Detection."""

    def __post_init__(self) -> None:
        names = self.class_names
        if not names or len(set(names)) < len(names):
            raise CadetError(f"Config.classes: expected at least one, each once, got {list(names)}")
        self.augmentation.check_classes(len(names))
        for name in self.ignored_types:
            if not is_object_type(name) or kitti_spelling(name) in names:
                raise CadetError(f"Config.ignored_types: expected types of labels that are no class, got {shown(name)}")
        _, rows, columns = self.bev.shape
        if self.network == "center":
            stride, sizes = self.center.stride, {"bev.z_m: cells": rows, "bev.x_m: cells": columns}
        else:
            stride = self.extractor.stride
            sizes = {"image.size[0]": self.image.size[0], "bev.x_m: cells": columns}
        for name, size in sizes.items():
            if size % stride:
                raise CadetError(f"Config.{name}: expected a multiple of {stride}, got {size}")
        if self.detection.flip and self.bev.x_m[0] != -self.bev.x_m[1]:
            raise CadetError(f"Config.detection.flip: expected bev.x_m as far to both sides, got {list(self.bev.x_m)}")
        if rows * columns > MAX_PIXELS:
            raise CadetError(f"Config.bev: expected at most {MAX_PIXELS:,} cells, got {rows} x {columns}")
        places = math.prod((high - low) / self.anchors.stride_m + 1.0 for low, high in (self.bev.x_m, self.bev.z_m))
        anchors = round(2 * places * sum(len(item.anchor_sizes_lwh_m) for item in self.classes))
        if anchors > MAX_ANCHORS:
            raise CadetError(
                f"Config.anchors.stride_m: expected at most {MAX_ANCHORS:,} anchors, got about {anchors:,}"
            )

    @property
    def has_camera(self) -> bool:
        """Whether the network looks at the image, and so has anchors, crops, and proposals."""
        return self.network == "avod"

    @classmethod
    def _presets(cls) -> Mapping[str, Callable[[], Config]]:
        return {name: partial(cls.read, path) for name, path in CONFIGS.items()}

    @classmethod
    def _of_table(cls, table: Mapping[str, Any], folder: Path, place: str = "") -> Config:
        return object_of_table(cls, with_base(table, folder), folder, place)

    @property
    def class_names(self) -> tuple[str, ...]:
        """The classes' names in the network's order, background left out."""
        return tuple(item.name for item in self.classes)


def _check_order(owner: str, negative: float, positive: float) -> None:
    if negative > positive:
        raise CadetError(f"{owner}.positive_iou: expected at least negative_iou {negative:g}, got {positive:g}")
