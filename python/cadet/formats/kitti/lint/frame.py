"""The lint of one frame: its files, and each field against its definition."""

from __future__ import annotations

from collections import Counter
from collections.abc import Callable, Iterable, Mapping
from dataclasses import dataclass, field, replace
from functools import partial
from hashlib import sha256
from pathlib import Path
from typing import Any, Final

import numpy as np
from numpy.typing import NDArray

from cadet.errors import CadetError, KittiFormatError, MissingFileError
from cadet.formats.kitti.calib import Calibration
from cadet.formats.kitti.dataset import errors_of_files
from cadet.formats.kitti.files.dialects import collected
from cadet.formats.kitti.files.folder import (
    OF_CAMERA,
    camera_kind,
    camera_names,
    display_name,
    folder_of,
    found_path,
    is_kind,
)
from cadet.formats.kitti.files.point_labels import point_labels_from_bytes, point_times_from_bytes
from cadet.formats.kitti.files.range_image import range_image_from_bytes
from cadet.formats.kitti.frame import Frame
from cadet.formats.kitti.frame_files import (
    CameraFiles,
    FolderFiles,
    FrameFiles,
    frame_from_files,
    image_from_files,
    read_text,
)
from cadet.formats.kitti.label import labels_from_text
from cadet.formats.kitti.lint.duplicates import Signature, signature_of
from cadet.formats.kitti.lint.evidence import lint_evidence
from cadet.formats.kitti.lint.finding import Finding, Problem, Severity
from cadet.formats.kitti.lint.labels import lint_labels
from cadet.formats.kitti.lint.lists import findings_of, printable
from cadet.formats.kitti.lint.meta import episode_of, lint_meta, lint_seal, recorded_hashes
from cadet.formats.kitti.lint.readers import lint_calib_lines, lint_depths, lint_label_lines

_UNIT_TOLERANCE: Final = 1e-3
_PLANE_HEIGHT_M: Final = (1.0, 2.5)
SCAN_RANGE_M: Final = (1.45, 80.0)
"""Of returns, where no manifest says another."""
_LOOSE_RANGE_M: Final = 120.0
_MM: Final = 0.001
_RIGHT_IMAGE: Final = "image_3"
_RIGHT_LABELS: Final = "label_3"
_PER_POINT: Final[Mapping[str, Callable[[bytes], NDArray[Any]]]] = {
    "point_labels": point_labels_from_bytes,
    "point_times": point_times_from_bytes,
    "range_image": lambda data: np.flatnonzero(range_image_from_bytes(data)),
}


@dataclass(frozen=True)
class Task:
    """A frame to check.

    Attributes:
        folder: the folder that holds `calib` and its fellows.
        frame_id: of the frame.
        strict: tight tolerances, and errors instead of warnings.
        scan_range_m: least and greatest range of a strict set's returns.
        hashes: SHA-256 of its files by folder, as the manifest has them.
        usual: optional folders in which most other frames have a file.
        absent: folders in which no frame has a file, which is said once for all.
    """

    folder: Path
    frame_id: str
    strict: bool
    scan_range_m: tuple[float, float] = SCAN_RANGE_M
    hashes: Mapping[str, str] = field(default_factory=dict)
    usual: tuple[str, ...] = ()
    absent: tuple[str, ...] = ()


@dataclass(frozen=True)
class Report:
    """What checking a frame gave.

    Attributes:
        findings: what is wrong, file by file.
        types: how many labels of each type there are; empty where they cannot be read.
        episode: seed and number of the episode; None where no `meta` says them.
        signature: what tells it from others; None where the frame cannot be read.
    """

    findings: list[Finding]
    types: Counter[str]
    episode: tuple[object, object] | None
    signature: Signature | None


def examine(task: Task) -> Report:
    """Check one frame. Whatever the files hold, and whether or not they can be read, there is a report."""
    with collected() as dialects:
        report = _FrameLint(task).run()
    return replace(report, findings=findings_of(dialects, "error" if task.strict else "warning") + report.findings)


def display(path: Path) -> str:
    """Name a file: its folder and name, led by `testing` for a test frame's."""
    name = path.parent.name if path.suffix == "" and path.parent.name in ("training", "testing") else ""
    shown = path.name if name else display_name(path)
    is_test = "testing" in (path.parent.name, folder_of(path).name)
    return printable(f"testing/{shown}" if is_test else shown)


class _FrameLint:
    """The findings about one frame."""

    def __init__(self, task: Task) -> None:
        self.task = task
        self.folder = task.folder
        self.files = FolderFiles(task.folder)
        self.frame_id = task.frame_id
        self.soft: Severity = "error" if task.strict else "warning"
        self.findings: list[Finding] = []
        self.is_damaged: set[str] = set()

    def run(self) -> Report:
        """Check file by file; what cannot be read is one finding and is left out of the checks that need it."""
        frame: Frame | None = None
        try:
            frame = frame_from_files(self.files, self.frame_id)
            texts = self._texts(self.files)
        except (CadetError, OSError) as error:
            self._lint_readable_files(self.files)
            if not self.findings and not self.task.absent:
                self._add("image_2", Problem(None, "damaged-file", f"the frame cannot be read: {error}"))
            frame = None
        else:
            # Numbers of a damaged file may overflow; comparing finds what comes of it, a warning would say it twice.
            with np.errstate(all="ignore"):
                self._lint_seen(frame, texts)
                self._lint_frame(frame)
        self._lint_cameras()
        self._lint_presence()
        self._lint_hashes(None if frame is None else recorded_hashes(frame.meta))
        if frame is not None and frame.meta is not None and "meta" not in self.is_damaged:
            self._extend("meta", lint_seal(self._optional("meta") or b"", frame.meta))
        if frame is None:
            return Report(self.findings, Counter(), None, None)
        types = Counter(label.type for label in frame.labels)
        return Report(self.findings, types, episode_of(frame.meta), signature_of(frame))

    def _lint_seen(self, frame: Frame, texts: dict[str, str], kind_of: Callable[[str], str] = str) -> None:
        """Check the calibration and the labels of one camera, whose files of a kind `kind_of` names."""
        calib, labels = kind_of("calib"), kind_of("label_2")
        self._lint_calib(frame.calib, calib)
        self._extend(calib, lint_calib_lines(texts["calib"], self.soft))
        if (self.folder / labels).is_dir():
            self._extend(labels, lint_label_lines(texts["label_2"], frame.labels, self.soft))
        problems = lint_labels(texts["label_2"], frame.labels, frame.calib, frame.image_size, strict=self.task.strict)
        self._extend(labels, problems)

    def _lint_frame(self, frame: Frame) -> None:
        self._lint_points(frame.points_velo)
        self._extend("velodyne", lint_depths(frame.points_velo, frame.calib, self.soft))
        self._lint_right_image(frame)
        self._lint_right_labels(frame)
        for kind in _PER_POINT:
            self._lint_per_point(kind, frame)
        if frame.plane is not None:
            self._lint_plane(frame.plane)
        if frame.meta is not None:
            for kind, problem in lint_meta(frame.meta, frame):
                self._add(kind, problem)
        # A wrong calibration shows in every box: it is said once.
        if "calib" not in self.is_damaged:
            for kind, problem in lint_evidence(frame, self.soft):
                self._add(kind, problem)

    def _lint_cameras(self) -> None:
        """Check what further cameras saw, each against its own calibration."""
        for name in camera_names(self.folder):
            files, kind_of = CameraFiles(self.files, name), partial(camera_kind, name)
            if not any(files.has(kind, self.frame_id) for kind in OF_CAMERA):
                continue
            try:
                seen, texts = frame_from_files(files, self.frame_id), self._texts(files)
            except (CadetError, OSError):
                self._lint_readable_files(files, kind_of)
            else:
                with np.errstate(all="ignore"):
                    self._lint_seen(seen, texts, kind_of)

    def _texts(self, files: FrameFiles) -> dict[str, str]:
        kinds = [kind for kind in ("calib", "label_2") if files.has(kind, self.frame_id)]
        return {"calib": "", "label_2": ""} | {kind: read_text(files, kind, self.frame_id)[0] for kind in kinds}

    def _add(self, kind: str, problem: Problem) -> None:
        if problem.severity == "error":
            self.is_damaged.add(kind)
        self.findings.append(Finding(display(found_path(self.folder, kind, self.frame_id)), *problem))

    def _extend(self, kind: str, problems: Iterable[Problem]) -> None:
        for problem in problems:
            self._add(kind, problem)

    def _lint_readable_files(self, files: FrameFiles, kind_of: Callable[[str], str] = str) -> None:
        for own, error in errors_of_files(files, self.frame_id):
            kind = kind_of(own)
            # What cameras share has been looked at with the first.
            if kind != own and (own not in OF_CAMERA or not files.has_kind(own)):
                continue
            if isinstance(error, MissingFileError):
                if kind not in self.task.absent:
                    self._add(kind, Problem(None, "missing-file", "missing"))
            elif isinstance(error, KittiFormatError):
                rule = "meta" if kind == "meta" else "damaged-file"
                self._add(kind, Problem(error.line, rule, error.reason))
            elif isinstance(error, OSError):
                self._add(kind, Problem(None, "unreadable-file", f"cannot be read: {error.strerror or error}"))
            else:
                self._add(kind, Problem(None, "damaged-file", str(error)))

    def _lint_presence(self) -> None:
        """Find files that the manifest or the other frames' example calls for."""
        for kind in dict.fromkeys((*self.task.hashes, *self.task.usual)):
            if kind in self.is_damaged or found_path(self.folder, kind, self.frame_id).exists():
                continue
            if kind in self.task.hashes:
                self._add(kind, Problem(None, "missing-file", "missing, but manifest.json names it"))
            else:
                self._add(kind, Problem(None, "missing-file", "missing: most other frames have one", self.soft))

    def _lint_hashes(self, recorded: Mapping[str, str] | None) -> None:
        """Compare files with the manifest's hashes, or, for those that it does not name, with the record's."""
        expected = {kind: (digest, f"meta/{self.frame_id}.json") for kind, digest in (recorded or {}).items()}
        expected |= {kind: (digest, "manifest.json") for kind, digest in self.task.hashes.items()}
        for kind, (digest, source) in expected.items():
            # A file of which something worse is known need not be named again.
            if kind in self.is_damaged or not is_kind(kind):
                continue
            try:
                found = sha256(found_path(self.folder, kind, self.frame_id).read_bytes()).hexdigest()
            except FileNotFoundError:
                self._add(kind, Problem(None, "missing-file", f"missing, but {source} names it"))
            except OSError as error:
                self._add(kind, Problem(None, "unreadable-file", f"cannot be read: {error.strerror or error}"))
            else:
                if found != digest:
                    self._add(kind, Problem(None, "wrong-hash", f"not the file that {source} names"))

    def _lint_right_labels(self, frame: Frame) -> None:
        if not self.files.has(_RIGHT_LABELS, self.frame_id):
            return
        calib = replace(frame.calib, P2=frame.calib.P3)
        try:
            text, name = read_text(self.files, _RIGHT_LABELS, self.frame_id)
            labels = labels_from_text(text, name)
        except KittiFormatError as error:
            self._add(_RIGHT_LABELS, Problem(error.line, "damaged-file", error.reason))
        except OSError as error:
            self._add(_RIGHT_LABELS, Problem(None, "unreadable-file", f"cannot be read: {error.strerror or error}"))
        else:
            self._extend(_RIGHT_LABELS, lint_label_lines(text, labels, self.soft))
            # KITTI's projections are 0 where they are unknown.
            if calib.P3.any():
                problems = lint_labels(text, labels, calib, frame.image_size, strict=self.task.strict)
                self._extend(_RIGHT_LABELS, problems)

    def _lint_right_image(self, frame: Frame) -> None:
        if not self.files.has(_RIGHT_IMAGE, self.frame_id):
            return
        try:
            image = image_from_files(self.files, self.frame_id, _RIGHT_IMAGE)
        except KittiFormatError as error:
            self._add(_RIGHT_IMAGE, Problem(None, "damaged-file", error.reason))
            return
        except OSError as error:
            self._add(_RIGHT_IMAGE, Problem(None, "unreadable-file", f"cannot be read: {error.strerror or error}"))
            return
        if image.shape != frame.image.shape:
            sizes = f"{image.shape[1]} x {image.shape[0]} pixels, image_2 has {frame.image_size[0]} x"
            self._add(_RIGHT_IMAGE, Problem(None, "damaged-file", f"{sizes} {frame.image_size[1]}"))

    def _lint_per_point(self, kind: str, frame: Frame) -> None:
        data = self._optional(kind)
        if data is None:
            return
        try:
            number = len(_PER_POINT[kind](data))
        except KittiFormatError as error:
            self._add(kind, Problem(None, "damaged-file", error.reason))
            return
        # A pixel of a range image has one of its beam's echoes.
        fits = number <= len(frame.points_velo) if kind == "range_image" else number == len(frame.points_velo)
        if not fits:
            message = f"holds {number} points, the scan has {len(frame.points_velo)}"
            self._add(kind, Problem(None, "damaged-file", message))

    def _optional(self, kind: str) -> bytes | None:
        path = found_path(self.folder, kind, self.frame_id)
        try:
            return path.read_bytes() if path.is_file() else None
        except OSError as error:
            self._add(kind, Problem(None, "unreadable-file", f"cannot be read: {error.strerror or error}"))
            return None

    def _lint_calib(self, calib: Calibration, kind: str) -> None:
        for name, rotation in (
            ("R0_rect", calib.R0_rect),
            ("Tr_velo_to_cam", calib.Tr_velo_to_cam[:, :3]),
            ("Tr_imu_to_velo", calib.Tr_imu_to_velo[:, :3]),
        ):
            if name == "Tr_imu_to_velo" and not calib.Tr_imu_to_velo.any():
                continue
            deviation = float(np.abs(rotation @ rotation.T - np.eye(3)).max())
            if not (deviation <= _UNIT_TOLERANCE and np.linalg.det(rotation) > 0.0):
                self._add(kind, Problem(None, "calibration", f"{name}: not a rotation (off by {deviation:.2g})"))
        if min(calib.P2[0, 0], calib.P2[1, 1]) <= 0.0:
            self._add(
                kind,
                Problem(None, "calibration", f"P2: focal lengths {calib.P2[0, 0]}, {calib.P2[1, 1]} are not positive"),
            )

    def _lint_plane(self, plane: NDArray[np.float64]) -> None:
        length = float(np.linalg.norm(plane[:3]))
        if not abs(length - 1.0) <= _UNIT_TOLERANCE:
            self._add("planes", Problem(4, "ground-plane", f"normal has length {length:.6f}, expected 1"))
        if plane[1] >= 0.0:
            self._add(
                "planes", Problem(4, "ground-plane", f"b = {plane[1]:.6f}, expected below 0: the normal must point up")
            )
        low, high = _PLANE_HEIGHT_M
        if not low <= plane[3] <= high:
            self._add("planes", Problem(4, "ground-plane", f"d = {plane[3]:.3f} m, expected {low}..{high}", self.soft))

    def _lint_points(self, points_velo: NDArray[np.float32]) -> None:
        if not len(points_velo):
            self._add("velodyne", Problem(None, "scan", "no points", self.soft))
            return
        intensity = points_velo[:, 3]
        if intensity.min() < 0.0 or intensity.max() > 1.0:
            low, high = float(intensity.min()), float(intensity.max())
            message = f"intensity {low:.3f}..{high:.3f}, expected 0..1: divide by the greatest, such as 255"
            self._add("velodyne", Problem(None, "scan", message, self.soft))
        range_m = np.linalg.norm(points_velo[:, :3].astype(np.float64), axis=1)
        num_zero = int((range_m == 0.0).sum())
        if num_zero and not self.task.strict:
            message = f"{num_zero} points at the origin: no returns? Leave them out"
            self._add("velodyne", Problem(None, "scan", message, self.soft))
        low, high = (
            self.task.scan_range_m if self.task.strict else (0.0, max(_LOOSE_RANGE_M, self.task.scan_range_m[1]))
        )
        # Rounding x, y and z to millimeters moves a point by up to 0.9 mm.
        num_outside = int(((range_m < low - _MM) | (range_m > high + _MM)).sum())
        if num_outside:
            message = f"{num_outside} points with range outside {low}..{high} m (smallest {range_m.min():.3f}, "
            message += f"largest {range_m.max():.3f})"
            self._add("velodyne", Problem(None, "scan", message, self.soft))
