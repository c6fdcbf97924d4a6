"""A hundred generated frames, read back from their folder as a stranger would, and judged by the definitions."""

from __future__ import annotations

import os
import subprocess
import sys
from collections import Counter
from itertools import pairwise
from pathlib import Path

import numpy as np
import pytest

import cadet
from cadet.formats.kitti.boxes import corners_cam

NUM_FRAMES = 100


def cadet_gen(*arguments: object) -> None:
    code = "from cadet.cli import run_cadet_gen\nif __name__ == '__main__':\n    run_cadet_gen()"
    environment = {**os.environ, "PYTHONPATH": str(Path(__file__).parents[3] / "python")}
    done = subprocess.run(
        [sys.executable, "-c", code, *map(str, arguments)],
        env=environment,
        text=True,
        capture_output=True,
        timeout=500,
        check=False,
    )
    assert done.returncode == 0, done.stderr


@pytest.fixture(scope="module")
def root(tmp_path_factory: pytest.TempPathFactory) -> Path:
    out = tmp_path_factory.mktemp("hundred") / "out"
    cadet_gen(out, "-n", NUM_FRAMES, "--seed", 11, "--workers", 2, "--write", "instance")
    return out


@pytest.mark.timeout(600)
def test_every_frame_keeps_the_definitions(root: Path) -> None:
    assert len(cadet.kitti.Dataset(root)) == NUM_FRAMES
    assert cadet.kitti.lint(root, strict=True) == []


@pytest.mark.timeout(600)
def test_splits_go_by_episode(root: Path) -> None:
    train, val = (cadet.kitti.Dataset(root, split).ids for split in ("train", "val"))
    assert [int(i) // 20 % 5 for i in val] == [1] * 20
    assert sorted([*train, *val]) == [f"{i:06d}" for i in range(NUM_FRAMES)]


@pytest.mark.timeout(600)
def test_no_frame_shows_again_what_the_one_before_it_showed(root: Path) -> None:
    frames = list(cadet.kitti.Dataset(root))
    compared = 0
    for before, frame in pairwise(frames):
        assert before.meta is not None and frame.meta is not None
        if any(before.meta[key] != frame.meta[key] for key in ("episode", "attempt")):
            continue
        compared += 1
        ego = [np.array(f.meta["world_from_ego"])[:3, 3] for f in (before, frame) if f.meta is not None]
        boxes = [
            {
                o["actor_id"]: np.array(label.bbox)
                for o, label in zip(f.meta["objects"], f.labels, strict=True)
                if label.type != "DontCare"
            }
            for f in (before, frame)
            if f.meta is not None
        ]
        has_moved = [
            actor not in boxes[0] or np.abs(box - boxes[0][actor]).max() >= 7.9 for actor, box in boxes[1].items()
        ]
        assert np.linalg.norm(ego[1] - ego[0]) >= 0.5 or any(has_moved), frame
    assert compared > 0.7 * NUM_FRAMES


@pytest.mark.timeout(600)
def test_truncation_and_bbox_follow_from_the_box(root: Path) -> None:
    """A second projection, written from the definition: dense points of the box's surface instead of its edges."""
    truncated = 0
    for frame in cadet.kitti.Dataset(root):
        height, width = frame.image.shape[:2]
        for label in frame.labels:
            if label.type == "DontCare":
                continue
            h, w, length = label.dimensions_hwl
            box = np.array([[*label.location_cam, length, w, h, label.rotation_y]])
            c = corners_cam(box)[0]
            t = np.linspace(0, 1, 161)[:, None]
            pairs = [(0, 1), (1, 2), (2, 3), (3, 0), (4, 5), (5, 6), (6, 7), (7, 4), (0, 4), (1, 5), (2, 6), (3, 7)]
            points = np.concatenate([c[i] + (c[j] - c[i]) * t for i, j in pairs])
            if points[:, 2].min() < 1.0:
                continue  # cut by the camera's plane: the dense points miss the cut itself
            uvw = points @ frame.calib.P2[:, :3].T + frame.calib.P2[:, 3]
            uv = uvw[:, :2] / uvw[:, 2:]
            whole = np.array([*uv.min(axis=0), *uv.max(axis=0)])
            inside = np.clip(whole, 0, [width - 1, height - 1] * 2)
            # Two decimals of place and heading move the nearest corner by this many pixels.
            slack = 0.7 + frame.calib.P2[0, 0] * (0.01 + 0.005 * np.hypot(length, w) / 2) / points[:, 2].min()
            assert np.abs(inside - label.bbox).max() < slack, (frame, label)
            expected = 1 - np.prod(inside[2:] - inside[:2]) / np.prod(whole[2:] - whole[:2])
            assert abs(expected - label.truncated) < 0.05
            truncated += label.truncated > 0.05
            angle = label.rotation_y - np.arctan2(label.location_cam[0], label.location_cam[2])
            assert abs((label.alpha - angle + np.pi) % (2 * np.pi) - np.pi) < 0.03
            assert label.type != "Car" or length > w
    assert truncated > 5


@pytest.mark.timeout(600)
def test_the_set_looks_like_a_detection_set(root: Path) -> None:
    counts = Counter(label.type for frame in cadet.kitti.Dataset(root) for label in frame.labels)
    assert 1.5 * NUM_FRAMES < counts["Car"] < 12 * NUM_FRAMES
    assert counts["Pedestrian"] > 0.1 * NUM_FRAMES
    assert set(counts) <= {"Car", "Van", "Truck", "Pedestrian", "Person_sitting", "Cyclist", "Tram", "Misc", "DontCare"}
    points = [len(frame.points_velo) for frame in cadet.kitti.Dataset(root)]
    assert 90_000 < np.median(points) < 135_000


MAPS = Path(__file__).parents[4] / "shared" / "maps"


@pytest.mark.timeout(300)
@pytest.mark.parametrize("name", ["Town01", "Town02"])
def test_the_papers_towns_drive(name: str, tmp_path: Path) -> None:
    source = MAPS / f"{name}.xodr"
    if not source.exists():
        pytest.skip(f"needs the paper's map {name}.xodr in ../shared/maps")
    # One episode, longer than a red light.
    cadet_gen(tmp_path / "out", "-n", 20, "--seed", 4, "--policy", "paper", "--rig", "paper", "--map", source)
    frames = list(cadet.kitti.Dataset(tmp_path / "out"))
    assert cadet.kitti.lint(tmp_path / "out", strict=True) == []
    assert len(frames) == 20
    assert sum(label.type == "Car" for frame in frames for label in frame.labels) >= 20
    places = [np.array(frame.meta["world_from_ego"])[:2, 3] for frame in frames if frame.meta is not None]
    assert max(np.linalg.norm(place - places[0]) for place in places) > 5, "the ego drives"
