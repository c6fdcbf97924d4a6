"""The lint of a whole folder: every frame, and what holds among frames."""

from __future__ import annotations

from collections import Counter
from collections.abc import Collection
from dataclasses import dataclass
from pathlib import Path
from typing import Final

from cadet._util.process_map import process_map
from cadet.errors import MissingFileError
from cadet.formats.kitti.files.folder import (
    REQUIRED,
    check_id,
    found_path,
    frame_ids,
    kinds_in,
    sample_folder,
    set_root,
    testing_folder,
)
from cadet.formats.kitti.files.other_layouts import MANIFEST, instead, no_frames
from cadet.formats.kitti.frame_files import FolderFiles
from cadet.formats.kitti.lint.duplicates import lint_duplicates
from cadet.formats.kitti.lint.finding import Finding, Problem
from cadet.formats.kitti.lint.frame import SCAN_RANGE_M, Report, Task, display, examine
from cadet.formats.kitti.lint.lists import lint_episodes, lint_folders, lint_lists, read_lists
from cadet.formats.kitti.lint.manifest import Manifest, lint_counts, lint_frames, lint_other_files, read_manifest

_BY_FRAME: Final = "label_2"
"""Its own reader says where it is missing."""


@dataclass(frozen=True)
class _Part:
    """`training` or `testing`."""

    name: str
    folder: Path
    ids: tuple[str, ...]


def lint(root: str | Path, *, strict: bool | None = None, workers: int = 1) -> list[Finding]:
    """Check every frame of a KITTI folder: files, formats, each field against its definition, and frames together.

    Whatever the files hold, and whether or not they can be read, the result is a list.

    Args:
        root: the folder that holds `training`, `testing` and `ImageSets`.
        strict: tight tolerances and no warnings; None decides by whether `root/manifest.json` shows the set to be
            generated.
        workers: processes that check frames; they change nothing in the result.

    Returns:
        What is wrong, in the order of manifest, lists, and frames, then what is there twice; empty if nothing is.

    Raises:
        MissingFileError: there is not a KITTI folder, or no frame in it.
        CadetError: `workers` is not a number of processes, or one of them died.
    """
    folder, testing, root = sample_folder(root), testing_folder(root), set_root(root)
    parts = [_Part("training", folder, frame_ids(folder))]
    parts += [] if testing is None else [_Part("testing", testing, frame_ids(testing))]
    if not any(part.ids for part in parts):
        raise MissingFileError(no_frames(root, folder, REQUIRED))
    is_generated = (root / MANIFEST).is_file()
    is_strict = is_generated if strict is None else strict
    manifest, findings = read_manifest(root)
    findings += lint_other_files(root, manifest)
    sets, list_findings = read_lists(root, "error" if is_strict else "warning")
    findings += list_findings
    train_ids, test_ids = set(parts[0].ids), set(parts[1].ids if testing is not None else ())
    findings += lint_lists(sets, root, train_ids, test_ids, strict=is_strict, generated=is_generated)
    findings += lint_frames(manifest, {part.name: part.ids for part in parts})
    tasks = [task for part in parts for task in _tasks(part, manifest, is_strict)]
    reports = list(process_map(examine, tasks, workers=workers))
    findings += lint_episodes(
        sets, {task.frame_id: r.episode for task, r in zip(tasks, reports, strict=True) if r.episode is not None}
    )
    start = 0
    for part in parts:
        findings += lint_folders(part.folder, set(part.ids), display)
        findings += _lint_absent(part)
        findings += [finding for report in reports[start : start + len(part.ids)] for finding in report.findings]
        start += len(part.ids)
    if not findings:
        findings += lint_counts(manifest, sum((report.types for report in reports), Counter()))
    return findings + _lint_duplicates(tasks, reports)


def lint_frame(root: str | Path, frame_id: str | int, *, strict: bool) -> list[Finding]:
    """Check one frame: see `lint`."""
    folder = sample_folder(root)
    manifest, _ = read_manifest(set_root(root))
    (task,) = _tasks(_Part("training", folder, (check_id(frame_id),)), manifest, strict)
    return examine(task).findings


def _tasks(part: _Part, manifest: Manifest, strict: bool) -> list[Task]:
    usual, absent = _usual_kinds(part.folder, part.ids), _absent_kinds(part)
    return [
        Task(
            part.folder,
            frame_id,
            strict,
            manifest.range_m or SCAN_RANGE_M,
            manifest.frame_hashes.get((part.name, frame_id), {}),
            usual,
            absent,
        )
        for frame_id in part.ids
    ]


def _absent_kinds(part: _Part) -> tuple[str, ...]:
    """Return the required folders in which none of several frames has a file."""
    has_several = len(part.ids) > 1
    kinds = [kind for kind in REQUIRED if has_several or not (part.folder / kind).is_dir()]
    files = FolderFiles(part.folder)
    return tuple(kind for kind in kinds if part.ids and not any(files.has(kind, one) for one in part.ids))


def _lint_absent(part: _Part) -> list[Finding]:
    """Say once which folders a whole part lacks, and what lies there under another name."""
    absent = {kind: Problem(None, "missing-file", _absence(part, kind)) for kind in _absent_kinds(part)}
    if part.name == "training" and part.ids and not (part.folder / _BY_FRAME).is_dir():
        absent[_BY_FRAME] = Problem(
            None, "missing-file", f"no labels at all{instead(part.folder, _BY_FRAME)}", "warning"
        )
    return [Finding(display(part.folder / kind), *problem) for kind, problem in absent.items()]


def _absence(part: _Part, kind: str) -> str:
    return f"none of {len(part.ids)} frames has a file there, and most commands need one{instead(part.folder, kind)}"


def _usual_kinds(folder: Path, ids: Collection[str]) -> tuple[str, ...]:
    """Return the optional folders in which more than half of the frames have a file."""
    kinds = [kind for kind in kinds_in(folder) if kind not in (*REQUIRED, _BY_FRAME) and (folder / kind).is_dir()]
    files = FolderFiles(folder)
    return tuple(kind for kind in kinds if 2 * sum(files.has(kind, one) for one in ids) > len(ids))


def _lint_duplicates(tasks: list[Task], reports: list[Report]) -> list[Finding]:
    there = [
        (task, report.signature) for task, report in zip(tasks, reports, strict=True) if report.signature is not None
    ]
    names = [task.frame_id for task, _ in there]
    return [
        Finding(display(found_path(there[index][0].folder, kind, there[index][0].frame_id)), *problem)
        for index, kind, problem in lint_duplicates([signature for _, signature in there], names)
    ]
