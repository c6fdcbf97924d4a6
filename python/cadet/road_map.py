"""Road networks from OpenDRIVE files."""

from __future__ import annotations

import hashlib
from dataclasses import dataclass, field
from pathlib import Path

from cadet.checks import as_path, check_text
from cadet.errors import CadetError, MissingFileError


@dataclass(frozen=True)
class RoadMap:
    """An OpenDRIVE map, held in memory so that a run reads its file once.

    Attributes:
        name: the file's name, for metadata and messages.
        xodr: the whole text.

    Raises:
        CadetError: a name or a map that is not text.
    """

    name: str
    xodr: str = field(repr=False)

    def __post_init__(self) -> None:
        check_text("RoadMap", "name", self.name)
        check_text("RoadMap", "xodr", self.xodr)

    @classmethod
    def read(cls, path: str | Path) -> RoadMap:
        """Read an OpenDRIVE file.

        Raises:
            MissingFileError: there is no such file.
            CadetError: it is not text. What the text says is checked when a scene is built from it.
        """
        path = as_path("map", path)
        try:
            return cls(path.name, path.read_text(encoding="utf-8"))
        except (FileNotFoundError, NotADirectoryError, IsADirectoryError):
            raise MissingFileError(f"unknown map {str(path)!r}: expected an OpenDRIVE file (.xodr)") from None
        except UnicodeDecodeError:
            raise CadetError(f"{path.name}: no OpenDRIVE text: not UTF-8") from None
        except ValueError as error:
            raise CadetError(f"{str(path)!r}: {error}") from None

    @property
    def sha256(self) -> str:
        """The hash of the text."""
        return hashlib.sha256(self.xodr.encode()).hexdigest()


def as_road_map(road_map: RoadMap | str | Path) -> RoadMap:
    """Read a file; return what has been read already as it is.

    Raises:
        MissingFileError: there is no such file.
        CadetError: neither a map nor a path, or no text.
    """
    return road_map if isinstance(road_map, RoadMap) else RoadMap.read(road_map)
