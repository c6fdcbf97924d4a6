"""The lint of a nuScenes folder, whoever wrote it: tables, links between their rows, poses and boxes, and files."""

from __future__ import annotations

import math
import os
import re
from collections.abc import Iterator, Mapping
from pathlib import Path
from typing import Any, Final

from cadet._util.plain_text import json_from_text
from cadet._util.user_files import read_file
from cadet.errors import FileFormatError, MissingFileError
from cadet.formats.kitti.files.other_layouts import MANIFEST
from cadet.formats.kitti.lint.finding import Finding
from cadet.formats.kitti.lint.lists import is_number, printable, unreadable
from cadet.formats.kitti.lint.manifest import Manifest, lint_other_files

_TABLES: Final = (
    *("attribute", "calibrated_sensor", "category", "ego_pose", "instance", "log", "map", "sample"),
    *("sample_annotation", "sample_data", "scene", "sensor", "visibility"),
)
_LIDARSEG: Final = "lidarseg"
"""A table that a folder may have."""
_POINT_BYTES: Final = 20
_LINK: Final = re.compile(r"(?:first_|last_)?(\w+)_tokens?")
_NUMBERS: Final = {"translation": 3, "rotation": 4, "size": 3}
_UNIT_TOLERANCE: Final = 1e-3

Rows = Mapping[str, Mapping[str, Any]]
"""By token."""


def table_folders(root: Path) -> list[Path]:
    """List the folders of tables of a nuScenes folder, such as `v1.0-trainval`; none of another folder."""
    return sorted(path.parent for path in root.glob("v1.0-*/sample_data.json"))


def lint(root: Path) -> tuple[int, list[Finding]]:
    """Check a nuScenes folder; every file by its hash where `root/manifest.json` has one.

    Returns:
        How many samples there are, and what is wrong.
    """
    findings: list[Finding] = []
    manifest = _json(root, MANIFEST, findings) if os.path.lexists(root / MANIFEST) else {}
    hashes = manifest.get("sha256") if isinstance(manifest, dict) else None
    named = {name: digest for name, digest in (hashes if isinstance(hashes, dict) else {}).items() if _is_inside(name)}
    findings += lint_other_files(root, Manifest(other_hashes=named))
    num_samples = 0
    for folder in table_folders(root):
        names = (*_TABLES, *([_LIDARSEG] if os.path.lexists(folder / f"{_LIDARSEG}.json") else []))
        tables = {name: _table(root, f"{folder.name}/{name}.json", findings) for name in names}
        for name, rows in tables.items():
            for number, row in enumerate(rows.values()):
                for problem in (*_broken_links(name, row, tables), *_bad_numbers(row)):
                    message = f"row {number}: {problem}"
                    findings.append(Finding(f"{folder.name}/{name}.json", None, "table-row", message))
        for name in ("sample_data", _LIDARSEG):
            for file in (str(row.get("filename")) for row in tables.get(name, {}).values()):
                if file not in named and not (_is_inside(file) and (root / file).is_file()):
                    findings.append(Finding(printable(file), None, "missing-file", f"missing, but {name} names it"))
        findings += _wrong_sizes(root, tables)
        num_samples += len(tables["sample"])
    return num_samples, findings


def _json(root: Path, file: str, findings: list[Finding]) -> Any:
    try:
        return json_from_text(read_file(root / file, name=file), file)
    except MissingFileError:
        findings.append(Finding(file, None, "missing-file", "missing"))
    except FileFormatError as error:
        findings.append(Finding(file, error.line, "damaged-file", error.reason))
    except OSError as error:
        findings.append(unreadable(file, error))
    return None


def _table(root: Path, file: str, findings: list[Finding]) -> Rows:
    content = _json(root, file, findings)
    if content is None:
        return {}
    if not isinstance(content, list):
        content = [content]
    rows = {row["token"]: row for row in content if isinstance(row, dict) and isinstance(row.get("token"), str)}
    if len(rows) < len(content):
        message = f"{len(content) - len(rows)} of {len(content)} rows have no token of their own"
        findings.append(Finding(file, None, "table-row", message))
    return rows


def _broken_links(name: str, row: Mapping[str, Any], tables: Mapping[str, Rows]) -> Iterator[str]:
    for key, value in row.items():
        link = _LINK.fullmatch(key)
        target = name if key in ("prev", "next") else link[1].replace("annotation", "sample_annotation") if link else ""
        # What links to a table that is missing or empty is said once, of the table.
        if not tables.get(target) or (value == "" and target == name):
            continue
        for one in value if isinstance(value, list) else [value]:
            if not isinstance(one, str) or one not in tables[target]:
                yield f"{key}: names no row of {target}"
            elif key == "next" and tables[target][one].get("prev") != row["token"]:
                yield "next: names a row whose prev is another"


def _bad_numbers(row: Mapping[str, Any]) -> Iterator[str]:
    for key in (key for key in _NUMBERS if key in row):
        value, count = row[key], _NUMBERS[key]
        if not (isinstance(value, list) and len(value) == count and all(map(is_number, value))):
            yield f"{key}: expected {count} numbers"
        elif key == "size" and min(value) <= 0.0:
            yield f"size: expected numbers above 0, got {value}"
        elif key == "rotation" and abs(math.hypot(*value) - 1.0) > _UNIT_TOLERANCE:
            yield f"rotation: expected a quaternion of length 1, got {value}"


def _wrong_sizes(root: Path, tables: Mapping[str, Rows]) -> Iterator[Finding]:
    """Find files of points' classes that do not have one for each point of their scan."""
    for row in tables.get(_LIDARSEG, {}).values():
        file = str(row.get("filename"))
        scan = str(tables["sample_data"].get(str(row.get("sample_data_token")), {}).get("filename"))
        if all(_is_inside(name) and (root / name).is_file() for name in (file, scan)):
            number, points = (root / file).stat().st_size, (root / scan).stat().st_size // _POINT_BYTES
            if number != points:
                message = f"holds {number} points, {scan} has {points}"
                yield Finding(printable(file), None, "damaged-file", message)


def _is_inside(file: str) -> bool:
    return file.isprintable() and not file.startswith("/") and ".." not in file.split("/")
