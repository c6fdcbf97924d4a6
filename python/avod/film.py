"""A film of what a detector finds."""

from __future__ import annotations

from pathlib import Path
from types import TracebackType
from typing import Final

import cv2

from avod.figures import film_picture
from cadet._util.user_files import check_out_path
from cadet.errors import CadetError
from cadet.formats.kitti import Frame, Label

SUFFIX: Final = ".mp4"
_CODEC: Final = "mp4v"


class Film:
    """Writes a film, frame by frame; it appears when it is whole.

    Args:
        path: ends in .mp4.
        hz: pictures a second.

    Raises:
        CadetError: another name, or pictures of other sizes than the first.
        MissingFileError: its folder is not there.
    """

    def __init__(self, path: str | Path, hz: float) -> None:
        self.path = check_out_path(path, (SUFFIX,))
        self._aside = self.path.with_name(f".{self.path.stem}.partial{SUFFIX}")
        self._hz = hz
        self._writer: cv2.VideoWriter | None = None
        self._size = (0, 0)

    def __enter__(self) -> Film:
        """Begin."""
        return self

    def add(self, frame: Frame, found: tuple[Label, ...]) -> None:
        """Add a frame with the boxes that were found in it."""
        picture = film_picture(frame, found)
        size = (picture.shape[1], picture.shape[0])
        if self._writer is None:
            self._size = size
            codec = cv2.VideoWriter.fourcc(*_CODEC)
            self._writer = cv2.VideoWriter(str(self._aside), codec, self._hz, size)
            if not self._writer.isOpened():
                raise CadetError(f"{self.path}: this OpenCV cannot write films of {size[0]} x {size[1]} pixels")
        if size != self._size:
            raise CadetError(f"{self.path}: its pictures have {self._size} pixels, and the next one has {size}")
        self._writer.write(cv2.cvtColor(picture, cv2.COLOR_RGB2BGR))

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, traceback: TracebackType | None
    ) -> None:
        """Put the film into its place, or remove what there is of it after an error."""
        if self._writer is None:
            return
        self._writer.release()
        if kind is None:
            self._aside.replace(self.path)
        else:
            self._aside.unlink(missing_ok=True)
