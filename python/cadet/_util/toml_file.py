"""Settings that TOML files hold: read and written in one way, and found by name where there are presets."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from pathlib import Path
from typing import Any, ClassVar, TypeVar

from cadet._util.checks import as_path, is_one_of, known_names, shown
from cadet._util.plain_tables import object_of_table, table_of_object, toml_of_table
from cadet._util.plain_text import toml_from_text
from cadet._util.user_files import read_settings
from cadet.errors import CadetError, FileFormatError

_Toml = TypeVar("_Toml", bound="TomlFile")
_Named = TypeVar("_Named", bound="NamedFile")


class TomlFile:
    """A dataclass that a TOML file can hold: its fields are the keys, unless `_of_table` and `_table` say otherwise."""

    @classmethod
    def read(cls: type[_Toml], path: str | Path) -> _Toml:
        """Read a TOML file; the names of files in it are relative to its folder.

        Raises:
            MissingFileError: there is no such file.
            CadetError: anything that is wrong with it, in one line with the file's name, key and reason.
        """
        path = as_path("path", path)
        return cls.from_toml(read_settings(path), file=str(path), folder=path.parent)

    @classmethod
    def from_toml(cls: type[_Toml], text: str | bytes, *, file: str = "TOML", folder: str | Path = ".") -> _Toml:
        """Return what the text of a TOML file says.

        Args:
            text: the text.
            file: its name, for messages.
            folder: what the names of files in it are relative to.

        Raises:
            CadetError: anything that is wrong with it, in one line with `file`, key and reason.
        """
        if not isinstance(text, str | bytes):
            raise CadetError(f"text: expected a string, got {shown(text)}; read reads a file")
        table = toml_from_text(text, file)
        try:
            return cls._of_table(table, as_path("folder", folder))
        except CadetError as error:
            raise FileFormatError(str(error), file) from None

    def to_toml(self) -> str:
        """Return the text of a TOML file; `from_toml` reads an equal object from it."""
        return toml_of_table(self._table())

    @classmethod
    def _of_table(cls: type[_Toml], table: Mapping[str, Any], folder: Path, place: str = "") -> _Toml:
        """Return what a table of a TOML file says.

        Args:
            table: the table.
            folder: what the names of files in it are relative to.
            place: the table's own key, for messages.

        Raises:
            CadetError: an unknown or missing key, or a value that is refused; the key is named.
        """
        return object_of_table(cls, table, folder, place)

    def _table(self) -> dict[str, Any]:
        """Return the table of a TOML file."""
        return table_of_object(self)


class NamedFile(TomlFile):
    """A `TomlFile` of which the package has some by name."""

    _KIND: ClassVar[str]
    """What it is, for messages."""

    @classmethod
    def _presets(cls: type[_Named]) -> Mapping[str, Callable[[], _Named]]:
        """Return what makes each preset, by name."""
        raise NotImplementedError

    @classmethod
    def named(cls: type[_Named], name_or_file: str | Path, *, folder: str | Path = ".") -> _Named:
        """Return the preset of a name, or what a file that ends in .toml holds.

        Args:
            name_or_file: a preset's name, or the file.
            folder: what the file's name is relative to.

        Raises:
            MissingFileError: there is no such file.
            CadetError: neither, or a file with something wrong in it.
        """
        presets = cls._presets()
        if is_one_of(name_or_file, presets):
            return presets[str(name_or_file)]()
        if isinstance(name_or_file, str | Path) and str(name_or_file).endswith(".toml"):
            return cls.read(as_path("folder", folder) / as_path(cls._KIND, name_or_file))
        there_is = known_names(name_or_file, presets, ", or the path of a file that ends in .toml")
        raise CadetError(f"unknown {cls._KIND} {shown(name_or_file)}; {there_is}")
