"""Every number of a detector and its training: frozen, checked when made, read from TOML and checkpoints."""

from avod.config.augmentation import AugmentationConfig
from avod.config.center import CenterConfig
from avod.config.detector import (
    CAR_SIZES,
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
from avod.config.limits import MAX_ANCHORS, MAX_LAYERS, MAX_PIXELS
from avod.config.refinement import RefinementConfig
from avod.config.training import TrainingConfig

__all__ = [
    "CAR_SIZES",
    "MAX_ANCHORS",
    "MAX_LAYERS",
    "MAX_PIXELS",
    "AnchorConfig",
    "AugmentationConfig",
    "CenterConfig",
    "Config",
    "DetectionConfig",
    "ExtractorConfig",
    "ImageConfig",
    "ObjectClass",
    "PathDropConfig",
    "RefinementConfig",
    "RpnConfig",
    "SecondStageConfig",
    "Size",
    "TrainingConfig",
]
