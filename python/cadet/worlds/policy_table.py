"""What a policy is chosen by: keys of TOML files, and options of `cadet gen` under the same names."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import fields, replace
from pathlib import Path
from typing import Any, Final, TypeVar, get_type_hints

from cadet._util.checks import check_image_size, check_text, shown
from cadet._util.plain_tables import check_keys, table_of_object, value_of
from cadet._util.toml_file import NamedFile
from cadet.errors import CadetError
from cadet.sensors.lidar import HOW, Lidar
from cadet.sensors.rig import Rig
from cadet.worlds.assets import Assets
from cadet.worlds.districts import District
from cadet.worlds.props import Props
from cadet.worlds.road_map import RoadMap
from cadet.worlds.weather import Weather, as_weather, table_of_weathers

# A `ResetPolicy`, which uses this module.
_Policy = Any
_Same = TypeVar("_Same")
_Chosen = TypeVar("_Chosen", bound=NamedFile)

_WORLDS: Final = ("weathers", "districts", "rigs", "maps", "assets")
"""Fields that are no plain values."""


def changed(policy: _Same, table: Mapping[str, Any], folder: Path, name_of: Callable[[str], str] = str) -> _Same:
    """Return a policy with what a table says in place of its own.

    Args:
        policy: the policy.
        table: values by the keys of `keys_of_policy`.
        folder: what the names of files are relative to.
        name_of: what a key is called in messages.

    Raises:
        CadetError: an unknown key, or a value that is refused; the key is named.
    """
    found: _Policy = policy
    check_keys(table, keys_of_policy(type(policy)))
    for key in keys_of_policy(type(policy)):
        if key in table:
            try:
                found = _CHANGES.get(key, _with_field)(found, key, table, folder)
            except (CadetError, OSError) as error:
                first, _, rest = str(error).partition(": ")
                named, reason = (first, rest) if first in table else (key, str(error))
                raise CadetError(f"{name_of(named)}: {reason}") from None
    same: _Same = found
    return same


def keys_of_policy(cls: type[Any]) -> tuple[str, ...]:
    """Return the keys that change a policy, in the order in which they do: sensors go into rigs, rigs into policies."""
    return tuple(dict.fromkeys((*(f.name for f in fields(cls) if f.name not in _WORLDS), *_CHANGES)))


def table_of_policy(policy: _Policy) -> dict[str, Any]:
    """Return the table from which `changed` makes the same policy of any other.

    Raises:
        CadetError: it has maps or assets, which are files whose names it does not know.
    """
    if policy.maps or policy.assets is not None:
        raise CadetError("a policy with maps or assets has no TOML: name their files in it by maps, assets, and props")
    plain = {key: value for key, value in table_of_object(policy).items() if key not in _WORLDS}
    districts = [{"weight": weight, "district": _name_or_table(one)} for one, weight in policy.districts]
    rigs = [{"weight": weight, "rig": _name_or_table(one)} for one, weight in policy.rigs]
    return {**plain, "weathers": table_of_weathers(policy.weathers), "districts": districts, "rigs": rigs}


def _name_or_table(one: Rig | District) -> Any:
    makers = type(one)._presets()
    return one.name if one.name in makers and makers[one.name]() == one else one._table()


def _with_field(policy: _Policy, key: str, table: Mapping[str, Any], folder: Path) -> _Policy:
    return replace(policy, **{key: value_of(get_type_hints(type(policy))[key], table[key], folder, key)})


def _with_weathers(policy: _Policy, key: str, table: Mapping[str, Any], folder: Path) -> _Policy:
    weights = table[key] if isinstance(table[key], Mapping) else dict.fromkeys(_strings(table[key]), 1.0)
    return replace(policy, weathers=tuple(_weather(name, value) for name, value in weights.items()))


def _weather(name: str, value: Any) -> tuple[Weather, float]:
    """Return a preset with its weight, or a weather of the table's own numbers with the one among them, 1 if none."""
    if not isinstance(value, Mapping):
        return as_weather(name), value
    numbers = {key: tuple(v) if isinstance(v, list) else v for key, v in value.items() if key != "weight"}
    check_keys(numbers, tuple(f.name for f in fields(Weather) if f.name != "name"))
    return Weather(name=name, **numbers), value.get("weight", 1.0)


def _with_districts(policy: _Policy, key: str, table: Mapping[str, Any], folder: Path) -> _Policy:
    return replace(policy, districts=_weighted(District, "district", table[key], folder))


def _with_vehicle_shares(policy: _Policy, key: str, table: Mapping[str, Any], folder: Path) -> _Policy:
    return policy.with_each_district(lambda district: replace(district, vehicle_shares=table[key]))


def _with_rigs(policy: _Policy, key: str, table: Mapping[str, Any], folder: Path) -> _Policy:
    return replace(policy, rigs=_weighted(Rig, "rig", table[key], folder))


def _with_rig(policy: _Policy, key: str, table: Mapping[str, Any], folder: Path) -> _Policy:
    return policy.with_rig(_chosen(Rig, table[key], folder))


def _with_lidar(policy: _Policy, key: str, table: Mapping[str, Any], folder: Path) -> _Policy:
    lidar = _chosen(Lidar, table[key], folder)
    return policy.with_each_rig(lambda rig: rig.with_lidar(lidar))


def _scanning(policy: _Policy, key: str, table: Mapping[str, Any], folder: Path) -> _Policy:
    how = {key: table[key]}
    return policy.with_each_rig(lambda rig: rig.with_each_lidar(lambda lidar: replace(lidar, **how)))


def _with_image_size(policy: _Policy, key: str, table: Mapping[str, Any], folder: Path) -> _Policy:
    width, height = check_image_size(table[key], key)
    return policy.with_each_rig(lambda rig: rig.with_image_size(width, height))


def _with_maps(policy: _Policy, key: str, table: Mapping[str, Any], folder: Path) -> _Policy:
    return replace(policy, maps=tuple(RoadMap.read(folder / name) for name in _strings(table[key])))


def _check_assets_too(policy: _Policy, key: str, table: Mapping[str, Any], folder: Path) -> _Policy:
    if "assets" not in table:
        raise CadetError("goes with assets")
    return policy


def _with_assets(policy: _Policy, key: str, table: Mapping[str, Any], folder: Path) -> _Policy:
    assets = Assets.read(folder / _string(table["assets"]), skip_bad=table.get("skip_bad", False))
    return replace(policy, assets=assets)


def _with_props(policy: _Policy, key: str, table: Mapping[str, Any], folder: Path) -> _Policy:
    return policy.with_props(Props.read(folder / _string(table[key])))


def _as_sequence(policy: _Policy, key: str, table: Mapping[str, Any], folder: Path) -> _Policy:
    return policy.as_sequence(**{name: table[name] for name in ("hz", "length_s") if name in table})


_CHANGES: Final[dict[str, Callable[[_Policy, str, Mapping[str, Any], Path], _Policy]]] = {
    "weathers": _with_weathers,
    "districts": _with_districts,
    "vehicle_shares": _with_vehicle_shares,
    "rigs": _with_rigs,
    "rig": _with_rig,
    "lidar": _with_lidar,
    **dict.fromkeys(HOW, _scanning),
    "image_size": _with_image_size,
    "maps": _with_maps,
    "skip_bad": _check_assets_too,
    "assets": _with_assets,
    "props": _with_props,
    "length_s": _as_sequence,
    "hz": _as_sequence,
}
"""Changes by key; all other keys are plain fields."""


def _weighted(cls: type[_Chosen], key: str, values: Any, folder: Path) -> tuple[tuple[_Chosen, float], ...]:
    """Return what names, or tables with a weight each, choose."""
    if not isinstance(values, list | tuple) or not values:
        raise CadetError(f"expected a list of names, or of tables with a {key} and its weight, got {shown(values)}")
    pairs = []
    for number, value in enumerate(values):
        entry = value if isinstance(value, Mapping) else {key: value}
        check_keys(entry, (key, "weight"), (key,), f"[{number}]")
        pairs.append((_chosen(cls, entry[key], folder), entry.get("weight", 1.0)))
    return tuple(pairs)


def _chosen(cls: type[_Chosen], value: Any, folder: Path) -> _Chosen:
    return cls._of_table(value, folder) if isinstance(value, Mapping) else cls.named(_string(value), folder=folder)


def _strings(values: Any) -> list[str]:
    if not isinstance(values, list | tuple) or not values:
        raise CadetError(f"expected a list of strings, got {shown(values)}")
    return [_string(value) for value in values]


def _string(value: Any) -> str:
    check_text("", "value", value)
    return str(value)
