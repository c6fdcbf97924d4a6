"""What a dataset is made from."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any, Final, Literal, TypeAlias

from cadet import _cadet
from cadet.checks import as_seed, as_tuple, check_kind, check_number, is_one_of, make_plain, shown
from cadet.errors import CadetError
from cadet.policy import ResetPolicy

Split: TypeAlias = Literal["train", "val", "test"]

FORMAT_VERSION = 2
"""Rises with every change of what the same settings give."""
EXTRAS = ("depth", "instance", "semantic")
"""Folders that are written on demand."""
BASE_FOLDERS = ("image_2", "velodyne", "calib", "label_2", "planes")
"""Folders that every frame has a file in, besides `meta`."""
_TEST_EPISODE: Final = 2


@dataclass(frozen=True, kw_only=True)
class Settings:
    """Everything that decides a dataset's bytes. Workers, order and resuming don't.

    Raises:
        CadetError: a number outside its range, or an unknown extra.
    """

    seed: int = 0
    """Names every random draw."""
    num_frames: int = 20
    """Frames 0 to this; a larger number never changes a frame."""
    policy: ResetPolicy
    """Draws worlds and rigs. A preset's name stands for it when settings are made."""
    extras: tuple[str, ...] = ()
    """Folders to write besides `BASE_FOLDERS`: some of `EXTRAS`."""
    val_period: int = 5
    """Episode e is validation if e % val_period == 1, so that two episodes have some; 0 for none."""
    test_period: int = 0
    """Episode e is test, and not validation, if e % test_period == 2; 0 for none."""

    def __post_init__(self) -> None:
        as_seed(self.seed)
        if isinstance(self.policy, str):
            object.__setattr__(self, "policy", ResetPolicy.named(self.policy))
        check_kind("Settings", "policy", self.policy, ResetPolicy)
        check_number("Settings", "num_frames", self.num_frames, 1, 1_000_000, whole=True)
        check_number("Settings", "val_period", self.val_period, 0, 1_000_000, whole=True)
        if self.val_period == 1:
            raise CadetError("Settings.val_period: expected 0 or at least 2, got 1")
        check_number("Settings", "test_period", self.test_period, 0, 1_000_000, whole=True)
        if self.test_period in (1, 2):
            raise CadetError(f"Settings.test_period: expected 0 or at least 3, got {self.test_period}")
        object.__setattr__(self, "extras", as_tuple("Settings", "extras", self.extras, "folders' names"))
        for extra in self.extras:
            if not is_one_of(extra, EXTRAS):
                raise CadetError(f"cannot write {shown(extra)}; known: {', '.join(EXTRAS)}")
        make_plain(self)

    @property
    def folders(self) -> tuple[str, ...]:
        """The folders that each frame has a file in, besides `meta`."""
        return BASE_FOLDERS + tuple(extra for extra in EXTRAS if extra in self.extras)

    @property
    def num_episodes(self) -> int:
        """Episodes begun."""
        return -(-self.num_frames // self.policy.samples_per_episode)

    def num_samples(self, episode: int) -> int:
        """Return how many samples of an episode are wanted: the last one's are cut."""
        per_episode = self.policy.samples_per_episode
        return min(per_episode, self.num_frames - episode * per_episode)

    def frame_id(self, episode: int, sample: int) -> str:
        """Return the id of a sample: six digits."""
        return f"{episode * self.policy.samples_per_episode + sample:06d}"

    def split(self, episode: int) -> Split:
        """Return the split of an episode: a function of its number alone, so that more frames move none."""
        if self.test_period > 0 and episode % self.test_period == _TEST_EPISODE:
            return "test"
        return "val" if self.val_period > 0 and episode % self.val_period == 1 else "train"

    def part(self, frame_id: str) -> str:
        """Return the folder of a frame: "testing" for test frames, else "training"."""
        is_test = self.split(int(frame_id) // self.policy.samples_per_episode) == "test"
        return "testing" if is_test else "training"

    def identity(self) -> dict[str, Any]:
        """Return what must not change between a run and its resumption, in plain values: all but `num_frames`."""
        rigs = [rig for rig, _ in self.policy.rigs]
        return {
            "format": FORMAT_VERSION,
            "cadet": _cadet.__version__,
            "seed": self.seed,
            "write": list(self.folders),
            "val_period": self.val_period,
            "test_period": self.test_period,
            "policy": self.policy.to_dict(),
            "rig": rigs[0].to_dict(),
            "other_rigs": {rig.name: rig.sha256() for rig in rigs[1:]},
        }


def differences(old: object, new: object, path: str = "") -> list[tuple[str, object, object]]:
    """List where two trees of plain values differ: (path, old, new) each."""
    if isinstance(old, Mapping) and isinstance(new, Mapping):
        keys = sorted({*old, *new})
        return [
            difference
            for key in keys
            for difference in differences(old.get(key), new.get(key), f"{path}.{key}" if path else str(key))
        ]
    return [] if old == new else [(path, old, new)]
