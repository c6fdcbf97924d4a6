"""A user's own props: a folder with a TOML file for each, placed as those of the package are."""

from __future__ import annotations

import hashlib
from dataclasses import dataclass
from pathlib import Path

from cadet import _cadet
from cadet._util.checks import as_path, as_tuple, make_plain, shown
from cadet._util.summary import summary
from cadet._util.user_files import read_settings
from cadet.errors import CadetError, MissingFileError


@dataclass(frozen=True)
class Props:
    """A user's own props, held in memory so that a run reads their files once. `Props.read` reads them from a folder.

    Args:
        files: the name and the text of each file: `bottle-bank.toml` is the prop `bottle-bank`.

    Raises:
        CadetError: a file that can't be used; file, line, reason and remedy are named.
    """

    files: tuple[tuple[str, str], ...]

    @property
    def names(self) -> tuple[str, ...]:
        """The props' names."""
        return tuple(Path(name).stem for name, _ in self.files)

    def __repr__(self) -> str:
        return summary(self, names=self.names)

    def __post_init__(self) -> None:
        make_plain(self)
        object.__setattr__(self, "files", as_tuple("props", "files", self.files, "a name and a string"))
        for file in self.files:
            if not isinstance(file, tuple) or len(file) != 2 or not all(isinstance(part, str) for part in file):
                raise CadetError(f"props.files: expected pairs of a name and a string, got {shown(file)}")
        # Bad files are refused here rather than in the middle of a run.
        _cadet.check_props(self.files)

    @classmethod
    def read(cls, folder: str | Path) -> Props:
        """Read all `.toml` files of a folder, in the order of their names.

        Raises:
            MissingFileError: there is no such folder, or no such file in it.
            CadetError: a file that can't be used.
        """
        root = as_path("props", folder)
        if not root.is_dir():
            raise MissingFileError(f"{str(root)!r}: no such folder")
        paths = sorted(root.glob("*.toml"), key=lambda path: path.name)
        if not paths:
            raise MissingFileError(f"{str(root)!r}: no .toml file in it")
        files = []
        for path in paths:
            try:
                files.append((path.name, read_settings(path).decode()))
            except UnicodeDecodeError:
                raise CadetError(f"{str(path)!r}: expected UTF-8 text") from None
        return cls(tuple(files))

    def to_list(self) -> list[dict[str, str]]:
        """Return what a manifest says of them: names and hashes, no paths."""
        return [
            {"name": Path(name).stem, "sha256": hashlib.sha256(text.encode()).hexdigest()} for name, text in self.files
        ]
