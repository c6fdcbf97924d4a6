"""What callers' arguments make of a policy: what is given is no longer drawn."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace
from functools import partial
from pathlib import Path

from cadet._util.checks import check_kind, shown
from cadet.errors import CadetError
from cadet.sensors.rig import Rig
from cadet.worlds.assets import Assets, as_assets
from cadet.worlds.config import SceneConfig
from cadet.worlds.policy import POLICIES, EpisodeSpec, ResetPolicy
from cadet.worlds.road_map import RoadMap, as_road_map
from cadet.worlds.weather import Weather, as_weather


def choose_policy(
    policy: ResetPolicy | str | None,
    *,
    map: RoadMap | str | Path | None = None,
    weather: Weather | str | None = None,
    rig: Rig | None = None,
    assets: Assets | str | Path | None = None,
) -> ResetPolicy:
    """Return a policy, `ResetPolicy.kitti()` if None, in which what is given is no longer drawn.

    Raises:
        CadetError: an unknown policy or weather, no rig, a map that can't be read, or bad assets.
        MissingFileError: there is no such map, or no such assets.
    """
    if isinstance(policy, str):
        policy = ResetPolicy.named(policy)
    elif policy is None:
        policy = ResetPolicy.kitti()
    if not isinstance(policy, ResetPolicy):
        raise CadetError(f"policy: expected a ResetPolicy or one of {', '.join(POLICIES)}, got {shown(policy)}")
    if map is not None:
        policy = replace(policy, maps=(as_road_map(map),))
    if weather is not None:
        policy = replace(policy, weathers=((as_weather(weather), 1.0),))
    if rig is not None:
        policy = policy.with_rig(rig)
    return policy if assets is None else replace(policy, assets=as_assets(assets))


def draw_with(policy: ResetPolicy, config: SceneConfig | None) -> Callable[[int, int, int], EpisodeSpec]:
    """Return how episodes are drawn if what `config` was given, none of it if None, is not to be.

    Raises:
        CadetError: it is no configuration.
    """
    given = SceneConfig() if config is None else config
    check_kind("", "config", given, SceneConfig)
    return partial(_draw_over, policy, given)


def _draw_over(policy: ResetPolicy, given: SceneConfig, seed: int, episode: int, attempt: int) -> EpisodeSpec:
    spec = policy.draw(seed, episode, attempt)
    return replace(spec, config=given.over(spec.config), given=given.given)
