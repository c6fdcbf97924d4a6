"""Check a KITTI folder against the definitions of its fields.

KITTI's own labels were drawn by people and only roughly obey them; ours must obey them to the rounding of two decimals.
The lint therefore knows two measures. Loosely, a breach of the geometry is a warning, and these tolerances hold for
nearly all of KITTI's labels: overlap of `bbox` with the projected box 0.6 (KITTI's median is 0.97, 2 % lie below 0.6),
truncation 0.05 (its largest deviation but one is 0.03), alpha 0.1 rad (its largest is 0.08). Strictly, it is an error,
and the tolerance is what rounding every field to 0.01 can do to the projection of that very box.
"""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path
from typing import Final, Literal

import numpy as np
from numpy.typing import NDArray

from cadet import boxes
from cadet.errors import CadetError, KittiFormatError, MissingFileError
from cadet.kitti import dataset
from cadet.kitti.calib import Calibration
from cadet.kitti.files import REQUIRED, SUFFIXES, check_id, display_name, file_path, frame_ids, sample_folder
from cadet.kitti.image_sets import ImageSet
from cadet.kitti.label import Label
from cadet.plain_text import json_from_text

Severity = Literal["error", "warning"]

_LOOSE_IOU: Final = 0.6
_LOOSE_TRUNCATION: Final = 0.05
_LOOSE_ALPHA_RAD: Final = 0.1
_ROUNDING: Final = 0.0051
_MAX_ROTATION_RAD: Final = 3.145
_UNKNOWN_OCCLUSION: Final = 3
_UNIT_TOLERANCE: Final = 1e-3
_PLANE_HEIGHT_M: Final = (1.0, 2.5)
_MANIFEST: Final = "manifest.json"
_SCAN_RANGE_M: Final = (1.45, 80.0)
_LOOSE_RANGE_M: Final = 120.0
_MM: Final = 0.001
_DONT_CARE: Final = Label("DontCare", -1, -1, -10, (0, 0, 0, 0), (-1, -1, -1), (-1000, -1000, -1000), -10)


@dataclass(frozen=True)
class Finding:
    """One thing that is wrong with a dataset.

    Attributes:
        file: the file, relative to the folder that holds `calib`, or `ImageSets/<split>.txt`.
        line: the line from 1; None where the file as a whole is meant.
        message: what is wrong, with the value and what was expected.
        severity: "error", or "warning" for what human-made labels get away with.
    """

    file: str
    line: int | None
    message: str
    severity: Severity = "error"

    def __str__(self) -> str:
        where = self.file if self.line is None else f"{self.file}:{self.line}"
        return f"{where}: {self.severity}: {self.message}"


def lint(root: str | Path, *, strict: bool | None = None) -> list[Finding]:
    """Check every frame of a KITTI folder: files, formats, and each field against its definition.

    Args:
        root: the folder that holds `training` and `ImageSets`.
        strict: tight tolerances and no warnings; None decides by whether `root/manifest.json` shows the set to be
            generated.

    Returns:
        What is wrong, in the order of lists, then frames; empty if nothing is.

    Raises:
        MissingFileError: there is no KITTI folder.
    """
    folder = sample_folder(root)
    is_strict = (Path(root) / _MANIFEST).is_file() if strict is None else strict
    scan_range_m = _scan_range_m(Path(root))
    ids = frame_ids(folder)
    findings = _lint_image_sets(Path(root), ids, "error" if is_strict else "warning")
    findings += _lint_partners(folder, ids)
    for frame_id in ids:
        findings += _FrameLint(folder, check_id(frame_id), is_strict, scan_range_m).run()
    return findings


def lint_frame(root: str | Path, frame_id: str | int, *, strict: bool) -> list[Finding]:
    """Check one frame: see `lint`."""
    folder = sample_folder(root)
    return _FrameLint(folder, check_id(frame_id), strict, _scan_range_m(Path(root))).run()


def _scan_range_m(root: Path) -> tuple[float, float]:
    """Return the ranges of a generated dataset's LIDAR; KITTI's where there is no manifest that says."""
    try:
        low, high = json_from_text((root / _MANIFEST).read_bytes(), _MANIFEST)["rig"]["range_m"]
        return float(low), float(high)
    except (OSError, ValueError, KeyError, TypeError):
        return _SCAN_RANGE_M


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
        except CadetError:
            self._lint_readable_files()
            return self.findings
        self._lint_calib(frame.calib)
        self._lint_labels(frame.labels, frame.calib, frame.image_size)
        self._lint_points(frame.points_velo)
        if frame.plane is not None:
            self._lint_plane(frame.plane)
        objects = (frame.meta or {}).get("objects")
        if isinstance(objects, list) and len(objects) != len(frame.labels):
            self._add("meta", None, f"{len(objects)} objects, label_2 has {len(frame.labels)} lines")
        wanted = (frame.meta or {}).get("image_size")
        if wanted is not None and list(wanted) != list(frame.image_size):
            self._add("image_2", None, f"image is {list(frame.image_size)} pixels, meta says {wanted}")
        return self.findings

    def _add(self, kind: str, line: int | None, message: str, severity: Severity = "error") -> None:
        name = display_name(file_path(self.folder, kind, self.frame_id))
        self.findings.append(Finding(name, line, message, severity))

    def _lint_readable_files(self) -> None:
        for kind, error in dataset.check_files(self.folder, self.frame_id):
            if isinstance(error, MissingFileError):
                self._add(kind, None, "missing")
            elif isinstance(error, KittiFormatError):
                self._add(kind, error.line, error.reason)
            else:
                self._add(kind, None, str(error))

    def _lint_calib(self, calib: Calibration) -> None:
        for name, rotation in (
            ("R0_rect", calib.R0_rect),
            ("Tr_velo_to_cam", calib.Tr_velo_to_cam[:, :3]),
            ("Tr_imu_to_velo", calib.Tr_imu_to_velo[:, :3]),
        ):
            deviation = float(np.abs(rotation @ rotation.T - np.eye(3)).max())
            if deviation > _UNIT_TOLERANCE or np.linalg.det(rotation) < 0.0:
                self._add("calib", None, f"{name}: no rotation (off by {deviation:.2g})")
        if min(calib.P2[0, 0], calib.P2[1, 1]) <= 0.0:
            self._add("calib", None, f"P2: focal lengths {calib.P2[0, 0]}, {calib.P2[1, 1]} are not positive")

    def _lint_plane(self, plane: NDArray[np.float64]) -> None:
        length = float(np.linalg.norm(plane[:3]))
        if abs(length - 1.0) > _UNIT_TOLERANCE:
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
        # Rounding x, y and z to millimetres moves a point by up to 0.9 mm.
        num_outside = int(((range_m < low - _MM) | (range_m > high + _MM)).sum())
        if num_outside:
            message = f"{num_outside} points with range outside {low}..{high} m (smallest {range_m.min():.3f}, "
            self._add("velodyne", None, f"{message}largest {range_m.max():.3f})", self.soft)

    def _lint_labels(self, labels: tuple[Label, ...], calib: Calibration, image_size: tuple[int, int]) -> None:
        for line, label in enumerate(labels, start=1):
            if label.score is not None:
                self._add("label_2", line, "expected 15 fields, got 16: a label has no score")
            self._lint_bbox(line, label, image_size)
            if label.is_dont_care:
                self._lint_dont_care(line, label)
            elif self._lint_fields(line, label):
                self._lint_geometry(line, label, calib, image_size)

    def _lint_bbox(self, line: int, label: Label, image_size: tuple[int, int]) -> None:
        left, top, right, bottom = label.bbox
        if left >= right or top >= bottom:
            self._add("label_2", line, f"bbox {label.bbox} is empty", self.soft)
        elif min(left, top) < 0.0 or right > image_size[0] - 1 or bottom > image_size[1] - 1:
            limit = f"[0, {image_size[0] - 1}] x [0, {image_size[1] - 1}]"
            self._add("label_2", line, f"bbox {label.bbox} leaves {limit}", self.soft)

    def _lint_dont_care(self, line: int, label: Label) -> None:
        for name in ("truncated", "occluded", "alpha", "dimensions_hwl", "location_cam", "rotation_y"):
            value, wanted = getattr(label, name), getattr(_DONT_CARE, name)
            if value != wanted:
                self._add("label_2", line, f"DontCare: {name} is {value}, expected {wanted}")

    def _lint_fields(self, line: int, label: Label) -> bool:
        """Check ranges; tell whether the box makes sense, so that its geometry can be checked."""
        if not 0.0 <= label.truncated <= 1.0:
            self._add("label_2", line, f"truncated {label.truncated}, expected 0..1")
        if label.occluded < 0:
            self._add("label_2", line, f"occluded {label.occluded}, expected 0..3")
        elif self.strict and label.occluded == _UNKNOWN_OCCLUSION:
            self._add("label_2", line, "occluded 3 (unknown), expected 0..2")
        height, width, length = label.dimensions_hwl
        if min(label.dimensions_hwl) <= 0.0:
            self._add("label_2", line, f"dimensions h w l {label.dimensions_hwl} are not positive")
        elif label.type == "Car" and length <= width:
            self._add("label_2", line, f"a car {length} m long and {width} m wide: expected h w l, got {height} first")
        for name in ("alpha", "rotation_y"):
            angle = getattr(label, name)
            if abs(angle) > _MAX_ROTATION_RAD:
                self._add("label_2", line, f"{name} {angle}, expected -pi..pi")
                return False
        return min(label.dimensions_hwl) > 0.0

    def _lint_geometry(self, line: int, label: Label, calib: Calibration, image_size: tuple[int, int]) -> None:
        box_cam = label.box_cam[None]
        whole = boxes.project_boxes(box_cam, calib)
        if np.isnan(whole).any():
            self._add("label_2", line, f"the box at {label.location_cam} lies behind the camera", self.soft)
            return
        expected = boxes.clip_boxes_img(whole, image_size)[0]
        rounding_px = _rounding_px(label, calib)
        deviation_px = float(np.abs(expected - label.bbox).max())
        iou = float(boxes.iou_img(expected[None], np.array([label.bbox], np.float64))[0])
        if (deviation_px > rounding_px) if self.strict else (iou < _LOOSE_IOU):
            projected = ", ".join(f"{x:.2f}" for x in expected)
            message = (
                f"bbox {label.bbox} is off the projected box ({projected}) by {deviation_px:.2f} px, IoU {iou:.2f}"
            )
            self._add("label_2", line, message, self.soft)

        truncated = float(boxes.truncation(box_cam, calib, image_size)[0])
        width_px, height_px = float(whole[0, 2] - whole[0, 0]), float(whole[0, 3] - whole[0, 1])
        border_px = float(min(*whole[0, :2], image_size[0] - 1 - whole[0, 2], image_size[1] - 1 - whole[0, 3]))
        is_whole = border_px > rounding_px
        rounding = _ROUNDING + (0.0 if is_whole else 2.0 * rounding_px * (1.0 / width_px + 1.0 / height_px))
        if abs(truncated - label.truncated) > (rounding if self.strict else _LOOSE_TRUNCATION):
            self._add("label_2", line, f"truncated {label.truncated}, expected {truncated:.2f}", self.soft)

        alpha = float(boxes.alpha_from_boxes(box_cam)[0])
        x, _, z = label.location_cam
        rounding = 2.0 * _ROUNDING + 1.5 * _ROUNDING / max(float(np.hypot(x, z)), boxes.NEAR_M)
        if abs(float(boxes.wrap_angle(alpha - label.alpha))) > (rounding if self.strict else _LOOSE_ALPHA_RAD):
            message = f"alpha {label.alpha}, expected rotation_y - atan2(x, z) = {alpha:.2f}"
            self._add("label_2", line, message, self.soft)


def _rounding_px(label: Label, calib: Calibration) -> float:
    """Bound how far rounding every field of a label to 0.01 moves its projected box, in pixels."""
    _, width, length = label.dimensions_hwl
    turned = 0.5 * float(np.hypot(length, width))
    moved_m = _ROUNDING * (float(np.sqrt(3.0)) + float(np.sqrt(1.5)) + turned)
    corners = boxes.corners_cam(label.box_cam[None])[0]
    near = np.maximum(corners[:, 2] - moved_m, boxes.NEAR_M)
    slope = np.linalg.norm(corners[:, :2], axis=1) / near
    focal = float(max(calib.P2[0, 0], calib.P2[1, 1]))
    return float((focal * moved_m / near * np.sqrt(1.0 + slope**2)).max()) + _ROUNDING


def _lint_partners(folder: Path, ids: tuple[str, ...]) -> list[Finding]:
    """Find files that belong to no frame."""
    known = set(ids)
    findings = []
    for kind in SUFFIXES:
        if kind in REQUIRED or not (folder / kind).is_dir():
            continue
        for path in sorted((folder / kind).iterdir()):
            if path.stem not in known or path.suffix != SUFFIXES[kind]:
                findings.append(Finding(display_name(path), None, "belongs to no frame", "warning"))
    return findings


def _lint_image_sets(root: Path, ids: tuple[str, ...], soft: Severity) -> list[Finding]:
    """Check that the lists name frames that are there and that no frame is in train and val."""
    findings: list[Finding] = []
    sets: dict[str, ImageSet] = {}
    for path in sorted((root / "ImageSets").glob("*.txt")):
        name = display_name(path)
        try:
            sets[path.stem] = ImageSet.from_text(path.read_text(encoding="ascii", errors="replace"), name)
        except KittiFormatError as error:
            findings.append(Finding(name, error.line, error.reason))
    present = set(ids)
    for split, image_set in sets.items():
        # The list "test" names frames of `testing`, which have no labels.
        absent = [] if split == "test" else [frame_id for frame_id in image_set if frame_id not in present]
        if absent:
            message = f"{len(absent)} of {len(image_set)} ids have no frame, the first is {absent[0]}"
            line = image_set.ids.index(absent[0]) + 1
            findings.append(Finding(f"ImageSets/{split}.txt", line, message, soft))
    if "train" in sets and "val" in sets:
        train = set(sets["train"])
        for line, frame_id in enumerate(sets["val"], start=1):
            if frame_id in train:
                findings.append(Finding("ImageSets/val.txt", line, f"{frame_id} is in train, too"))
        if "trainval" in sets and set(sets["trainval"]) != train | set(sets["val"]):
            findings.append(Finding("ImageSets/trainval.txt", None, "is not train and val together", soft))
    return findings
