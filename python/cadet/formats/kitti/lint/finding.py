"""What the lint says about a dataset, and the rules that it says it by."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import PurePosixPath
from typing import Final, Literal, NamedTuple

from cadet.formats.kitti.files.folder import SUFFIXES

Severity = Literal["error", "warning"]

RULES: Final[dict[str, str]] = {
    "missing-file": "a file that its frame, the other frames, or the manifest call for is missing",
    "unreadable-file": "a file or folder that the system does not let read",
    "damaged-file": "a file that cannot be decoded or parsed, or whose size does not fit its frame",
    "dialect": "a deviation from KITTI's format that is read anyway, such as scans of five columns",
    "stray-file": "a file that belongs to no frame",
    "wrong-hash": "a file that differs from the one that was written, by the hashes of manifest and `meta`",
    "manifest": "a manifest that is malformed, or counts other frames and labels than there are",
    "image-set": "a list of `ImageSets` that is missing, malformed, or names missing frames",
    "split-overlap": "a frame in two splits",
    "episode-overlap": "an episode with frames in two splits",
    "duplicate-frame": "an image or scan that another frame has too, or almost",
    "calibration": "a matrix that is not a rotation, or a camera without a focal length",
    "ground-plane": "a plane that is not normalized, not upright, or not under the car",
    "scan": "points without a plausible range or intensity, or no points",
    "scan-off-image": "a scan with no point in the image",
    "scan-off-labels": "a scan without a return in any of its frame's near, unhidden boxes",
    "depth-off-scan": "a depth map that disagrees with the scan",
    "label-field": "a field outside its range",
    "label-bbox": "a 2D box that is empty or leaves the image",
    "label-projection": "a 2D box that does not match the projected 3D box",
    "label-truncation": "a truncation that does not match the projected box",
    "label-alpha": "an observation angle that does not match the box",
    "label-evidence": "an object that neither scan nor image shows",
    "dont-care": "a DontCare line with fields that it should not have",
    "other-readers": "what OpenPCDet and MMDetection3D fail on or misread",
    "meta": "a `meta` that is malformed, or belongs to another frame",
    "table-row": "a row of nuScenes' tables that names no row of another, or an invalid pose or box",
}
"""Each kind of finding, and what it means."""


@dataclass(frozen=True)
class Finding:
    """One thing that is wrong with a dataset.

    Attributes:
        file: the file, relative to the folder that holds `calib`, or to the dataset's root.
        line: the line from 1; None where the file as a whole is meant.
        rule: which kind of thing, a key of `RULES`.
        message: what is wrong, with the value and what was expected.
        severity: "error", or "warning" for what human-made labels get away with.
    """

    file: str
    line: int | None
    rule: str
    message: str
    severity: Severity = "error"

    def __str__(self) -> str:
        return f"{self.place}: {self.severity}: {self.message}"

    @property
    def frame_id(self) -> str | None:
        """The frame's id; None for what is not a frame's file."""
        path = PurePosixPath(self.file)
        return path.stem if path.parent.name in SUFFIXES else None

    @property
    def place(self) -> str:
        """The file, and the line where there is one."""
        return self.file if self.line is None else f"{self.file}:{self.line}"


class Problem(NamedTuple):
    """A problem of a file that the caller knows: see `Finding`."""

    line: int | None
    rule: str
    message: str
    severity: Severity = "error"
