"""What objects print of themselves fits a screen: shapes and counts."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import pytest

import cadet
from cadet import kitti
from cadet.evaluation.curve import Curve
from cadet.sensors.firing import ListedFiring
from evaluation_helpers import detected
from mesh_files.obj_meshes import assets_folder
from synthetic import make_frame

SCREEN = 80 * 24


def own_lidar() -> cadet.Lidar:
    lasers = tuple(cadet.Laser(elevation_deg=-0.01 * k, height_m=0.1 / 3) for k in range(500))
    firing = ListedFiring(azimuths_deg=tuple(0.1 * k for k in range(3600)))
    return cadet.Lidar.custom(cadet.BeamTable(name="mine", rings=lasers, firing=firing))


@pytest.fixture(scope="module")
def scene() -> cadet.Scene:
    return cadet.Scene.empty()


def test_objects_fit_a_few_lines(scene: cadet.Scene, tmp_path: Path) -> None:
    frame = make_frame(has_maps=True)
    truths = [label for label in frame.labels if not label.is_dont_care] * 40
    environment = cadet.Environment(policy="paper")
    rig = replace(cadet.Rig.kitti(), lidar=own_lidar())
    shown: dict[str, list[str]] = {
        repr(frame): ["(190, 620, 3) uint8", "(4600, 4) float32", "2 Car, 1 Pedestrian, 1 DontCare", "weather"],
        repr(frame.calib): ["360.0, 360.0", "P2=(3, 4) float64", "Tr_velo_to_cam"],
        repr(frame.labels[0]): ["Car"],
        repr(cadet.GroundTruth.from_labels(truths)): ["80 Car, 40 Pedestrian", "(120, 7)"],
        repr(cadet.Detections.from_labels([detected(label, 0.7) for label in truths])): ["(120, 4)", "best score 0.7"],
        repr(kitti.ImageSet(tuple(f"{k:06d}" for k in range(7481)))): ["7481", "000000", "007480"],
        repr(cadet.Lidar.hdl64e_kitti(rolling=True)): ["Lidar(name='hdl64e_kitti', rolling=True)"],
        repr(own_lidar()): ["mine", "500 rings", "3600 azimuths"],
        repr(rig): ["kitti", "mine", "Camera(width=1242"],
        repr(cadet.ResetPolicy.kitti()): ["kitti", "parked_rows", "13 weathers"],
        repr(environment): ["Environment(policy='paper', episode=0, sample=0)"],
        repr(cadet.ResetPolicy.kitti().draw(0, 0)): ["EpisodeSpec"],
        repr(scene): ["Scene(time_s=", "num_actors=0", "num_triangles="],
        repr(scene.scan()): ["Scan(points_velo=(", " rings"],
        repr(scene.cast_rays([[0.0, 0.0, 50.0]] * 5000, [[0.0, 0.0, -1.0]] * 5000)): [
            "(5000,) float64",
            "5000 hits",
        ],
        repr(cadet.Assets.read(assets_folder(tmp_path))): ["Assets(actors='1 Car'"],
        repr(scene.capture()): ["(375, 1242, 3) uint8"],
    }
    for text, parts in shown.items():
        assert len(text) <= 1400, text
        for part in parts:
            assert part in text, text


def test_a_report_prints_its_table() -> None:
    labels = [label for label in make_frame().labels if not label.is_dont_care]
    found = [detected(label, 0.01 * (k % 90 + 1)) for k, label in enumerate(labels)]
    report = cadet.evaluate([labels] * 50, [found] * 50)
    assert len(repr(report)) <= 200 and len(str(report)) <= SCREEN
    lines = str(report).splitlines()
    assert lines[0] == report.title()
    assert lines[1].split() == ["Class", "Metric", "Overlap", ">", "Easy", "Moderate", "Hard"]
    rows = report.table()[1:]
    assert [line.split() for line in lines[2 : 2 + len(rows)]] == [" ".join(row).split() for row in rows]
    curve = report.curves["Car"]["3d"]["Easy"]
    assert isinstance(curve, Curve) and len(repr(curve)) <= 100
