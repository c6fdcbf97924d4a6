"""The lint of a generated dataset's manifest: what it says of the LIDAR, of the frames, and of every file's hash."""

from __future__ import annotations

import os
from collections import Counter
from collections.abc import Collection, Mapping
from dataclasses import dataclass, field
from hashlib import sha256
from pathlib import Path
from typing import Any

from cadet._util.plain_text import json_from_text
from cadet.errors import FileFormatError
from cadet.formats.kitti.files.folder import is_kind, suffix_of
from cadet.formats.kitti.files.other_layouts import MANIFEST
from cadet.formats.kitti.lint.finding import Finding
from cadet.formats.kitti.lint.lists import is_number, printable, unreadable


@dataclass(frozen=True)
class Manifest:
    """What a manifest says that the lint compares with; all of it None or empty where there is none.

    Attributes:
        range_m: least and greatest range of the LIDAR's returns.
        frame_hashes: SHA-256 of the files of each frame: by part ("training" or "testing") and id, then by folder.
        other_hashes: SHA-256 of other files by name.
        labels: how many labels of each type there are.
    """

    range_m: tuple[float, float] | None = None
    frame_hashes: Mapping[tuple[str, str], Mapping[str, str]] = field(default_factory=dict)
    other_hashes: Mapping[str, str] = field(default_factory=dict)
    labels: Mapping[str, int] | None = None


def read_manifest(root: Path) -> tuple[Manifest, list[Finding]]:
    """Read `root/manifest.json`, and say what is wrong with it."""
    path = root / MANIFEST
    if not os.path.lexists(path):
        return Manifest(), []
    try:
        content = json_from_text(path.read_bytes(), MANIFEST)
    except FileFormatError as error:
        return Manifest(), [_finding(error.reason, error.line)]
    except OSError as error:
        return Manifest(), [unreadable(MANIFEST, error)]
    if not isinstance(content, dict):
        return Manifest(), [_finding("expected a JSON object", 1)]
    findings: list[Finding] = []
    range_m = _read_range(content, findings)
    frame_hashes, other_hashes = _read_hashes(content, findings)
    labels = _read_labels(content, len(frame_hashes), findings)
    return Manifest(range_m, frame_hashes, other_hashes, labels), findings


def lint_other_files(root: Path, manifest: Manifest) -> list[Finding]:
    """Compare the files that are no frame's with their hashes."""
    findings = []
    for name, digest in manifest.other_hashes.items():
        try:
            is_same = sha256((root / name).read_bytes()).hexdigest() == digest
        except FileNotFoundError:
            findings.append(Finding(name, None, "missing-file", f"missing, but {MANIFEST} names it"))
        except OSError as error:
            findings.append(unreadable(name, error))
        else:
            if not is_same:
                findings.append(Finding(name, None, "wrong-hash", f"not the file that {MANIFEST} names"))
    return findings


def lint_frames(manifest: Manifest, ids: Mapping[str, Collection[str]]) -> list[Finding]:
    """Find frames that the manifest names and that are not there, and the reverse.

    Args:
        manifest: the manifest.
        ids: the frames that are there, by part.
    """
    if not manifest.frame_hashes:
        return []
    there = {(part, frame_id) for part, part_ids in ids.items() for frame_id in part_ids}
    lead = {"training": "", "testing": "testing/"}
    findings = []
    for part, frame_id in sorted(there ^ set(manifest.frame_hashes)):
        name = f"{lead[part]}image_2/{frame_id}.png"
        if (part, frame_id) in there:
            findings.append(Finding(name, None, "manifest", f"{MANIFEST} does not name this frame"))
        else:
            message = f"missing, as is all of a frame that {MANIFEST} names"
            findings.append(Finding(name, None, "missing-file", message))
    return findings


def lint_counts(manifest: Manifest, labels: Counter[str]) -> list[Finding]:
    """Compare the manifest's numbers of labels with those of the files."""
    if manifest.labels is None or dict(manifest.labels) == dict(labels):
        return []
    types = sorted({*manifest.labels, *labels})
    wrong = [name for name in types if manifest.labels.get(name, 0) != labels[name]]
    if not wrong:
        return []
    shown = ", ".join(f"{manifest.labels.get(name, 0)} {printable(name)} (found {labels[name]})" for name in wrong[:3])
    return [_finding(f"counts.labels: says {shown}")]


def _finding(message: str, line: int | None = None) -> Finding:
    return Finding(MANIFEST, line, "manifest", message)


def _read_range(content: dict[str, Any], findings: list[Finding]) -> tuple[float, float] | None:
    rig = content.get("rig")
    range_m = rig.get("range_m") if isinstance(rig, dict) else None
    if range_m is None:
        return None
    if not (isinstance(range_m, list) and len(range_m) == 2 and all(is_number(x) for x in range_m)):
        findings.append(_finding("rig.range_m: expected two numbers"))
        return None
    low, high = range_m
    if not 0.0 <= low < high:
        findings.append(_finding(f"rig.range_m: expected 0 <= low < high, got {low} and {high}"))
        return None
    return float(low), float(high)


def _read_hashes(
    content: dict[str, Any], findings: list[Finding]
) -> tuple[dict[tuple[str, str], dict[str, str]], dict[str, str]]:
    frames: dict[tuple[str, str], dict[str, str]] = {}
    others: dict[str, str] = {}
    hashes = content.get("sha256", {})
    if not (isinstance(hashes, dict) and all(isinstance(digest, str) for digest in hashes.values())):
        findings.append(_finding("sha256: expected text by name"))
        return {}, {}
    for name, digest in hashes.items():
        part, _, rest = name.partition("/")
        kind, _, file = rest.rpartition("/")
        if part in ("training", "testing") and is_kind(kind) and file.endswith(suffix_of(kind)):
            frames.setdefault((part, file.removesuffix(suffix_of(kind))), {})[kind] = digest
        elif part == "ImageSets" and rest and "/" not in rest and rest not in (".", ".."):
            others[name] = digest
        else:
            findings.append(_finding(f"sha256: {printable(name)} is not a file of a KITTI folder"))
    return frames, others


def _read_labels(content: dict[str, Any], num_frames: int, findings: list[Finding]) -> dict[str, int] | None:
    counts = content.get("counts")
    if counts is None:
        return None
    labels = counts.get("labels", {}) if isinstance(counts, dict) else None
    if not (isinstance(labels, dict) and all(is_number(number) for number in labels.values())):
        findings.append(_finding("counts: expected numbers by name"))
        return None
    said = counts.get("frames", num_frames)
    if num_frames and said != num_frames:
        findings.append(_finding(f"counts.frames: says {said}, sha256 names {num_frames}"))
    return labels
