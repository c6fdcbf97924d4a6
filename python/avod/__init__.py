"""AVOD-FPN in PyTorch: 3D objects from a LIDAR scan and an image, trained on KITTI's format.

`avod` reads KITTI folders with `cadet` and never the other way round. Configurations are read without PyTorch; all else
needs it: `pip install 'cadet-sim[avod]'`.
"""

from typing import TYPE_CHECKING, Any

from avod.config import Config
from avod.config.base import config_names

if TYPE_CHECKING:
    from avod.detector import Detector

__all__ = ["Config", "Detector", "config_names"]


def __getattr__(name: str) -> Any:
    if name != "Detector":
        raise AttributeError(f"module 'avod' has no attribute {name!r}")
    try:
        from avod.detector import Detector
    except ModuleNotFoundError as error:
        if error.name not in ("torch", "safetensors"):
            raise
        message = f"avod.Detector needs {error.name}: pip install 'cadet-sim[avod]'"
        raise ModuleNotFoundError(message, name=error.name) from None
    return Detector
