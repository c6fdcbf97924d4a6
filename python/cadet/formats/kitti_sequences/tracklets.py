"""KITTI raw's `tracklet_labels.xml`: boxes over time in the velo frame."""

from __future__ import annotations

import math
from collections.abc import Iterator, Sequence
from dataclasses import dataclass, field
from typing import Final

from cadet.formats.kitti_sequences.record import Record, wrapped
from cadet.sensors.pose import cos_sin

_TYPES: Final = {"Person_sitting": "Person (sitting)"}
_HEAD: Final = """<?xml version="1.0" encoding="UTF-8" standalone="yes" ?>
<!DOCTYPE boost_serialization>
<boost_serialization signature="serialization::archive" version="9">
<tracklets class_id="0" tracking_level="0" version="0">
"""
_INTERPOLATED, _LABELED = 1, 2
_UNKNOWN: Final = -1
_IN_IMAGE, _TRUNCATED = 0, 1


@dataclass
class Tracklet:
    """An object from the first frame with its label to the last one, without a gap."""

    type: str
    size_lwh: Sequence[float]
    first_frame: int
    poses: list[str] = field(default_factory=list)

    def lines(self) -> Iterator[str]:
        """Yield the tracklet's lines."""
        length, width, height = self.size_lwh
        yield f"<item><objectType>{_TYPES.get(self.type, self.type)}</objectType>"
        yield f"<h>{height:.6f}</h><w>{width:.6f}</w><l>{length:.6f}</l>"
        yield f"<first_frame>{self.first_frame}</first_frame>"
        yield f"<poses><count>{len(self.poses)}</count><item_version>2</item_version>"
        yield from self.poses
        yield "</poses><finished>1</finished></item>"


def tracklets_of(records: Sequence[Record]) -> list[Tracklet]:
    """Return the tracklets of a drive, by the frame of their first label and by agent.

    Where an object has no label, its box moves on with the agent that it belongs to, and its state is "interpolated".
    An agent that was farther than 120 m meanwhile begins a new tracklet.
    """
    labels: dict[int, dict[int, Record]] = {}
    for frame, record in enumerate(records):
        for seen in record["objects"]:
            if seen["is_labeled"]:
                labels.setdefault(seen["id"], {})[frame] = seen
    found = [tracklet for agent, seen in labels.items() for tracklet in _tracklets(agent, seen, records)]
    return sorted(found, key=lambda tracklet: tracklet.first_frame)


def text_of_tracklets(tracklets: Sequence[Tracklet]) -> str:
    """Return the file's text."""
    body = "".join(f"{line}\n" for tracklet in tracklets for line in tracklet.lines())
    count = f"<count>{len(tracklets)}</count><item_version>1</item_version>\n"
    return f"{_HEAD}{count}{body}</tracklets>\n</boost_serialization>\n"


def _tracklets(agent: int, labels: dict[int, Record], records: Sequence[Record]) -> Iterator[Tracklet]:
    tracklet: Tracklet | None = None
    before = -1
    for frame, seen in labels.items():
        hidden = [records[index]["agents"].get(str(agent)) for index in range(before + 1, frame)]
        start = records[before]["agents"].get(str(agent))
        if tracklet is None or None in hidden or (hidden and start is None):
            if tracklet is not None:
                yield tracklet
            tracklet = Tracklet(seen["type"], seen["size_lwh"], frame)
        elif hidden:
            offset = _offset(labels[before]["pose_velo"], start)
            tracklet.poses += [_pose(_moved(pose, offset), _INTERPOLATED, _UNKNOWN, _UNKNOWN) for pose in hidden]
        truncation = _TRUNCATED if seen["truncation"] > 0.0 else _IN_IMAGE
        tracklet.poses.append(_pose(seen["pose_velo"], _LABELED, seen["occlusion_level"], truncation))
        before = frame
    if tracklet is not None:
        yield tracklet


def _offset(pose: Sequence[float], agent: Sequence[float]) -> tuple[float, float, float, float]:
    """Return where a labeled box stands on its agent: forward, left, up, and turned."""
    x, y, z = (a - b for a, b in zip(pose[:3], agent[:3], strict=True))
    c, s = cos_sin(math.degrees(agent[3]))
    return c * x + s * y, c * y - s * x, z, pose[3] - agent[3]


def _moved(agent: Sequence[float], offset: Sequence[float]) -> tuple[float, float, float, float]:
    c, s = cos_sin(math.degrees(agent[3]))
    x, y, z, turn = offset
    return agent[0] + c * x - s * y, agent[1] + s * x + c * y, agent[2] + z, wrapped(agent[3] + turn)


def _pose(pose: Sequence[float], state: int, occlusion: int, truncation: int) -> str:
    x, y, z, heading = pose
    place = f"<tx>{x:.6f}</tx><ty>{y:.6f}</ty><tz>{z:.6f}</tz><rx>0</rx><ry>0</ry><rz>{heading:.6f}</rz>"
    levels = f"<occlusion>{occlusion}</occlusion><occlusion_kf>0</occlusion_kf><truncation>{truncation}</truncation>"
    unset = "".join(f"<amt_{name}>-1</amt_{name}>" for name in ("occlusion", "occlusion_kf"))
    unset += "".join(f"<amt_border_{name}>-1</amt_border_{name}>" for name in ("l", "r", "kf"))
    return f"<item>{place}<state>{state}</state>{levels}{unset}</item>"
