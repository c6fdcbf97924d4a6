"""Every number of the detector and its training: frozen, checked when made.

The defaults are AVOD-FPN's for cars; `avod.config_file` reads the rest from TOML.
"""

from __future__ import annotations

import math
from dataclasses import dataclass, field
from typing import Final, Literal

from avod.augmentation_config import AugmentationConfig
from avod.training_config import TrainingConfig
from cadet._util.checks import check_number, check_range, shown
from cadet.bev import BevConfig
from cadet.errors import CadetError
from cadet.formats.kitti.label import is_object_type, kitti_spelling

__all__ = [
    "CAR_SIZES",
    "MAX_ANCHORS",
    "MAX_LAYERS",
    "MAX_PIXELS",
    "AnchorConfig",
    "AugmentationConfig",
    "Config",
    "DetectionConfig",
    "ExtractorConfig",
    "ImageConfig",
    "ObjectClass",
    "PathDropConfig",
    "RpnConfig",
    "SecondStageConfig",
    "Size",
    "TrainingConfig",
]

Size = tuple[float, float, float]

CAR_SIZES: Final[tuple[Size, ...]] = ((3.514, 1.581, 1.511), (4.236, 1.653, 1.547))
"""Two clusters (l, w, h) of KITTI's cars, meters."""

MAX_PIXELS: Final = 2**23
"""The most pixels of the image after resizing, and the most cells of a map: for each the network keeps many numbers."""
MAX_ANCHORS: Final = 2**22
"""The most anchors of the whole grid; AVOD has 89,600."""
MAX_LAYERS: Final = 8
"""The most stages of an encoder, and the most hidden layers of the second stage."""


@dataclass(frozen=True, kw_only=True)
class ObjectClass:
    """A class to detect, and the sizes that its anchors take.

    Raises:
        CadetError: what can be no object's type, no size, or one that is not positive.
    """

    name: str = "Car"
    """The type of the labels."""
    anchor_sizes_lwh_m: tuple[Size, ...] = CAR_SIZES
    """Length, width and height of each cluster."""

    def __post_init__(self) -> None:
        if not is_object_type(self.name):
            raise CadetError(f"ObjectClass.name: expected a type of labels such as Car, got {shown(self.name)}")
        object.__setattr__(self, "name", kitti_spelling(self.name))
        if not self.anchor_sizes_lwh_m:
            raise CadetError("ObjectClass.anchor_sizes_lwh_m: expected at least one size, got none")
        for size in self.anchor_sizes_lwh_m:
            for value in size:
                check_number("ObjectClass", "anchor_sizes_lwh_m", value, 0.01, 50)


@dataclass(frozen=True, kw_only=True)
class ImageConfig:
    """How the camera image reaches the network.

    Raises:
        CadetError: a number outside its range, or more than `MAX_PIXELS` pixels.
    """

    size: tuple[int, int] = (1200, 360)
    """Width and height in pixels after resizing; the aspect ratio is not kept."""
    mean_rgb: tuple[float, float, float] = (92.8403, 97.7996, 93.5843)
    """Taken off each channel of 0..255; nothing is divided."""

    def __post_init__(self) -> None:
        for pixels in self.size:
            check_number("ImageConfig", "size", pixels, 8, 8192, whole=True)
        if math.prod(self.size) > MAX_PIXELS:
            raise CadetError(f"ImageConfig.size: expected at most {MAX_PIXELS:,} pixels, got {self.size!r}")
        for mean in self.mean_rgb:
            check_number("ImageConfig", "mean_rgb", mean, 0, 255)


@dataclass(frozen=True, kw_only=True)
class AnchorConfig:
    """The grid of anchors on the ground plane, over the extent of the bird's-eye view.

    Raises:
        CadetError: a number outside its range.
    """

    stride_m: float = 0.5
    """Between neighbors, in x and in z."""
    min_height_m: float = 0.2
    """Points from this height over the ground plane up make a cell occupied ..."""
    max_height_m: float = 2.0
    """... and points from this height up do not."""
    min_occupied_cells: int = 1
    """Anchors over fewer occupied cells are dropped."""

    def __post_init__(self) -> None:
        check_number("AnchorConfig", "stride_m", self.stride_m, 0.05, 20)
        check_number("AnchorConfig", "min_height_m", self.min_height_m, -100, 100)
        check_number("AnchorConfig", "max_height_m", self.max_height_m, -100, 100)
        check_number("AnchorConfig", "min_occupied_cells", self.min_occupied_cells, 0, whole=True)
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

    channels: tuple[int, ...] = (32, 64, 128, 256)
    """Of each stage of the encoder; a 2 x 2 max pooling lies between two stages."""
    convolutions: tuple[int, ...] = (2, 2, 3, 3)
    """In each stage of the encoder."""
    fused_channels: tuple[int, ...] = (64, 32, 32)
    """Of the decoder after each fusion, from coarse to fine; the last is what the heads see."""
    batch_norm_decay: float = 0.999
    """Of the moving averages; PyTorch's momentum is 1 less this."""
    batch_norm_epsilon: float = 1e-3
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
        for name, most in (("channels", 4096), ("convolutions", 32), ("fused_channels", 4096)):
            for value in getattr(self, name):
                check_number("ExtractorConfig", name, value, 1, most, whole=True)
        check_number("ExtractorConfig", "batch_norm_decay", self.batch_norm_decay, 0, 1)
        check_number("ExtractorConfig", "batch_norm_epsilon", self.batch_norm_epsilon, 1e-12, 1)

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

    keep_image: float = 0.9
    """Probability of keeping the image."""
    keep_bev: float = 0.9
    """Probability of keeping the bird's-eye view."""

    def __post_init__(self) -> None:
        check_number("PathDropConfig", "keep_image", self.keep_image, 0, 1)
        check_number("PathDropConfig", "keep_bev", self.keep_bev, 0, 1)


@dataclass(frozen=True, kw_only=True)
class RpnConfig:
    """The region proposal network.

    Raises:
        CadetError: a number outside its range.
    """

    crop_size: int = 3
    """Samples of a crop along each axis."""
    bottleneck_channels: int = 1
    """Channels that the first stage sees of each modality's feature map: AVOD's 1."""
    hidden: int = 256
    """Width of both hidden layers of each head."""
    dropout_keep: float = 0.5
    """Probability of keeping a unit of the hidden layers."""
    nms_iou: float = 0.8
    """Proposals that overlap a better one by more than this, seen from above, are dropped."""
    train_proposals: int = 1024
    """Proposals kept in training."""
    proposals: int = 300
    """Proposals kept in detection: AVOD's 300 for cars, 1024 for people."""
    batch_size: int = 512
    """Anchors that the loss samples; at most half are positive."""
    negative_iou: float = 0.3
    """Anchors that overlap every object by less than this are negative ..."""
    positive_iou: float = 0.5
    """... and those that overlap one by more than this positive."""
    regression_weight: float = 5.0
    """Of the box loss against the objectness loss."""

    def __post_init__(self) -> None:
        check_number("RpnConfig", "crop_size", self.crop_size, 2, 64, whole=True)
        check_number("RpnConfig", "bottleneck_channels", self.bottleneck_channels, 1, 1024, whole=True)
        check_number("RpnConfig", "hidden", self.hidden, 1, 65536, whole=True)
        check_number("RpnConfig", "dropout_keep", self.dropout_keep, 0.01, 1)
        check_number("RpnConfig", "train_proposals", self.train_proposals, 1, whole=True)
        check_number("RpnConfig", "proposals", self.proposals, 1, whole=True)
        check_number("RpnConfig", "batch_size", self.batch_size, 2, whole=True)
        check_number("RpnConfig", "regression_weight", self.regression_weight, 0)
        for name in ("nms_iou", "negative_iou", "positive_iou"):
            check_number("RpnConfig", name, getattr(self, name), 0, 1)
        _check_order("RpnConfig", self.negative_iou, self.positive_iou)


@dataclass(frozen=True, kw_only=True)
class SecondStageConfig:
    """The network that classifies and refines proposals.

    Raises:
        CadetError: a number outside its range.
    """

    crop_size: int = 7
    """Samples of a crop along each axis."""
    hidden: tuple[int, ...] = (2048, 2048, 2048)
    """Widths of the hidden layers."""
    dropout_keep: float = 0.5
    """Probability of keeping a unit of the hidden layers."""
    gradient: Literal["through", "stopped"] = "through"
    """Whether the second stage's losses reach the first through its boxes, as in AVOD, or only through features."""
    batch_size: int = 1024
    """Proposals that the loss samples; at most half are positive."""
    height_cells: int = 0
    """Parts along each side of a proposal, seen from above, whose points' greatest heights join the crops, with the
    greatest of all. 0 in AVOD, whose crops hold heights as features of many cells: a short training hardly learns a
    car's height from them."""
    standing_heights_m: tuple[float, float] = (0.0, 0.0)
    """With `height_cells`: proposals stand on the ground and are as high as the highest point in them, within these
    limits, when the second stage looks at them; it regresses bottoms and tops from there. (0, 0) keeps the first
    stage's bottoms and heights, as AVOD does: the second then corrects errors that its crops do not show."""
    truth_proposals: int = 0
    """Copies of each true box, moved and scaled a little, that join the proposals in training: with them the second
    stage learns before the first finds objects. Faster R-CNN's implementations add the boxes as they are."""
    truth_steps: int = 0
    """They join in so many steps from the first; after them the second stage sees what it will see in detection."""
    negative_iou: float = 0.55
    """Proposals that overlap every object by less than this are background ..."""
    positive_iou: float = 0.65
    """... and those that overlap one by more than this carry its class."""
    regression_weight: float = 5.0
    """Of the box loss against the class loss."""
    vertical_weight: float = 1.0
    """Of bottom and top in the box loss, against 1 of each of the corners' eight coordinates; 1 in AVOD."""
    orientation_weight: float = 1.0
    """Of the loss of the angle vector."""

    def __post_init__(self) -> None:
        check_number("SecondStageConfig", "crop_size", self.crop_size, 2, 64, whole=True)
        if len(self.hidden) > MAX_LAYERS:
            raise CadetError(f"SecondStageConfig.hidden: expected at most {MAX_LAYERS} layers, got {len(self.hidden)}")
        for width in self.hidden:
            check_number("SecondStageConfig", "hidden", width, 1, 65536, whole=True)
        check_number("SecondStageConfig", "dropout_keep", self.dropout_keep, 0.01, 1)
        check_number("SecondStageConfig", "batch_size", self.batch_size, 2, whole=True)
        check_range("SecondStageConfig", "standing_heights_m", self.standing_heights_m, 0, 20)
        if self.standing_heights_m[1] > 0.0 and not self.height_cells:
            raise CadetError("SecondStageConfig.standing_heights_m: expected (0, 0) without height_cells")
        check_number("SecondStageConfig", "height_cells", self.height_cells, 0, 16, whole=True)
        check_number("SecondStageConfig", "truth_proposals", self.truth_proposals, 0, 1024, whole=True)
        check_number("SecondStageConfig", "truth_steps", self.truth_steps, 0, whole=True)
        for name in ("negative_iou", "positive_iou"):
            check_number("SecondStageConfig", name, getattr(self, name), 0, 1)
        for name in ("regression_weight", "vertical_weight", "orientation_weight"):
            check_number("SecondStageConfig", name, getattr(self, name), 0)
        _check_order("SecondStageConfig", self.negative_iou, self.positive_iou)


@dataclass(frozen=True, kw_only=True)
class DetectionConfig:
    """What becomes of the second stage's boxes.

    Raises:
        CadetError: a number outside its range.
    """

    nms_iou: float = 0.01
    """Boxes that overlap a better one by more than this, seen from above and turned to the axes, are dropped."""
    suppression: Literal["all", "class"] = "all"
    """Whether a box drops those of all classes, as in AVOD, or those of its own class alone: a pedestrian beside a car
    overlaps it once both are turned to the axes."""
    max_detections: int = 100
    """Boxes kept in a frame."""
    min_score: float = 0.1
    """Detections below this are not written."""
    max_image_fraction: float = 0.8
    """Detections wider or higher than this share of the image are not written."""
    fix_up: Literal["corrected", "reference"] = "corrected"
    """How the angle vector chooses among a box's four headings: right, or with AVOD's wrong sign at +-90 degrees."""

    def __post_init__(self) -> None:
        check_number("DetectionConfig", "nms_iou", self.nms_iou, 0, 1)
        check_number("DetectionConfig", "max_detections", self.max_detections, 1, whole=True)
        check_number("DetectionConfig", "min_score", self.min_score, 0, 1)
        check_number("DetectionConfig", "max_image_fraction", self.max_image_fraction, 0, 1)


@dataclass(frozen=True, kw_only=True)
class Config:
    """A detector and its training.

    Raises:
        CadetError: no class, one twice, inputs that the extractor's strides do not divide, more than `MAX_PIXELS` cells
            or `MAX_ANCHORS` anchors.
    """

    classes: tuple[ObjectClass, ...] = (ObjectClass(),)
    """Classes to detect; class k of the network is the k-th, 0 is background."""
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
        if self.second_stage.height_cells and "max_height" not in (*self.bev.slice_maps, *self.bev.cloud_maps):
            raise CadetError("Config.second_stage.height_cells: expected 0 where no map holds max_height")
        self.augmentation.check_classes(len(names))
        stride = self.extractor.stride
        _, rows, columns = self.bev.shape
        for name, size in (("image.size[0]", self.image.size[0]), ("bev.x_m: cells", columns)):
            if size % stride:
                raise CadetError(f"Config.{name}: expected a multiple of {stride}, got {size}")
        if rows * columns > MAX_PIXELS:
            raise CadetError(f"Config.bev: expected at most {MAX_PIXELS:,} cells, got {rows} x {columns}")
        places = math.prod((high - low) / self.anchors.stride_m + 1.0 for low, high in (self.bev.x_m, self.bev.z_m))
        anchors = round(2 * places * sum(len(item.anchor_sizes_lwh_m) for item in self.classes))
        if anchors > MAX_ANCHORS:
            raise CadetError(
                f"Config.anchors.stride_m: expected at most {MAX_ANCHORS:,} anchors, got about {anchors:,}"
            )

    @property
    def class_names(self) -> tuple[str, ...]:
        """The classes' names in the network's order, background left out."""
        return tuple(item.name for item in self.classes)


def _check_order(owner: str, negative: float, positive: float) -> None:
    if negative > positive:
        raise CadetError(f"{owner}.positive_iou: expected at least negative_iou {negative:g}, got {positive:g}")
