"""A dataset's recipe: a TOML file from which every byte of it can be made again."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any, Final

from cadet import _cadet
from cadet._util.checks import shown
from cadet._util.plain_tables import check_keys, value_of
from cadet._util.toml_file import TomlFile
from cadet.errors import CadetError
from cadet.generate.golden_frames import generator
from cadet.generate.settings import FORMAT_VERSION, Settings
from cadet.worlds.policy import ResetPolicy

RECIPE: Final = "recipe.toml"
"""Its name in a dataset."""
_VERSION: Final = {"cadet": _cadet.__version__, "format_version": FORMAT_VERSION, "generator": generator()}
_PLAIN: Final = {
    "seed": int,
    "num_frames": int,
    "format": str,
    "write": tuple[str, ...],
    "shard_size": int,
    "val_fraction": float,
    "test_fraction": float,
}
"""Fields of `Settings` that are plain values."""


@dataclass(frozen=True)
class Recipe(TomlFile):
    """The settings of a dataset, and the hash of its manifest, which has the hashes of all other files.

    A file has the keys of `Settings` and of a policy's file, as docs/reference/settings.md lists them.

    Attributes:
        settings: everything that decides the dataset's bytes.
        manifest_sha256: in hexadecimal digits, if the dataset has been made.
    """

    settings: Settings
    manifest_sha256: str | None = None

    @classmethod
    def _of_table(cls, table: Mapping[str, Any], folder: Path, place: str = "") -> Recipe:
        check_keys(table, (*_VERSION, "manifest_sha256", *_PLAIN, *ResetPolicy._keys()))
        for key, here in _VERSION.items():
            if table.get(key, here) != here:
                raise CadetError(
                    f"{key}: the recipe is of {shown(table[key])}, this is {here!r}, which gives other bytes: "
                    "install that version, or take the key out of the recipe"
                )
        digest = value_of(str | None, table.get("manifest_sha256"), folder, "manifest_sha256")
        plain = {key: value_of(kind, table[key], folder, key) for key, kind in _PLAIN.items() if key in table}
        policy = {key: value for key, value in table.items() if key in ResetPolicy._keys()}
        return cls(Settings(**plain, policy=ResetPolicy._of_table(policy, folder)), digest)

    def _table(self) -> dict[str, Any]:
        digest = {} if self.manifest_sha256 is None else {"manifest_sha256": self.manifest_sha256}
        plain = {key: getattr(self.settings, key) for key in _PLAIN}
        plain = {key: list(value) if key == "write" else value for key, value in plain.items() if value is not None}
        return {**_VERSION, **digest, **plain, **_policy_table(self.settings.policy)}


def is_recipe_of(settings: Settings) -> bool:
    """Tell whether a recipe can hold the settings: maps and meshes are files of the user's, which it only names."""
    return not settings.policy.maps and settings.policy.assets is None


def _policy_table(policy: ResetPolicy) -> dict[str, Any]:
    """Return a preset's name and what differs from it, or all of a policy that is not made from one."""
    table = policy._table()
    makers = ResetPolicy._presets()
    if policy.name not in makers:
        return table
    preset = makers[policy.name]()._table()
    if not set(preset) <= set(table):
        return table
    return {"policy": policy.name, **{key: value for key, value in table.items() if preset.get(key) != value}}
