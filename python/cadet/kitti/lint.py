"""Check a KITTI folder against the definitions of its fields, and against what other programs' readers rely on."""

from __future__ import annotations

from collections.abc import Iterable
from pathlib import Path
from typing import Any, Final

import numpy as np
from numpy.typing import NDArray

from cadet.errors import CadetError, KittiFormatError, MissingFileError
from cadet.kitti import dataset
from cadet.kitti.calib import Calibration
from cadet.kitti.files import check_id, display_name, file_path, frame_ids, sample_folder, testing_folder
from cadet.kitti.finding import Finding, Problem, Severity
from cadet.kitti.frame import Frame
from cadet.kitti.label import Label
from cadet.kitti.lint_labels import ROUNDING, lint_labels
from cadet.kitti.lint_lists import MANIFEST, is_number, lint_folders, lint_lists, lint_manifest, printable
from cadet.kitti.lint_readers import lint_calib_lines, lint_depths, lint_label_lines

_UNIT_TOLERANCE: Final = 1e-3
_PLANE_HEIGHT_M: Final = (1.0, 2.5)
_SCAN_RANGE_M: Final = (1.45, 80.0)
_LOOSE_RANGE_M: Final = 120.0
_MM: Final = 0.001
_XYZ: Final = 3


def lint(root: str | Path, *, strict: bool | None = None) -> list[Finding]:
    """Check every frame of a KITTI folder: files, formats, and each field against its definition.

    Whatever the files hold, and whether or not they can be read, the result is a list.

    Args:
        root: the folder that holds `training`, `testing` and `ImageSets`.
        strict: tight tolerances and no warnings; None decides by whether `root/manifest.json` shows the set to be
            generated.

    Returns:
        What is wrong, in the order of lists, then frames; empty if nothing is.

    Raises:
        MissingFileError: there is no KITTI folder.
    """
    root = Path(root)
    folder, testing = sample_folder(root), testing_folder(root)
    is_generated = (root / MANIFEST).is_file()
    is_strict = is_generated if strict is None else strict
    range_m, findings = lint_manifest(root)
    ids = frame_ids(folder)
    test_ids = () if testing is None else frame_ids(testing)
    findings += lint_lists(root, set(ids), set(test_ids), strict=is_strict, generated=is_generated)
    for part, part_ids in ((folder, ids), (testing, test_ids)):
        if part is not None:
            findings += lint_folders(part, set(part_ids), _display)
            for frame_id in part_ids:
                findings += _FrameLint(part, frame_id, is_strict, range_m or _SCAN_RANGE_M).run()
    return findings


def lint_frame(root: str | Path, frame_id: str | int, *, strict: bool) -> list[Finding]:
    """Check one frame: see `lint`."""
    folder = sample_folder(root)
    range_m, _ = lint_manifest(Path(root))
    return _FrameLint(folder, check_id(frame_id), strict, range_m or _SCAN_RANGE_M).run()


def _display(path: Path) -> str:
    """Name a file: its folder and name, led by `testing` for a test frame's."""
    name = path.parent.name if path.suffix == "" and path.parent.name in ("training", "testing") else ""
    shown = path.name if name else display_name(path)
    is_test = "testing" in (path.parent.name, path.parent.parent.name)
    return printable(f"testing/{shown}" if is_test else shown)


class _FrameLint:
    """The findings about one frame."""

    def __init__(self, folder: Path, frame_id: str, strict: bool, scan_range_m: tuple[float, float]) -> None:
        self.folder = folder
        self.scan_range_m = scan_range_m
        self.frame_id = frame_id
        self.strict = strict
        self.soft: Severity = "error" if strict else "warning"
        self.findings: list[Finding] = []

    def run(self) -> list[Finding]:
        """Check file by file; what cannot be read is one finding and is left out of the checks that need it."""
        try:
            frame = dataset.read_frame(self.folder, self.frame_id)
            texts = {kind: self._text(kind) for kind in ("calib", "label_2")}
        except (CadetError, OSError) as error:
            self._lint_readable_files()
            if not self.findings:
                self._add("image_2", None, f"the frame cannot be read: {error}")
            return self.findings
        # Numbers of a damaged file may overflow; comparing finds what comes of it, a warning would say it twice.
        with np.errstate(all="ignore"):
            self._lint_frame(frame, texts)
        return self.findings

    def _lint_frame(self, frame: Frame, texts: dict[str, str]) -> None:
        self._lint_calib(frame.calib)
        self._extend("calib", lint_calib_lines(texts["calib"]))
        if (self.folder / "label_2").is_dir():
            self._extend("label_2", lint_label_lines(texts["label_2"], frame.labels, self.soft))
        self._extend("label_2", lint_labels(frame.labels, frame.calib, frame.image_size, strict=self.strict))
        self._lint_points(frame.points_velo)
        self._extend("velodyne", lint_depths(frame.points_velo, frame.calib, self.soft))
        if frame.plane is not None:
            self._lint_plane(frame.plane)
        if frame.meta is not None:
            self._lint_meta(frame.meta, frame)

    def _text(self, kind: str) -> str:
        path = file_path(self.folder, kind, self.frame_id)
        return path.read_text(encoding="ascii") if path.is_file() else ""

    def _add(self, kind: str, line: int | None, message: str, severity: Severity = "error") -> None:
        self.findings.append(Finding(_display(file_path(self.folder, kind, self.frame_id)), line, message, severity))

    def _extend(self, kind: str, problems: Iterable[Problem]) -> None:
        for problem in problems:
            self._add(kind, *problem)

    def _lint_readable_files(self) -> None:
        for kind, error in dataset.check_files(self.folder, self.frame_id):
            if isinstance(error, MissingFileError):
                self._add(kind, None, "missing")
            elif isinstance(error, KittiFormatError):
                self._add(kind, error.line, error.reason)
            elif isinstance(error, OSError):
                self._add(kind, None, f"cannot be read: {error.strerror or error}")
            else:
                self._add(kind, None, str(error))

    def _lint_calib(self, calib: Calibration) -> None:
        for name, rotation in (
            ("R0_rect", calib.R0_rect),
            ("Tr_velo_to_cam", calib.Tr_velo_to_cam[:, :3]),
            ("Tr_imu_to_velo", calib.Tr_imu_to_velo[:, :3]),
        ):
            deviation = float(np.abs(rotation @ rotation.T - np.eye(3)).max())
            if not (deviation <= _UNIT_TOLERANCE and np.linalg.det(rotation) > 0.0):
                self._add("calib", None, f"{name}: no rotation (off by {deviation:.2g})")
        if min(calib.P2[0, 0], calib.P2[1, 1]) <= 0.0:
            self._add("calib", None, f"P2: focal lengths {calib.P2[0, 0]}, {calib.P2[1, 1]} are not positive")

    def _lint_plane(self, plane: NDArray[np.float64]) -> None:
        length = float(np.linalg.norm(plane[:3]))
        if not abs(length - 1.0) <= _UNIT_TOLERANCE:
            self._add("planes", 4, f"normal has length {length:.6f}, expected 1")
        if plane[1] >= 0.0:
            self._add("planes", 4, f"b = {plane[1]:.6f}, expected below 0: the normal must point up")
        low, high = _PLANE_HEIGHT_M
        if not low <= plane[3] <= high:
            self._add("planes", 4, f"d = {plane[3]:.3f} m, expected {low}..{high}", self.soft)

    def _lint_points(self, points_velo: NDArray[np.float32]) -> None:
        if not len(points_velo):
            self._add("velodyne", None, "no points", self.soft)
            return
        intensity = points_velo[:, 3]
        if intensity.min() < 0.0 or intensity.max() > 1.0:
            self._add("velodyne", None, f"intensity {intensity.min():.3f}..{intensity.max():.3f}, expected 0..1")
        range_m = np.linalg.norm(points_velo[:, :3].astype(np.float64), axis=1)
        low, high = self.scan_range_m if self.strict else (0.0, max(_LOOSE_RANGE_M, self.scan_range_m[1]))
        # Rounding x, y and z to millimeters moves a point by up to 0.9 mm.
        num_outside = int(((range_m < low - _MM) | (range_m > high + _MM)).sum())
        if num_outside:
            message = f"{num_outside} points with range outside {low}..{high} m (smallest {range_m.min():.3f}, "
            self._add("velodyne", None, f"{message}largest {range_m.max():.3f})", self.soft)

    def _lint_meta(self, meta: dict[str, Any], frame: Frame) -> None:
        self._lint_objects(meta, frame.labels)
        size = meta.get("image_size")
        if size is not None and not (isinstance(size, list) and all(map(is_number, size))):
            self._add("meta", None, "image_size: expected two numbers")
        elif size is not None and size != list(frame.image_size):
            self._add("image_2", None, f"image is {list(frame.image_size)} pixels, meta says {size}")

    def _lint_objects(self, meta: dict[str, Any], labels: tuple[Label, ...]) -> None:
        if "objects" not in meta:
            return
        objects = meta["objects"]
        if not (isinstance(objects, list) and all(isinstance(one, dict) for one in objects)):
            self._add("meta", None, "objects: expected a list of JSON objects")
        elif len(objects) != len(labels):
            self._add("meta", None, f"{len(objects)} objects, label_2 has {len(labels)} lines")
        else:
            self._compare_objects(objects, labels)

    def _compare_objects(self, objects: list[dict[str, Any]], labels: tuple[Label, ...]) -> None:
        """Compare type and place line by line; of a DontCare region the metadata knows what it really is."""
        for line, (one, label) in enumerate(zip(objects, labels, strict=True), start=1):
            if label.is_dont_care:
                continue
            kind, place = one.get("type", label.type), one.get("location_cam")
            if kind != label.type:
                shown = kind if isinstance(kind, str) and kind.isidentifier() else "no type"
                self._add("meta", None, f"object {line} is {shown}, label_2 says {label.type} on line {line}")
            elif place is not None and not _is_place(place, label.location_cam):
                message = f"object {line} lies elsewhere than line {line} of label_2: {label.location_cam}"
                self._add("meta", None, message)


def _is_place(place: object, location_cam: tuple[float, float, float]) -> bool:
    if not isinstance(place, list) or len(place) != _XYZ or not all(map(is_number, place)):
        return False
    return all(abs(x - at) <= ROUNDING for x, at in zip(place, location_cam, strict=True))
