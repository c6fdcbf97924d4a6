"""The errors that cadet raises for bad input. Errors of the operating system stay Python's own."""

from __future__ import annotations


class CadetError(Exception):
    """Anything wrong with what the user gave: one line naming the file, the line and the reason."""


class KittiFormatError(CadetError, ValueError):
    """A KITTI file that breaks its format."""


class ShapeError(CadetError, ValueError):
    """An array of the wrong shape or dtype."""


class NonFiniteError(CadetError, ValueError):
    """NaN or infinity where a number was needed."""


class MissingFileError(CadetError, FileNotFoundError):
    """A file of a dataset that is not there."""


class FrameExistsError(CadetError, FileExistsError):
    """A frame that would be overwritten without leave to do so."""
