"""Every number of a detector and its training: frozen, checked when made, read from TOML and checkpoints."""

from avod.config.augmentation import AugmentationConfig
from avod.config.detector import (
    CAR_SIZES,
    MAX_ANCHORS,
    MAX_LAYERS,
    MAX_PIXELS,
    AnchorConfig,
    Config,
    DetectionConfig,
    ExtractorConfig,
    ImageConfig,
    ObjectClass,
    PathDropConfig,
    RpnConfig,
    SecondStageConfig,
    Size,
)
from avod.config.training import TrainingConfig

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
