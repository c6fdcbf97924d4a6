"""A frame twice: as a dataset has it, and with one cause changed."""

from __future__ import annotations

import math
from collections.abc import Callable, Iterable, Mapping
from typing import Final

from cadet import _cadet
from cadet._util.checks import as_seed, check_number, shown
from cadet.errors import CadetError
from cadet.formats.kitti import Frame, frame_from_sample
from cadet.sensors.sample import Wanted
from cadet.simulation.episode import Episode
from cadet.worlds.policy import EpisodeSpec, ResetPolicy
from cadet.worlds.policy_choice import choose_policy

_FARTHEST_M: Final = 250.0


def twin(
    change: Callable[[EpisodeSpec], EpisodeSpec] | None = None,
    *,
    without: Iterable[int] = (),
    moved: Mapping[int, tuple[float, float, float]] | None = None,
    noise: int = 0,
    policy: ResetPolicy | str | None = None,
    seed: int = 0,
    frame: int = 0,
) -> tuple[Frame, Frame]:
    """Return a frame of a dataset, and the same street at the same instant with one cause changed.

    Streets and traffic follow from seed, episode, map, and the numbers of `EpisodeSpec.config`: with another weather,
    sun, or rig, or other rules for labels, everything moves alike. Only umbrellas open where it begins to rain, and
    where the finest of all sensors is replaced, meshes may be seen in another level of detail. Actors are removed and
    moved at the instant of the frame: others did not drive otherwise because of it. The camera meters what it sees, so
    where an object is gone, the whole image may be a little brighter.

    Args:
        change: from the draw of the frame's world to another, such as
            `lambda spec: dataclasses.replace(spec, weather=cadet.Weather.preset("snow"))`.
        without: ids of actors that are not there, as in the frame's `instance` map and `meta.objects`.
        moved: by actor's id, how far it is moved forward and to its left, meters, and turned to the left, degrees, in
            the plane that it stands on.
        noise: another number gives the sensors other noise, and rain and spray other drops.
        policy: draws the worlds, or the name of a preset; `ResetPolicy.kitti()` if None.
        seed: the dataset's.
        frame: its number in the dataset. Its episode is driven from the beginning to it.

    Raises:
        CadetError: an unknown policy, a number out of range, an id that no actor has, or a change that gives no draw or
            one that is refused.
    """
    chosen = choose_policy(policy, map=None, weather=None, rig=None, assets=None)
    check_number("twin", "frame", frame, 0, 999_999, whole=True)
    check_number("twin", "noise", noise, 0, 999_999, whole=True)
    retouch = _retouched(without, moved or {})
    episode, number = divmod(int(frame), chosen.samples_per_episode)
    views = Episode(chosen, as_seed(seed), episode, wanted=Wanted.all_of(None, ()))
    for sample in range(number):
        views.next_sample(sample)
    first = frame_from_sample(views.next_sample(number))

    def checked(spec: EpisodeSpec) -> EpisodeSpec:
        found = spec if change is None else change(spec)
        if not isinstance(found, EpisodeSpec):
            raise CadetError(f"twin.change: expected a function that returns a cadet.EpisodeSpec, got {shown(found)}")
        return found

    return first, frame_from_sample(views.otherwise(checked, retouch, int(noise)))


def _retouched(
    without: Iterable[int], moved: Mapping[int, tuple[float, float, float]]
) -> Callable[[_cadet.Scene], None]:
    absent, shifts = tuple(without), dict(moved)
    for actor_id in (*absent, *shifts):
        check_number("twin", "actor id", actor_id, 1, 2**31 - 1, whole=True)
    for shift in shifts.values():
        if not isinstance(shift, tuple) or len(shift) != 3:
            raise CadetError(f"twin.moved: expected (forward m, left m, degrees), got {shown(shift)}")
        for name, value, most in zip(
            ("forward", "left", "turn"), shift, (_FARTHEST_M, _FARTHEST_M, 360.0), strict=True
        ):
            check_number("twin.moved", name, value, -most, most)

    def apply(scene: _cadet.Scene) -> None:
        for actor_id in absent:
            scene.hide_actor(actor_id)
        for actor_id, (forward_m, left_m, turn_deg) in shifts.items():
            scene.shift_actor(actor_id, forward_m, left_m, math.radians(turn_deg))

    return apply
