"""AVOD-FPN in PyTorch: 3D objects from a LIDAR scan and an image, trained on KITTI's format.

`avod` reads KITTI folders with `cadet` and never the other way round.
"""

from avod.config import Config
from avod.config_file import config_names, load_config
from avod.detector import Detector

__all__ = ["Config", "Detector", "config_names", "load_config"]
