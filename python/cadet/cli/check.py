"""`cadet check`: what is wrong with a dataset."""

from __future__ import annotations

import json
import re
from collections import Counter
from collections.abc import Sequence
from itertools import chain
from pathlib import Path
from typing import Final

import click

from cadet._util.operating_system import num_processors
from cadet._util.text_tables import aligned
from cadet.formats.kitti.files.folder import frame_ids, sample_folder, testing_folder
from cadet.formats.kitti.lint import Finding, lint
from cadet.formats.nuscenes import lint as nuscenes

_ROWS_SHOWN: Final = 50
_ALIKE_SHOWN: Final = 3
"""Findings of one kind that are printed one by one; of more there is one row with their number."""
_VALUE: Final = re.compile(r"[-+]?\d[-+.\de]*|\binf\b|\bnan\b")


@click.command(name="check")
@click.argument("root", type=click.Path(path_type=Path))
@click.option("--strict/--loose", default=None, help="Tolerances.  [default: strict for what cadet-gen wrote]")
@click.option("--workers", type=click.IntRange(1, 1024), help="Worker processes.  [default: one per processor]")
@click.option("--all", "is_all", is_flag=True, help="Print every finding, not one line per kind.")
@click.option("--json", "is_json", is_flag=True, help="Print all findings and counts as a JSON object.")
def check_command(root: Path, strict: bool | None, workers: int | None, is_all: bool, is_json: bool) -> int:
    """Check that a dataset is complete, follows KITTI's definitions, and is consistent; exit 1 on any error.

    Of nuScenes' format it checks tables, links between their rows, boxes, and files, without tolerances.

    \b
    cadet check out
    cadet check kitti --json > findings.json
    """  # noqa: D301 - click reads the backspace
    if nuscenes.table_folders(root):
        num_frames, findings = nuscenes.lint(root)
    else:
        findings = lint(root, strict=strict, workers=workers or num_processors())
        testing = testing_folder(root)
        num_frames = len(frame_ids(sample_folder(root))) + (0 if testing is None else len(frame_ids(testing)))
    errors = Counter(finding.rule for finding in findings if finding.severity == "error")
    warnings = Counter(finding.rule for finding in findings if finding.severity == "warning")
    if is_json:
        click.echo(_json(root, num_frames, findings, errors, warnings))
    else:
        _echo_findings(findings, is_all=is_all)
        _echo_counts(errors, warnings)
        click.echo(f"{num_frames} frames, {errors.total()} errors, {warnings.total()} warnings")
    return 1 if errors else 0


def _echo_findings(findings: Sequence[Finding], *, is_all: bool) -> None:
    if not findings:
        return
    groups = [[one] for one in findings] if is_all else _alike(findings)
    rows = [_row(group) for group in groups]
    shown = rows if is_all else rows[:_ROWS_SHOWN]
    click.echo("\n".join(aligned([("FRAME", "PLACE", "SEVERITY", "RULE", "WHAT"), *shown], num_left=5)))
    if len(shown) < len(rows):
        click.echo(f"... and {len(rows) - len(shown)} more rows: --all prints every finding")
    elif len(rows) < len(findings):
        click.echo("--all prints every finding")
    click.echo()


def _alike(findings: Sequence[Finding]) -> list[list[Finding]]:
    """Gather findings whose rule, folder and message are the same but for numbers, where there are many of them."""
    groups: dict[tuple[str, ...], list[Finding]] = {}
    for one in findings:
        message = one.message if one.frame_id is None else one.message.replace(one.frame_id, "0")
        key = (one.severity, one.rule, one.file.rpartition("/")[0], _VALUE.sub("0", message))
        groups.setdefault(key, []).append(one)
    rows = ([[one] for one in group] if len(group) <= _ALIKE_SHOWN else [group] for group in groups.values())
    return list(chain.from_iterable(rows))


def _row(group: Sequence[Finding]) -> tuple[str, ...]:
    first = group[0]
    message = first.message
    if len(group) > 1:
        others = ", ".join(one.place for one in group[1:_ALIKE_SHOWN])
        message += f" ({len(group)} times: also {others}, ...)"
    return first.frame_id or "-", first.place, first.severity, first.rule, message


def _echo_counts(errors: Counter[str], warnings: Counter[str]) -> None:
    rules = sorted({*errors, *warnings}, key=lambda rule: (-errors[rule], -warnings[rule], rule))
    if rules:
        rows = [(f"{errors[rule]:>6}", f"{warnings[rule]:>8}", rule) for rule in rules]
        click.echo("\n".join(aligned([("ERRORS", "WARNINGS", "RULE"), *rows], num_left=3)))


def _json(
    root: Path, num_frames: int, findings: Sequence[Finding], errors: Counter[str], warnings: Counter[str]
) -> str:
    content = {
        "root": str(root),
        "frames": num_frames,
        "errors": errors.total(),
        "warnings": warnings.total(),
        "rules": {rule: {"errors": errors[rule], "warnings": warnings[rule]} for rule in sorted({*errors, *warnings})},
        "findings": [
            {
                "frame": one.frame_id,
                "file": one.file,
                "line": one.line,
                "rule": one.rule,
                "severity": one.severity,
                "message": one.message,
            }
            for one in findings
        ],
    }
    return json.dumps(content, indent=1)
