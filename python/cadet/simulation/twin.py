"""A frame twice: as a dataset has it, and with one cause changed."""

from __future__ import annotations

from collections.abc import Callable

from cadet._util.checks import as_seed, check_number, shown
from cadet.errors import CadetError
from cadet.formats.kitti import Frame, frame_from_sample
from cadet.sensors.sample import Wanted
from cadet.simulation.episode import Episode
from cadet.worlds.policy import EpisodeSpec, ResetPolicy
from cadet.worlds.policy_choice import choose_policy


def twin(
    change: Callable[[EpisodeSpec], EpisodeSpec],
    *,
    policy: ResetPolicy | str | None = None,
    seed: int = 0,
    frame: int = 0,
) -> tuple[Frame, Frame]:
    """Return a frame of a dataset, and the same street at the same instant with something of its draw changed.

    Streets and traffic follow from seed, episode, map, and the numbers of `EpisodeSpec.config`: with another weather,
    sun, or rig, or other rules for labels, everything moves alike. Only umbrellas open where it begins to rain, and
    where the finest of all sensors is replaced, meshes may be seen in another level of detail.

    Args:
        change: from the draw of the frame's world to another, such as
            `lambda spec: dataclasses.replace(spec, weather=cadet.Weather.preset("snow"))`.
        policy: draws the worlds, or the name of a preset; `ResetPolicy.kitti()` if None.
        seed: the dataset's.
        frame: its number in the dataset. Its episode is driven from the beginning to it.

    Raises:
        CadetError: an unknown policy, a number out of range, or a change that gives no draw or one that is refused.
    """
    chosen = choose_policy(policy, map=None, weather=None, rig=None, assets=None)
    check_number("twin", "frame", frame, 0, 999_999, whole=True)
    episode, number = divmod(int(frame), chosen.samples_per_episode)
    views = Episode(chosen, as_seed(seed), episode, wanted=Wanted.all_of(None, ()))
    for sample in range(number):
        views.next_sample(sample)
    first = frame_from_sample(views.next_sample(number))

    def checked(spec: EpisodeSpec) -> EpisodeSpec:
        found = change(spec)
        if not isinstance(found, EpisodeSpec):
            raise CadetError(f"twin.change: expected a function that returns a cadet.EpisodeSpec, got {shown(found)}")
        return found

    return first, frame_from_sample(views.otherwise(checked))
