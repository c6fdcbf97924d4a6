"""Folders, memory, splits, frame rules, and what is wrong with files."""

from __future__ import annotations

import os
import re
import subprocess
import sys
from collections.abc import Callable
from pathlib import Path

import numpy as np
import pytest

import cadet
from cadet import CadetError, Detections, GroundTruth, KittiFormatError, MissingFileError, NonFiniteError, ShapeError
from cadet.formats.kitti import Label, labels_from_text
from cadet.formats.kitti.files.dialects import collected
from cadet.formats.kitti.files.text import text_from_bytes
from evaluation_helpers import detected, make_object, write

CAR = make_object()
GT: list[list[Label]] = [[CAR, make_object("Cyclist", 1)] for _ in range(50)]
DET = [[detected(CAR, 0.5 + index / 100), detected(GT[0][1], 0.7)][: 1 + index % 2] for index in range(50)]


@pytest.fixture
def folders(tmp_path: Path) -> tuple[Path, Path]:
    return write(tmp_path / "training" / "label_2", GT), write(tmp_path / "results" / "data", DET)


def test_memory_gives_what_folders_give(folders: tuple[Path, Path]) -> None:
    gt, det = folders
    report = cadet.evaluate(gt, det)
    by_id = {f"{index:06d}": labels for index, labels in enumerate(DET)}
    truths = [GroundTruth.from_labels(labels) for labels in GT]
    assert cadet.evaluate(GT, DET) == report
    assert cadet.evaluate(truths, [Detections.from_labels(labels) for labels in DET]) == report
    assert cadet.evaluate(gt, by_id) == report
    assert cadet.evaluate({f"{index:06d}": truth for index, truth in enumerate(truths)}, det) == report


def test_usual_layouts_are_found(folders: tuple[Path, Path], tmp_path: Path) -> None:
    report = cadet.evaluate(*folders)
    assert cadet.evaluate(tmp_path, tmp_path / "results") == report
    assert cadet.evaluate(str(tmp_path / "training"), str(folders[1])) == report


def test_only_frames_with_a_result_file_count_unless_all_are_asked_for(folders: tuple[Path, Path]) -> None:
    gt, det = folders
    for index in range(40, 50):
        (det / f"{index:06d}.txt").unlink()
    (det / "000039.txt").write_text("")
    results, all_frames = cadet.evaluate(gt, det), cadet.evaluate(gt, det, frames="all")
    assert (results.num_frames, results.num_missing, results.n_gt["Car"]["3d"]["Easy"]) == (40, 10, 40)
    assert (all_frames.num_frames, all_frames.num_missing, all_frames.n_gt["Car"]["3d"]["Easy"]) == (50, 10, 50)
    assert 'frames="results": the 40 frames that have a result file, 10 others left out' in results.to_markdown()
    assert 'frames="all": 50 frames, 10 of them without a result file' in all_frames.to_markdown()
    padded = [DET[index] if index < 39 else [] for index in range(50)]
    assert cadet.evaluate(GT, padded).ap == all_frames.ap


def test_splits_choose_frames(folders: tuple[Path, Path], tmp_path: Path) -> None:
    gt, det = folders
    ids = [f"{index:06d}" for index in range(0, 50, 2)]
    lists = tmp_path / "ImageSets"
    with pytest.raises(MissingFileError, match=rf"^{gt}: no ImageSets lies beside these labels; name a list's file"):
        cadet.evaluate(gt, det, split="val")
    lists.mkdir()
    (lists / "val.txt").write_text("\n".join(ids))
    (det / "000004.txt").unlink()
    expected = cadet.evaluate({i: GT[int(i)] for i in ids}, {i: DET[int(i)] for i in ids if i != "000004"})
    assert expected.num_frames == 24
    for split in ("val", lists / "val.txt", ids):
        assert cadet.evaluate(gt, det, split=split) == expected
    with pytest.raises(MissingFileError, match=r"test\.txt"):
        cadet.evaluate(gt, det, split="test")
    (lists / "train.txt").write_text("")
    with pytest.raises(
        MissingFileError, match=rf"^{lists}/train\.txt names no frames; choose another list: val \(25\)$"
    ):
        cadet.evaluate(gt, det, split="train")
    with pytest.raises(MissingFileError, match=rf"^{lists}/train\.txt names no frames$"):
        cadet.evaluate(gt, det, split=lists / "train.txt")


def test_the_test_split_is_read_from_testing(folders: tuple[Path, Path], tmp_path: Path) -> None:
    gt, det = folders
    ids = [f"{index:06d}" for index in range(40, 50)]
    (tmp_path / "testing" / "label_2").mkdir(parents=True)
    (tmp_path / "ImageSets").mkdir()
    (tmp_path / "ImageSets" / "test.txt").write_text("\n".join(ids))
    (tmp_path / "ImageSets" / "val.txt").write_text("000003")
    for frame_id in ids:
        (gt / f"{frame_id}.txt").rename(tmp_path / "testing" / "label_2" / f"{frame_id}.txt")
    expected = cadet.evaluate({i: GT[int(i)] for i in ids}, {i: DET[int(i)] for i in ids})
    assert cadet.evaluate(tmp_path, det, split="test") == expected
    assert cadet.evaluate(tmp_path / "testing", det, split="test") == expected
    assert cadet.evaluate(tmp_path, det, split="val").num_frames == 1


def test_a_result_without_labels_is_refused(folders: tuple[Path, Path]) -> None:
    gt, det = folders
    (gt / "000007.txt").unlink()
    for rule in ("results", "all"):
        with pytest.raises(MissingFileError, match=r"frame 000007 has no ground truth: 1 frames .* \(000007\); the"):
            cadet.evaluate(gt, det, frames=rule)


def test_ids_are_any_stem_and_three_of_each_side_are_named(folders: tuple[Path, Path]) -> None:
    gt, det = folders
    report = cadet.evaluate(gt, det)
    for folder in folders:
        for path in folder.iterdir():
            path.rename(folder / f"frame.{int(path.stem)}-a.txt")
        (folder / ".hidden.txt").write_text("")
    assert cadet.evaluate(gt, det) == report
    for path in det.iterdir():
        path.rename(det / path.name.replace("frame", "other"))
    with pytest.raises(MissingFileError) as refused:
        cadet.evaluate(gt, det)
    found = "50 frames that count have none (other.0-a, other.1-a, other.10-a, ...)"
    assert found in str(refused.value)
    assert str(refused.value).endswith("the ground truth's are frame.0-a, frame.1-a, frame.10-a, ...")


def test_no_frames_are_refused(folders: tuple[Path, Path], tmp_path: Path) -> None:
    (tmp_path / "empty").mkdir()
    with pytest.raises(MissingFileError, match="empty: no frames"):
        cadet.evaluate(folders[0], tmp_path / "empty")
    with pytest.raises(MissingFileError, match="nowhere: no such folder"):
        cadet.evaluate(folders[0], tmp_path / "nowhere")


@pytest.mark.parametrize(
    ("line", "column", "reason"),
    [
        ("Car -1 -1 0 1 2 3 4 1 1 1 1 1 1", 15, "rotation_y: expected 16 columns, got 14"),
        ("Car -1 -1 0 1 2 3 4 1 1 1 1 1 1 0", 16, "score: expected 16 columns, got 15: a result ends with its score"),
        (
            "0 4 Car -1 -1 0 1 2 3 4 1 1 1 1 1 1 0 0.5",
            1,
            'type: expected a name such as Car, got "0"; a line of KITTI\'s',
        ),
        ("Car -1 -1 0 1 2 3 4 1 1 1 1 1 1 0 0.5 0.5", 17, "expected 16 columns, got 17"),
        ("Car -1 -1 0 1 two 3 4 1 1 1 1 1 1 0 0.5", 6, 'bbox_top: expected a finite number, got "two"'),
        ("Car -1 -1 0 1 2 3 4 1 1 1 1 1 1 0 nan", 16, 'score: expected a finite number, got "nan"'),
        ("-1 -1 0 1 2 3 4 1 1 1 1 1 1 0 0.5", 1, "type: expected a name"),
    ],
)
def test_malformed_lines_are_named_by_file_line_and_column(
    folders: tuple[Path, Path], line: str, column: int, reason: str
) -> None:
    path = folders[1] / "000011.txt"
    path.write_text(path.read_text() + "\n" + line + "\n")
    with pytest.raises(KittiFormatError) as caught:
        cadet.evaluate(*folders)
    error = caught.value
    number = path.read_text().split("\n").index(line) + 1
    assert (error.file, error.line, error.column) == ("data/000011.txt", number, column)
    assert error.reason.startswith(reason)
    assert str(error) == f"data/000011.txt:{number}: column {column}: {error.reason}"


def test_labels_need_whole_occlusion(folders: tuple[Path, Path]) -> None:
    path = folders[0] / "000003.txt"
    path.write_text(path.read_text().replace("Car 0.00 0 ", "Car 0.00 0.5 "))
    with pytest.raises(KittiFormatError, match=r"label_2/000003.txt:1: column 3: occluded: expected a whole number"):
        cadet.evaluate(*folders)


Edit = Callable[[bytes], bytes]
# What both sides' files, and labels alone, may be written like.
EITHER: dict[str, Edit] = {
    "mark": lambda text: b"\xef\xbb\xbf" + text,
    "crlf": lambda text: text.replace(b"\n", b"\r\n"),
    "cr": lambda text: text.replace(b"\n", b"\r"),
    "no last newline": lambda text: text.rstrip(),
    "blanks": lambda text: b"\r\n \t\r\n" + text.replace(b" ", b" \t ").replace(b"\n", b" \t\n\n"),
    "letter case": lambda text: text.replace(b"Car", b"car").replace(b"Cyclist", b"CYCLIST"),
}
LABELS_ALONE: dict[str, Edit] = {
    "score": lambda text: text.replace(b"\n", b" 0.00\n"),
    "more columns": lambda text: text.replace(b"\n", b" 436 2018_03_07 0002\n"),
    "occluded": lambda text: text.replace(b"0.00 0 ", b"0.00 0.0 "),
}


@pytest.mark.parametrize("name", [*EITHER, *LABELS_ALONE])
def test_dialects_give_what_plain_files_give_to_both_readers(folders: tuple[Path, Path], name: str) -> None:
    report = cadet.evaluate(*folders)
    edit = (EITHER | LABELS_ALONE)[name]
    for folder in folders if name in EITHER else folders[:1]:
        for path in folder.iterdir():
            path.write_bytes(edit(path.read_bytes()))
    assert cadet.evaluate(*folders) == report
    with collected():
        sides = [
            {path.stem: labels_from_text(text_from_bytes(path.read_bytes(), path.name)) for path in folder.iterdir()}
            for folder in folders
        ]
    assert cadet.evaluate(*sides) == report


@pytest.mark.parametrize(
    ("data", "reason"),
    [
        ("Car".encode("utf-16"), "UTF-16, or no text: save it as UTF-8, as iconv -f UTF-16 -t UTF-8 does"),
        ("Car".encode("utf-16-be"), "UTF-16, or no text: save it as UTF-8"),
        ("\nAuto\u00e4 0".encode(), "byte 0xc3 is not ASCII: write plain numbers, and names in ASCII letters"),
        ("\ufeff\nCar \u22121".encode(), "byte 0xe2 is not ASCII"),
        (b"nan 0 0 0 1 2 3 4 1 1 1 1 1 1 0 1", "type: expected a name such as Car"),
        (b"#Car 0 0 0 1 2 3 4 1 1 1 1 1 1 0 1", "type: expected a name such as Car"),
        (b"<b> 0 0 0 1 2 3 4 1 1 1 1 1 1 0 1", "type: expected a name such as Car"),
    ],
)
def test_both_readers_refuse_alike(folders: tuple[Path, Path], data: bytes, reason: str) -> None:
    lines = set()
    for folder in folders:
        path = folder / "000000.txt"
        kept = path.read_bytes()
        path.write_bytes(data)
        with pytest.raises(KittiFormatError, match=re.escape(reason)) as refused:
            cadet.evaluate(*folders)
        path.write_bytes(kept)
        lines.add(refused.value.line)
    with pytest.raises(KittiFormatError, match=re.escape(reason)) as refused, collected():
        labels_from_text(text_from_bytes(data, "000000.txt"), "000000.txt")
    assert lines == {refused.value.line}


def test_arrays_are_checked() -> None:
    fine = Detections.from_labels(DET[1])
    fields = {name: getattr(fine, name) for name in ("types", "boxes_img", "boxes_cam", "alphas", "scores")}
    with pytest.raises(ShapeError, match="boxes_cam"):
        Detections(**{**fields, "boxes_cam": fine.boxes_cam[:, :6]})
    with pytest.raises(ShapeError, match="scores"):
        Detections(**{**fields, "scores": fine.scores[:1]})
    with pytest.raises(NonFiniteError, match="alphas"):
        Detections(**{**fields, "alphas": np.array([0.0, np.nan])})
    with pytest.raises(CadetError, match="above -1e"):
        Detections(**{**fields, "scores": np.array([0.0, -1e7])})
    with pytest.raises(ShapeError, match="no score"):
        Detections.from_labels(GT[0])
    half = Detections(**{**fields, "boxes_cam": fine.boxes_cam.astype(np.float32)})
    assert half.rows().dtype == np.float64


@pytest.mark.parametrize(
    "settings",
    [
        {"classes": ["Cars"]},
        {"classes": []},
        {"classes": ["Car", "Car"]},
        {"classes": ["DontCare"]},
        {"classes": ["Van"]},
        {"recall": "R41"},
        {"min_overlap": "lax"},
        {"min_overlap": {"Car": 1.0}},
        {"min_overlap": {"Car": (0.5, 0.5)}},
        {"min_overlap": {"Car": {"4d": 0.5}}},
        {"min_overlap": {"Cars": 0.5}},
        {"classes": ["1.5"], "min_overlap": {"1.5": 0.5}},
        {"classes": ["dontcare"], "min_overlap": {"Car": 0.5}},
        {"boxes_2d": "projected"},
        {"boxes_2d": "project"},
        {"levels": "nuscenes"},
        {"levels": []},
        {"frames": "some"},
        {"split": "val"},
    ],
)
def test_settings_that_make_no_sense_are_refused(settings: dict[str, object]) -> None:
    with pytest.raises(CadetError):
        cadet.evaluate(GT, DET, **settings)  # type: ignore[arg-type]


def test_frames_that_do_not_pair_are_refused(folders: tuple[Path, Path]) -> None:
    with pytest.raises(CadetError, match="no ids to pair"):
        cadet.evaluate(folders[0], DET)
    with pytest.raises(CadetError, match="expected 50 frames"):
        cadet.evaluate(GT, DET[1:])


def test_limits_can_be_set_by_class_and_metric() -> None:
    report = cadet.evaluate(GT, DET, classes=["Car", "Van"], min_overlap={"Car": {"bev": 0.5}, "Van": (0.7, 0.5, 0.25)})
    assert report.min_overlap == {
        "Car": {"2d": 0.7, "bev": 0.5, "3d": 0.7},
        "Van": {"2d": 0.7, "bev": 0.5, "3d": 0.25},
    }


def test_the_number_of_threads_changes_nothing(folders: tuple[Path, Path]) -> None:
    code = "import sys, cadet; sys.stdout.write(cadet.evaluate(*sys.argv[1:]).to_json())"
    outputs = [
        subprocess.run(
            [sys.executable, "-c", code, *map(str, folders)],
            env={**os.environ, "RAYON_NUM_THREADS": str(count)},
            capture_output=True,
            check=True,
            timeout=60,
        ).stdout
        for count in (1, 7)
    ]
    assert outputs[0] == outputs[1]
    assert outputs[0].decode() == cadet.evaluate(*folders).to_json()
