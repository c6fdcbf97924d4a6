"""What a stream of frames is made from, as a TOML file: the policy's name and what differs from it."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any, Final

from cadet._util.checks import as_path, as_seed, check_image_size, check_text, shown
from cadet._util.plain_text import toml_from_text
from cadet._util.user_files import read_settings
from cadet.errors import CadetError, FileFormatError
from cadet.sensors.lidar import Lidar
from cadet.sensors.rig import Rig
from cadet.simulation.streaming import FrameStream, stream
from cadet.worlds.assets import Assets
from cadet.worlds.districts import District
from cadet.worlds.policy import ResetPolicy
from cadet.worlds.props import Props
from cadet.worlds.road_map import RoadMap


@dataclass(frozen=True)
class Simulation:
    """A seed and a policy: all that frames follow from.

    Attributes:
        policy: how worlds are drawn.
        seed: names every random draw.
    """

    policy: ResetPolicy
    seed: int = 0

    @classmethod
    def read(cls, path: str | Path) -> Simulation:
        """Read a TOML file.

        Its keys, none of which it must have: `seed`; `policy` and `rig`, names of presets; `districts`, names of some;
        `vehicle_shares`, weights by class of vehicle, for every district; `lidar`, a preset or a file; `image_size`,
        width and height in pixels; `weathers`, names of presets; `maps`, OpenDRIVE files; `assets` and `props`,
        folders; `samples_per_episode`. Files are relative to this one's folder.

        Raises:
            MissingFileError: no such file.
            CadetError: an unknown key, or a value that is refused; file and key are named.
        """
        file = as_path("path", path)
        table = toml_from_text(read_settings(file), str(file))
        for key in table:
            if key not in _KEYS:
                raise FileFormatError(f"unknown key {shown(key)}; known: {', '.join(_KEYS)}", str(file))
        policy = ResetPolicy.kitti()
        for key, change in _CHANGES.items():
            if key in table:
                try:
                    policy = change(policy, table[key], file.parent)
                except (CadetError, OSError) as error:
                    raise FileFormatError(f"{key}: {error}", str(file)) from None
        try:
            return cls(policy, as_seed(table.get("seed", 0)))
        except CadetError as error:
            raise FileFormatError(str(error), str(file)) from None

    def identity(self) -> dict[str, Any]:
        """Return all that frames follow from, in plain values."""
        return {
            "seed": self.seed,
            "policy": self.policy.to_dict(),
            "rigs": {rig.name: rig.sha256() for rig, _ in self.policy.rigs},
        }

    def stream(self, *, workers: int | None = None, first: int = 0, shard: tuple[int, int] = (0, 1)) -> FrameStream:
        """Yield an endless stream of its frames: see `cadet.stream`."""
        return stream(self.policy, seed=self.seed, workers=workers, first=first, shard=shard)


def _texts(values: Any) -> list[str]:
    if not isinstance(values, list) or not values:
        raise CadetError(f"expected a list of strings, got {shown(values)}")
    for value in values:
        check_text("", "value", value)
    return values


def _with_policy(policy: ResetPolicy, value: Any, folder: Path) -> ResetPolicy:
    check_text("", "value", value)
    return ResetPolicy.named(value)


def _with_districts(policy: ResetPolicy, value: Any, folder: Path) -> ResetPolicy:
    return policy.with_districts(*map(District.named, _texts(value)))


def _with_vehicle_shares(policy: ResetPolicy, value: Any, folder: Path) -> ResetPolicy:
    return policy.with_each_district(lambda district: replace(district, vehicle_shares=value))


def _with_rig(policy: ResetPolicy, value: Any, folder: Path) -> ResetPolicy:
    check_text("", "value", value)
    return policy.with_rig(Rig.named(value))


def _with_lidar(policy: ResetPolicy, value: Any, folder: Path) -> ResetPolicy:
    check_text("", "value", value)
    lidar = Lidar.named(folder / value if value.endswith(".toml") else value)
    return policy.with_each_rig(lambda rig: rig.with_lidar(lidar))


def _with_image_size(policy: ResetPolicy, value: Any, folder: Path) -> ResetPolicy:
    width, height = check_image_size(value, "value")
    return policy.with_each_rig(lambda rig: rig.with_image_size(width, height))


def _with_weathers(policy: ResetPolicy, value: Any, folder: Path) -> ResetPolicy:
    return policy.with_weathers(*_texts(value))


def _with_maps(policy: ResetPolicy, value: Any, folder: Path) -> ResetPolicy:
    return replace(policy, maps=tuple(RoadMap.read(folder / name) for name in _texts(value)))


def _with_assets(policy: ResetPolicy, value: Any, folder: Path) -> ResetPolicy:
    check_text("", "value", value)
    return replace(policy, assets=Assets.read(folder / value))


def _with_props(policy: ResetPolicy, value: Any, folder: Path) -> ResetPolicy:
    check_text("", "value", value)
    return policy.with_props(Props.read(folder / value))


def _with_samples(policy: ResetPolicy, value: Any, folder: Path) -> ResetPolicy:
    return replace(policy, samples_per_episode=value)


# In the order in which they are applied: sensors go into the rig, and the rig into the policy.
_CHANGES: Final[dict[str, Callable[[ResetPolicy, Any, Path], ResetPolicy]]] = {
    "policy": _with_policy,
    "districts": _with_districts,
    "vehicle_shares": _with_vehicle_shares,
    "rig": _with_rig,
    "lidar": _with_lidar,
    "image_size": _with_image_size,
    "weathers": _with_weathers,
    "maps": _with_maps,
    "assets": _with_assets,
    "props": _with_props,
    "samples_per_episode": _with_samples,
}
_KEYS: Final = ("seed", *_CHANGES)
