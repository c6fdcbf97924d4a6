"""The lint of nuScenes' format: nothing in what cadet-gen wrote, and each kind of damage by its place."""

from __future__ import annotations

import json
import shutil
from collections import Counter
from dataclasses import replace
from pathlib import Path

import pytest
from click.testing import CliRunner

import cadet
from cadet.cli.check import check_command
from cadet.formats.nuscenes import VERSION
from cadet.formats.nuscenes.lint import lint
from cadet.generate import Settings, generate


@pytest.fixture(scope="module")
def root(tmp_path_factory: pytest.TempPathFactory) -> Path:
    out = tmp_path_factory.mktemp("nuscenes") / "out"
    rig = replace(cadet.Rig.kitti(), camera=cadet.Camera.kitti().resized(310, 94))
    policy = cadet.ResetPolicy.kitti().with_rig(rig).as_sequence(hz=2, length_s=1.0)
    generate(out, Settings(seed=1, num_frames=4, policy=policy, format="nuscenes"), workers=1)
    return out


def change(root: Path, table: str, key: str, value: object) -> None:
    path = root / VERSION / f"{table}.json"
    rows = json.loads(path.read_text())
    rows[1][key] = value
    path.write_text(json.dumps(rows))


@pytest.mark.parametrize(
    ("table", "key", "value", "said"),
    [
        ("sample_annotation", "size", [1.8, 0.0, 1.5], "size: expected numbers above 0, got [1.8, 0.0, 1.5]"),
        ("sample_annotation", "translation", [1.8, 2.0], "translation: expected 3 numbers"),
        ("ego_pose", "rotation", [1.0, 0.1, 0.0, 0.0], "rotation: expected a quaternion of length 1, got [1.0, "),
        ("sample_annotation", "attribute_tokens", ["no"], "attribute_tokens: names no row of attribute"),
        ("instance", "first_annotation_token", None, "first_annotation_token: names no row of sample_annotation"),
        ("sample_data", "next", "no", "next: names no row of sample_data"),
    ],
)
def test_the_lint_names_rows_that_are_wrong(
    table: str, key: str, value: object, said: str, root: Path, tmp_path: Path
) -> None:
    shutil.copytree(root / VERSION, tmp_path / VERSION)
    (tmp_path / "samples").symlink_to(root / "samples")
    assert lint(tmp_path) == (4, [])
    change(tmp_path, table, key, value)
    (finding,) = lint(tmp_path)[1]
    assert finding.file == f"{VERSION}/{table}.json" and finding.message.startswith(f"row 1: {said}")


def test_the_lint_finds_damage_anywhere(root: Path, tmp_path: Path) -> None:
    out = tmp_path / "out"
    shutil.copytree(root, out)
    runner = CliRunner()
    assert runner.invoke(check_command, [str(out)]).output == "4 frames, 0 errors, 0 warnings\n"
    change(out, "sample", "prev", "")
    (out / "samples/image_2/000003.jpg").write_bytes(b"")
    (out / "samples/velodyne/000002.pcd.bin").unlink()
    (out / VERSION / "log.json").write_text("[")
    (out / VERSION / "map.json").write_text("[{}]")
    (out / VERSION / "sensor.json").unlink()
    done = runner.invoke(check_command, [str(out), "--json"])
    found = [(one["rule"], one["file"].rpartition("/")[2]) for one in json.loads(done.output)["findings"]]
    assert Counter(found) == {
        ("missing-file", "000002.pcd.bin"): 1,
        ("wrong-hash", "000003.jpg"): 1,
        **{("wrong-hash", f"{name}.json"): 1 for name in ("sample", "log", "map")},
        ("damaged-file", "log.json"): 1,
        ("table-row", "map.json"): 1,
        ("missing-file", "sensor.json"): 2,
        ("table-row", "sample.json"): 1,
    }
    (out / "manifest.json").unlink()
    missing = [one.file for one in lint(out)[1] if one.rule == "missing-file"]
    assert missing == [f"{VERSION}/sensor.json", "samples/velodyne/000002.pcd.bin"]
