"""Which frames belong together: those of an episode or a drive are alike, so a bootstrap draws them together."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import TypeAlias

import numpy as np
from numpy.typing import NDArray

from cadet._util.checks import as_path, shown
from cadet._util.plain_text import json_from_text
from cadet.errors import CadetError, FileFormatError, MissingFileError
from cadet.formats.kitti.files.text import content_lines, text_from_bytes

GroupSource: TypeAlias = str | Path | Mapping[str, str] | None

FRAMES, EPISODES = "frames", "episodes"
_MANIFEST = "manifest.json"


@dataclass(frozen=True, eq=False)
class Groups:
    """Frames that are drawn together.

    Attributes:
        unit: what a group is: "frames", each its own, "episodes", or "groups" of a file.
        members: the indices of each group's frames, in order; groups in the order in which they come first.
    """

    unit: str
    members: tuple[NDArray[np.int64], ...]

    def __len__(self) -> int:
        return len(self.members)


def find_groups(source: GroupSource, ids: Sequence[str], labels: Path | None) -> Groups:
    """Group frames.

    Args:
        source: "frames"; "episodes" of a dataset that cadet generated; a file with lines of an id and a group's name; a
            dictionary from ids to names; or None: episodes where the labels belong to such a dataset, else frames.
        ids: of the frames that are evaluated.
        labels: the labels' folder; None for ground truth in memory.

    Raises:
        MissingFileError: no such file, or no manifest for episodes.
        FileFormatError: a file that breaks its format.
        CadetError: a frame without a group.
    """
    if source is None:
        source = FRAMES if labels is None or _manifest_of(labels) is None else EPISODES
    if isinstance(source, str) and source == FRAMES:
        return Groups(FRAMES, tuple(np.array([index]) for index in range(len(ids))))
    if isinstance(source, str) and source == EPISODES:
        return Groups(EPISODES, _members(_episodes(ids, labels), ids, "the manifest"))
    if isinstance(source, str | Path):
        return Groups("groups", _members(_read(as_path("groups", source)), ids, str(source)))
    if isinstance(source, Mapping):
        return Groups("groups", _members(source, ids, "groups"))
    raise CadetError(f"groups: expected frames, episodes, a file or a dictionary by frame, got {shown(source)}")


def _members(names: Mapping[str, str], ids: Sequence[str], where: str) -> tuple[NDArray[np.int64], ...]:
    found: dict[str, list[int]] = {}
    for index, frame_id in enumerate(ids):
        if frame_id not in names:
            raise CadetError(f"{where}: frame {frame_id} has no group")
        found.setdefault(str(names[frame_id]), []).append(index)
    return tuple(np.array(indices, np.int64) for indices in found.values())


def _manifest_of(labels: Path) -> Path | None:
    """Find the manifest of the dataset that labels belong to: `root/training/label_2` or `root/testing/label_2`."""
    path = labels.resolve().parent.parent / _MANIFEST
    return path if path.is_file() else None


def _episodes(ids: Sequence[str], labels: Path | None) -> dict[str, str]:
    path = None if labels is None else _manifest_of(labels)
    if path is None:
        raise MissingFileError("groups: the ground truth has no manifest.json of cadet's, which episodes are read from")
    manifest = json_from_text(path.read_bytes(), str(path))
    policy = manifest.get("policy") if isinstance(manifest, dict) else None
    count = policy.get("samples_per_episode") if isinstance(policy, dict) else None
    if not isinstance(count, int) or isinstance(count, bool) or count < 1:
        raise FileFormatError("policy.samples_per_episode: expected a whole number of at least 1", str(path))
    odd = next((frame_id for frame_id in ids if not (frame_id.isascii() and frame_id.isdecimal())), None)
    if odd is not None:
        raise CadetError(
            f"groups: episodes are known of numbered frames alone, got {shown(odd)}; name a file of groups"
        )
    return {frame_id: str(int(frame_id) // count) for frame_id in ids}


def _read(path: Path) -> dict[str, str]:
    if not path.is_file():
        raise MissingFileError(f"{path}: no such file of groups; expected frames, episodes, or a file")
    return groups_from_text(text_from_bytes(path.read_bytes(), str(path), "utf-8"), str(path))


def groups_from_text(text: str, file: str) -> dict[str, str]:
    """Parse lines of a frame's id and its group's name.

    Raises:
        FileFormatError: another line, or a frame that comes twice.
    """
    names: dict[str, str] = {}
    for number, line in content_lines(text):
        fields = line.split()
        if len(fields) != 2:
            raise FileFormatError(f"expected a frame's id and a group's name, got {shown(line)}", file, number)
        if fields[0] in names:
            raise FileFormatError(f"frame {shown(fields[0])} comes twice", file, number)
        names[fields[0]] = fields[1]
    return names
