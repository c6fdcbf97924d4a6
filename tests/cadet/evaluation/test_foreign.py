from __future__ import annotations

import json
import os
import pickle
from pathlib import Path
from typing import Any

import numpy as np
import pytest

import cadet
from cadet import CadetError, Detections
from cadet.errors import FileFormatError, MissingFileError
from foreign_results import nuscenes_result, openpcdet_frames, write_results, write_tables

ALL = (cadet.Level("All", 0.0, inclusive=True),)


@pytest.mark.parametrize("protocol", [4, 5])
def test_openpcdets_pickle_is_its_text(tmp_path: Path, protocol: int) -> None:
    frames = openpcdet_frames()
    (tmp_path / "result.pkl").write_bytes(pickle.dumps(frames, protocol))
    found = cadet.read_detections(tmp_path / "result.pkl")
    assert list(found) == ["000001", "000002"] and len(found["000002"].types) == 0
    # What OpenPCDet writes beside it, by its own format.
    one, line = frames[0], "%s -1 -1 %.4f %.4f %.4f %.4f %.4f %.4f %.4f %.4f %.4f %.4f %.4f %.4f %.4f\n"
    text = "".join(
        line
        % (
            one["name"][k],
            one["alpha"][k],
            *one["bbox"][k],
            *one["dimensions"][k][[1, 2, 0]],
            *one["location"][k],
            one["rotation_y"][k],
            one["score"][k],
        )
        for k in range(3)
    )
    expected = Detections.from_labels(cadet.kitti.labels_from_text(text))
    assert found["000001"].types == expected.types
    for name in ("boxes_img", "boxes_cam", "alphas", "scores"):
        np.testing.assert_allclose(getattr(found["000001"], name), getattr(expected, name), atol=1e-4)


def test_a_pickle_that_would_run_code_does_not(tmp_path: Path) -> None:
    class Evil:
        def __reduce__(self) -> Any:
            return os.mkdir, (str(tmp_path / "made"),)

    (tmp_path / "evil.pkl").write_bytes(pickle.dumps([Evil()]))
    with pytest.raises(FileFormatError, match=r"^evil\.pkl: no pickle of arrays: it names (posix|nt)\.mkdir"):
        cadet.read_detections(tmp_path / "evil.pkl")
    assert not (tmp_path / "made").exists()


@pytest.fixture
def tables(tmp_path: Path) -> Path:
    return write_tables(tmp_path)


def test_nuscenes_tables_become_boxes_about_the_car(tables: Path) -> None:
    (truth,) = cadet.read_ground_truth(tables).values()
    assert truth.types == ("car", "bus", "car"), "no returns and no class of the task leave an object out"
    # x right, y down, z forward from the ego's origin; the first looks ahead, the second, westward, to the left.
    np.testing.assert_allclose(truth.boxes_cam[0], [0, 0, 10, 4.2, 1.8, 1.6, -np.pi / 2], atol=1e-9)
    np.testing.assert_allclose(truth.boxes_cam[1], [-5, 0, 0, 11, 2.5, 3.0, -np.pi], atol=1e-9)


@pytest.mark.parametrize(("off_m", "limits"), [(0.0, 4), (0.8, 3), (1.5, 2), (3.0, 1), (5.0, 0)])
def test_nuscenes_results_are_scored_by_its_own_rules(tables: Path, off_m: float, limits: int) -> None:
    path = write_results(tables, nuscenes_result(translation=[100.0 + off_m, 60.0, 2.8]))
    found, truth = cadet.read_detections(path, tables), cadet.read_ground_truth(tables)
    result_of = cadet.analyze(truth, found, classes=["Car"], levels=ALL, parts=["centers"])
    assert result_of.centers is not None
    score = result_of.centers["Car"]
    assert score.n_gt == 1, "beyond 50 m nothing counts"
    assert [ap > 99.0 for ap in score.ap.values()] == [False] * (4 - limits) + [True] * limits
    if off_m == 0.0:
        assert (score.ate_m, score.ase, score.aoe_rad) == pytest.approx((0.0, 0.0, 0.0), abs=1e-6)


@pytest.mark.parametrize(
    ("content", "message"),
    [
        ("[]", r"not laid out as a detector's results are \(TypeError: "),
        ('{"s": []}', r"not laid out as a detector's results are \(KeyError: 'results'\)"),
        ('{"results": {"other": []}}', "sample 'other': the tables have no such sample"),
        ('{"results": {"s": [{"translation": [1, 2]}]}}', "not laid out as"),
        ("{", "invalid JSON"),
    ],
)
def test_what_is_no_nuscenes_result_is_refused_in_one_line(tables: Path, content: str, message: str) -> None:
    path = tables / "results_nusc.json"
    path.write_text(content)
    with pytest.raises(FileFormatError, match=rf"^results_nusc\.json.*{message}") as caught:
        cadet.read_detections(path, tables)
    assert "\n" not in str(caught.value)


@pytest.mark.parametrize(
    ("table", "change", "reason"),
    [
        ("ego_pose", lambda row: row.pop("token"), "KeyError: 'token'"),
        ("ego_pose", lambda row: row.update(rotation=[0, 0, 0, 0]), "ZeroDivisionError: "),
        ("instance", lambda row: row.update(category_token="none"), "KeyError: 'none'"),
        ("sample_annotation", lambda row: row.update(size="large"), "ValueError: "),
        ("sample_annotation", lambda row: row.update(rotation=None), "TypeError: "),
    ],
)
def test_damaged_tables_are_refused_in_one_line(tables: Path, table: str, change: Any, reason: str) -> None:
    path = tables / f"{table}.json"
    rows = json.loads(path.read_text())
    for row in rows:
        change(row)
    path.write_text(json.dumps(rows))
    with pytest.raises(FileFormatError, match=rf"not laid out as nuScenes' tables are \({reason}") as caught:
        cadet.read_ground_truth(tables)
    assert "\n" not in str(caught.value)


def test_what_is_missing_is_named(tmp_path: Path) -> None:
    (tmp_path / "r.json").write_text("{}")
    with pytest.raises(CadetError, match=r"r\.json: nuScenes' results need tables="):
        cadet.read_detections(tmp_path / "r.json")
    with pytest.raises(CadetError, match=r"expected OpenPCDet's \.pkl or nuScenes' \.json"):
        cadet.read_detections(tmp_path)
    with pytest.raises(MissingFileError, match=r"none\.pkl: no such file"):
        cadet.read_detections(tmp_path / "none.pkl")
    with pytest.raises(MissingFileError, match=r"sensor\.json: no such file"):
        cadet.read_ground_truth(tmp_path)
    (tmp_path / "bad.pkl").write_bytes(pickle.dumps([{"name": np.array(["Car"])}]))
    with pytest.raises(FileFormatError, match=r"^bad\.pkl: not laid out as a detector's results are \(KeyError"):
        cadet.read_detections(tmp_path / "bad.pkl")
