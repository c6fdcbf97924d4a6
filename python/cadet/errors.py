"""The errors that cadet raises for bad input. Errors of the operating system stay Python's own."""

from __future__ import annotations


class CadetError(Exception):
    """Anything wrong with what the user gave: one line naming the file, the line and the reason."""


class CadetWarning(UserWarning):
    """Something that was skipped or assumed, and that the user may want to fix."""


class InternalError(CadetError):
    """An error of cadet's own, which the user can't fix; its message asks for a report.

    Args:
        what: what happened and where, for the report of the error.
    """

    def __init__(self, what: str) -> None:
        super().__init__(f"internal error: {what}; please report it, with what led to it, as an issue of cadet")


class FileFormatError(CadetError, ValueError):
    """A file that breaks its format.

    Args:
        reason: what is wrong.
        file: the file's name, None where there is no file.
        line: the line's number from 1, None where the file as a whole is meant.
        column: the column's number from 1, as KITTI counts them: fields, not letters; None where the line is meant.
    """

    def __init__(
        self, reason: str, file: str | None = None, line: int | None = None, column: int | None = None
    ) -> None:
        where = "" if file is None else f"{file}: " if line is None else f"{file}:{line}: "
        super().__init__(f"{where}{'' if column is None else f'column {column}: '}{reason}")
        self.reason = reason
        self.file = file
        self.line = line
        self.column = column


class KittiFormatError(FileFormatError):
    """A KITTI file that breaks its format: `FileFormatError`'s arguments."""


class ShapeError(CadetError, ValueError):
    """An array of the wrong shape or dtype."""


class NonFiniteError(CadetError, ValueError):
    """NaN or infinity where a number was needed."""


class MissingFileError(CadetError, FileNotFoundError):
    """A file of a dataset that is not there."""


class FrameExistsError(CadetError, FileExistsError):
    """A frame that would be overwritten without permission."""


class WorkerError(CadetError):
    """A worker died twice in the same episode or met a bug; the frames written so far are whole."""
