"""The files beside a mesh, found by the names that other people's machines wrote."""

from __future__ import annotations

import hashlib
import re
from pathlib import Path

from cadet._util.checks import shown
from cadet._util.user_files import read_file
from cadet.errors import CadetError


class Beside:
    """The files beside a mesh, none of them outside of a folder.

    Args:
        root: the folder that holds everything.
        mesh: the mesh's path in it.
    """

    def __init__(self, root: Path, mesh: Path) -> None:
        self._root = root
        self._folder = mesh.parent
        self._read: list[str] = []

    def find(self, *names: str) -> bytes | None:
        """Return the first file that is there: at its path beside the mesh, or by its last name alone.

        Exporters write the paths of their own machines, and Windows does not tell `A.png` from `a.PNG`.

        Raises:
            CadetError: a path leads out of the folder, and nothing of its name lies beside the mesh.
        """
        outside = None
        for name in names:
            steps = [step for step in re.split(r"[/\\]", name) if step not in ("", ".")]
            for path in (steps, steps[-1:]):
                found = self._path(path)
                if found is None:
                    continue
                if not found.resolve().is_relative_to(self._root.resolve()):
                    outside = name
                    continue
                data = read_file(found, missing=f"no file {shown(name)}")
                self._read.append(f"{name}\0{hashlib.sha256(data).hexdigest()}\0")
                return data
        if outside is not None:
            raise CadetError(f"{shown(outside)} lies outside of the folder of assets: copy it beside the mesh")
        return None

    def sha256(self, mesh: bytes) -> str:
        """Return the hash of the mesh and of what was found so far."""
        return hashlib.sha256(
            "".join([hashlib.sha256(mesh).hexdigest(), *self._read]).encode("utf-8", "replace")
        ).hexdigest()

    def names(self, suffix: str) -> list[str]:
        """Return the names of the files beside the mesh that end so."""
        return sorted(path.name for path in self._folder.iterdir() if path.suffix.lower() == suffix)

    def _path(self, steps: list[str]) -> Path | None:
        """Walk down the steps; where nothing has a step's name, the one thing whose letters differ in case alone."""
        path = self._folder
        if not steps or any("\0" in step or not step.isprintable() for step in steps):
            return None
        try:
            for step in steps:
                if not (path / step).exists():
                    if not path.is_dir() or not path.resolve().is_relative_to(self._root.resolve()):
                        return None
                    alike = [entry.name for entry in path.iterdir() if entry.name.casefold() == step.casefold()]
                    if len(alike) != 1:
                        return None
                    step = alike[0]
                path /= step
            return path if path.is_file() else None
        except (OSError, RuntimeError, UnicodeEncodeError):  # too long, too many links
            return None
