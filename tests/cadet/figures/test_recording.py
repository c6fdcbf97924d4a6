"""Episodes as Rerun recordings, read back by Rerun's own reader."""

from __future__ import annotations

import subprocess
import sys
from collections import defaultdict
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from numpy.typing import NDArray

import cadet
from cadet import kitti
from cadet.cli import run_cadet
from cadet.generate import Settings, generate
from synthetic import make_frame

SAMPLES = 5


@pytest.fixture(scope="module")
def root(tmp_path_factory: pytest.TempPathFactory) -> Path:
    out = tmp_path_factory.mktemp("recording") / "out"
    rig = cadet.Rig(camera=cadet.Camera.kitti().resized(310, 94), lidar=cadet.Lidar.vlp16())
    policy = cadet.ResetPolicy.kitti().with_rig(rig).as_sequence(hz=10, length_s=SAMPLES / 10)
    generate(out, Settings(seed=2, num_frames=2 * SAMPLES, policy=policy), workers=1)
    return out


def run(monkeypatch: pytest.MonkeyPatch, *arguments: str) -> int:
    monkeypatch.setattr("sys.argv", ["cadet", "view", *arguments])
    with pytest.raises(SystemExit) as ended:
        run_cadet()
    return int(ended.value.code or 0)


def rows_of(path: Path) -> dict[str, dict[str, dict[int, Any]]]:
    """Return a recording's components by entity, name, and frame."""
    from rerun.chunk import RrdReader

    found: dict[str, dict[str, dict[int, Any]]] = defaultdict(lambda: defaultdict(dict))
    for chunk in RrdReader(path).stream():
        batch = chunk.to_record_batch()
        if "frame" in batch.schema.names:
            frames = batch.column("frame").to_pylist()
            for name in batch.schema.names:
                for frame, value in zip(frames, batch.column(name).to_pylist(), strict=True):
                    if value is not None:
                        found[chunk.entity_path][name][frame] = value
    return found


def array(rows: dict[str, dict[int, Any]], ending: str, frame: int) -> NDArray[np.float64]:
    (name,) = [name for name in rows if name.endswith(f":{ending}")]
    return np.array(rows[name][frame], np.float64)


def test_an_episode_holds_scan_image_boxes_and_tracks_over_time(
    root: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    pytest.importorskip("rerun", reason="needs rerun-sdk, the extra view")
    out = tmp_path / "episode.rrd"
    assert run(monkeypatch, f"{root}/000007", "--rerun", "-o", str(out)) == 0
    assert [path.name for path in tmp_path.iterdir()] == ["episode.rrd"]
    rows = rows_of(out)
    frames = [kitti.read_frame(root, number) for number in range(SAMPLES, 2 * SAMPLES)]
    tracks: dict[int, list[NDArray[np.float64]]] = defaultdict(list)
    for number, frame in enumerate(frames):
        assert frame.meta is not None
        world_from_velo = np.array(frame.meta["world_from_ego"]) @ np.array(frame.meta["ego_from_velo"])
        points = array(rows["/world/ego/velo/points"], "positions", number)
        np.testing.assert_allclose(points, frame.points_velo[:, :3], atol=1e-6)
        time_s = rows["/world/ego/velo/points"]["time"][number].total_seconds()
        assert time_s == pytest.approx(frame.meta["time_s"], abs=1e-6)
        moved = array(rows["/world/ego"], "translation", number).ravel()
        np.testing.assert_allclose(moved, np.array(frame.meta["world_from_ego"])[:3, 3], atol=1e-4)
        labels = [label for label in frame.labels if not label.is_dont_care]
        half_sizes = array(rows["/world/ego/velo/boxes"], "half_sizes", number).reshape(-1, 3)
        # Points of an object lie in its box as Rerun turns it: x, y, z of the box by its quaternion.
        centers = array(rows["/world/ego/velo/boxes"], "centers", number).reshape(-1, 3)
        turns = array(rows["/world/ego/velo/boxes"], "quaternions", number).reshape(-1, 4)
        objects = [
            seen for seen, label in zip(frame.meta["objects"], frame.labels, strict=True) if not label.is_dont_care
        ]
        assert len(labels) == len(centers) == len(objects)
        for label, seen, center, half, turn in zip(labels, objects, centers, half_sizes, turns, strict=True):
            height, width, length = label.dimensions_hwl
            np.testing.assert_allclose(2 * half, [length, width, height], atol=1e-5)
            yaw = 2 * np.arctan2(turn[2], turn[3])
            across = (frame.points_velo[:, :3] - center) @ np.array(
                [[np.cos(yaw), -np.sin(yaw), 0], [np.sin(yaw), np.cos(yaw), 0], [0, 0, 1]]
            )
            inside = (np.abs(across) <= half + 0.15).all(axis=1).sum()
            assert inside >= 0.8 * seen["num_points"]
            tracks[seen["actor_id"]].append((world_from_velo @ [*center, 1.0])[:3])
        image = rows["/world/ego/velo/camera/image"]
        assert any(number in values for name, values in image.items() if "blob" in name)
        assert len(array(rows["/world/ego/velo/camera/boxes"], "half_sizes", number)) == len(frame.labels)
    names = {name.removeprefix("/world/tracks/") for name in rows if name.startswith("/world/tracks/")}
    assert names == {str(actor) for actor in tracks} and len(names) > 0
    for actor, way in tracks.items():
        strips = next(values for name, values in rows[f"/world/tracks/{actor}"].items() if name.endswith(":strips"))
        (last,) = strips[max(strips)]
        expected = way if len(way) > 1 else way * 2
        np.testing.assert_allclose(np.array(last, np.float64), expected, atol=1e-3)
    (path,) = [values for name, values in rows["/world/path"].items() if name.endswith(":strips")]
    assert len(path[SAMPLES - 1][0]) == SAMPLES


def test_frames_without_meta_are_episodes_of_their_own(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    pytest.importorskip("rerun", reason="needs rerun-sdk, the extra view")
    for number in range(2):
        kitti.write_frame(tmp_path / "set", number, make_frame())
    for path in (tmp_path / "set" / "training" / "meta").glob("*"):
        path.unlink()
    monkeypatch.chdir(tmp_path)
    assert run(monkeypatch, "set", "--rerun") == 0
    rows = rows_of(tmp_path / "set.rrd")
    assert list(rows["/world/ego/velo/points"]["frame"]) == [0] and "time" not in rows["/world/ego/velo/points"]
    assert not any(name.startswith("/world/tracks/") for name in rows)


def test_what_cannot_be_recorded_is_one_clear_line(
    root: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    pytest.importorskip("rerun", reason="needs rerun-sdk, the extra view")
    for arguments, message in (
        ([str(root), "--rerun", "-o", str(tmp_path / "a.png")], "expected a name that ends in .rrd"),
        ([str(root), "--rerun", "-o", str(tmp_path / "none" / "a.rrd")], "no such folder"),
        ([f"{root}/000099", "--rerun"], "no frame 000099"),
        ([str(root), "--rerun", "--bev"], "leave out --bev"),
    ):
        assert run(monkeypatch, *arguments) == 2
        error = capsys.readouterr().err
        assert message in error and error.count("\n") == 1
    damaged = tmp_path / "damaged"
    kitti.write_frame(damaged, 0, make_frame())
    (damaged / "training" / "velodyne" / "000000.bin").write_bytes(b"123")
    assert run(monkeypatch, str(damaged), "--rerun", "-o", str(tmp_path / "a.rrd")) == 2
    assert list(tmp_path.glob("*.rrd*")) == [] and list(tmp_path.glob(".*")) == [], "nothing is left of it"


def test_without_rerun_the_command_says_what_it_needs(root: Path) -> None:
    code = "import sys; sys.modules['rerun'] = None; from cadet.cli import run_cadet; run_cadet()"
    arguments = [sys.executable, "-c", code, "view", str(root), "--rerun"]
    done = subprocess.run(arguments, capture_output=True, text=True, check=False, timeout=60)
    assert done.returncode == 2
    assert done.stderr == "cadet: cadet view --rerun needs rerun: pip install 'cadet-sim[view]'\n"
