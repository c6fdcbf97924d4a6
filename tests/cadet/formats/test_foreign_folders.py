"""Folders as other programs write them: any ids, other layouts, folders that are missing, and frames without points."""

from __future__ import annotations

import json
import os
import re
import shutil
import sys
from html import escape
from pathlib import Path
from typing import Any

import pytest

from cadet import kitti
from cadet.cli import run_cadet
from cadet.datasets.lidar_fit.scans import find_scans
from cadet.datasets.object_bank import ObjectBank
from cadet.errors import CadetError, MissingFileError
from cadet.formats.convert import convert
from cadet.formats.kitti import Dataset, ImageSet, write_frame, write_image_set
from cadet.formats.webdataset import ShardDataset, open_dataset
from synthetic import make_frame

NAMES = [
    ("0000000", "0000001"),
    ("0000000000", "0000000001"),
    ("001", "002"),
    ("1", "2"),
    ("805729458ae49dd0d72e7e428cdea67db775ceb2aa46e26ca9c5c0eb84823cae", "9"),
    ("a1b2", "c3d4"),
    ("n015-2018-07-24__CAM_FRONT__1532402927612460", "n015-2018-07-24__CAM_FRONT__1532402928112460"),
    ("scene.one", "scene.two"),
    ('"><img src=x onerror=alert(1)>', "'&amp;<b>"),
    ("frame 1", "frame 2"),
    ("straße_1", "straße_2"),
    ("x" * 200, "y" * 200),
]


def write_set(root: Path, ids: tuple[str, ...] = ("000000", "000001"), **changes: Any) -> Path:
    for number, frame_id in enumerate(ids):
        write_frame(root, frame_id, make_frame(seed=number, **changes), split=None)
    return root


def cadet(monkeypatch: pytest.MonkeyPatch, *arguments: object) -> int | str | None:
    """Run a command as a process of its own does, which has warned of nothing yet."""
    monkeypatch.setattr("cadet._util.notices._said", set())
    monkeypatch.setattr(sys, "argv", ["cadet", *map(str, arguments)])
    with pytest.raises(SystemExit) as ended:
        run_cadet()
    return ended.value.code


@pytest.mark.parametrize("ids", NAMES, ids=[first[:20] for first, _ in NAMES])
def test_any_stem_is_an_id(ids: tuple[str, str], tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    root = write_set(tmp_path / "set", ids)
    assert Dataset(root).ids == ids
    plain = [(one.rule, one.message) for one in kitti.lint(write_set(tmp_path / "plain"))]
    findings = kitti.lint(root)
    assert [(one.rule, one.message) for one in findings] == plain
    assert {one.frame_id for one in findings} <= set(ids)
    write_image_set(root, "train", ImageSet(ids[1:]))
    assert len(Dataset(root, "train")) == 1
    assert cadet(monkeypatch, "view", root / ids[1], "-o", tmp_path / "frame.png") == 0
    assert cadet(monkeypatch, "report", root, "-o", tmp_path / "page.html", "--workers", 1) == 0
    page = (tmp_path / "page.html").read_text(encoding="utf-8")
    assert escape(ids[0]) in page and (ids[0] == escape(ids[0]) or ids[0] not in page)
    assert cadet(monkeypatch, "bank", root, "-o", tmp_path / "bank", "--min-points", 1) == 0
    assert len(ObjectBank(tmp_path / "bank").types) > 0


@pytest.mark.parametrize("ids", NAMES, ids=[first[:20] for first, _ in NAMES])
def test_ids_go_through_shards_and_back_where_webdataset_has_room_for_them(
    ids: tuple[str, str], tmp_path: Path
) -> None:
    root = write_set(tmp_path / "set", ids)
    if not re.fullmatch("[0-9a-zA-Z_-]{1,80}", ids[0]):
        with pytest.raises(
            CadetError,
            match=r"^frame '.*: in shards ids are ASCII without dots and blanks, at most 80 letters: rename",
        ):
            convert(root, tmp_path / "shards", "webdataset")
        return
    convert(root, tmp_path / "shards", "webdataset")
    shards = open_dataset(tmp_path / "shards")
    assert isinstance(shards, ShardDataset) and shards.ids == ids
    convert(tmp_path / "shards", tmp_path / "back", "kitti")
    for path in (root / "training").rglob("*.*"):
        assert (tmp_path / "back" / path.relative_to(root)).read_bytes() == path.read_bytes()


def test_a_number_means_six_digits_and_view_names_what_was_meant(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    root = write_set(tmp_path, ("000012", "0000013", "a1"))
    assert kitti.read_frame(root, 12).image_size == kitti.read_frame(root, "000012").image_size
    with pytest.raises(MissingFileError, match=r"000013\.png: no such file"):
        kitti.read_frame(root, 13)
    for name, hint in (
        ("12", "did you mean .*/000012"),
        ("13", "did you mean .*/0000013"),
        ("b", "0000013, 000012, a1"),
    ):
        assert cadet(monkeypatch, "view", root / name) == 2
        err = capsys.readouterr().err
        assert f"no frame {name}: " in err and re.search(hint, err)


def test_notes_and_copies_among_the_files_are_no_frames(tmp_path: Path) -> None:
    root = write_set(tmp_path)
    folder = root / "training"
    for name in ("calib/readme.txt", "image_2/000001 (copy).png", "velodyne/._000000.bin", "image_2/Thumbs.db"):
        (folder / name).write_bytes(b"x")
    for name in ("gt_database/000000_Car_0.bin", "velodyne_reduced/000000.bin", "../kitti_infos_train.pkl"):
        (folder / name).parent.mkdir(exist_ok=True)
        (folder / name).write_bytes(b"x")
    assert Dataset(root).ids == ("000000", "000001")
    strays = [one.file for one in kitti.lint(root) if one.rule == "stray-file"]
    assert strays == ["image_2/000001 (copy).png", "calib/readme.txt"]
    (folder / "velodyne" / "000007.bin").write_bytes(b"")
    assert "000007" in Dataset(root).ids, "six digits are a frame's, whose other files are missing"


TOUCHED = [
    (("training/image_02/0000/000000.png", "training/calib/0000.txt"), r"KITTI's tracking set"),
    (("image_02/0000/000000.png", "velodyne/0000/000000.bin"), r"KITTI's tracking set"),
    (("calib/0000.txt", "label_02/0000.txt", "velodyne/0000/000000.bin"), r"KITTI's tracking set"),
    (("00/velodyne/000000.bin", "00/calib.txt"), r"KITTI's odometry set, or SemanticKITTI"),
    (("2011_09_26/2011_09_26_drive_0001_sync/oxts/data/0.txt",), r"KITTI's raw data"),
    (("2011_09_26_drive_0001_sync/velodyne_points/data/0.bin",), r"KITTI's raw data"),
    (("v1.0-mini/sample.json", "samples/LIDAR_TOP/a.pcd.bin"), r"a nuScenes folder .*export_kitti\.py"),
    (("sequences/00/velodyne/000000.bin",), r"KITTI's odometry set, or SemanticKITTI \(sequences/00\)"),
    (("segment-1.tfrecord",), r"Waymo's records .*create_data\.py waymo"),
    (("kitti_format/training/image_2/0000000.png",), r"name .*/kitti_format, once"),
    (("data_object_image_2/training/image_2/000000.png",), r"name .*/data_object_image_2, once .* lie side by side"),
    (("train/000000.tar",), r"shards of WebDataset .*cadet convert .* --to kitti"),
    (("images/1.jpg", "labels/1.txt"), r"no KITTI folder: it holds images, labels; expected training/image_2"),
    ((), r"no KITTI folder: it is empty"),
]


@pytest.mark.parametrize(("files", "message"), TOUCHED)
def test_other_layouts_are_named_with_what_to_do(
    files: tuple[str, ...],
    message: str,
    tmp_path: Path,
    monkeypatch: pytest.MonkeyPatch,
    capsys: pytest.CaptureFixture[str],
) -> None:
    for name in files:
        (tmp_path / name).parent.mkdir(parents=True, exist_ok=True)
        (tmp_path / name).write_bytes(b"")
    for command in (["check"], ["report"], ["bank", "-o", tmp_path / "bank"], ["view"]):
        if command == ["view"] and files == ("train/000000.tar",):
            continue
        with pytest.raises(MissingFileError, match=message):
            Dataset(tmp_path)
        assert cadet(monkeypatch, command[0], tmp_path, *command[1:]) == 2
        captured = capsys.readouterr()
        assert captured.out == "" and captured.err.startswith("cadet: ") and captured.err.count("\n") == 1


@pytest.mark.parametrize("name", ["kitti_tracking", "kitti_raw", "nuscenes", "webdataset", "parquet"])
def test_our_own_formats_are_named_by_their_manifest(name: str, tmp_path: Path) -> None:
    (tmp_path / "manifest.json").write_text(json.dumps({"cadet": "1.0", "dataset_format": name}))
    with pytest.raises(
        MissingFileError, match=rf": a set of format {name} \(manifest\.json\), .*: (cadet convert|write)"
    ):
        kitti.lint(tmp_path)


@pytest.mark.parametrize("content", ["", "[]", "{", '{"dataset_format": 3}', '{"cadet": "1", "dataset_format": "x"}'])
def test_a_manifest_of_another_kind_is_no_format(content: str, tmp_path: Path) -> None:
    (tmp_path / "manifest.json").write_text(content)
    with pytest.raises(MissingFileError, match=r"no KITTI folder: it holds manifest\.json"):
        Dataset(tmp_path)


def test_a_set_is_found_from_the_folders_around_it(tmp_path: Path) -> None:
    root = write_set(tmp_path / "object")
    write_image_set(root, "val", ImageSet(("000001",)))
    for place in (tmp_path, root, root / "training"):
        assert Dataset(place, "val").ids == ("000001",)
        assert len(kitti.lint(place)) == len(kitti.lint(root))
    shutil.copytree(root / "training", root / "testing")
    assert Dataset(root / "testing").folder == root / "testing"
    assert Dataset(tmp_path, None).folder == root / "training"


@pytest.mark.parametrize(
    "files", [(), ("image_2/a.png", "velodyne/b.bin", "calib/c.txt"), ("image_2/000000.bmp", "calib/readme.md")]
)
def test_folders_without_a_frame_are_no_whole_set(
    files: tuple[str, ...], tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    for kind in ("image_2", "velodyne", "calib"):
        (tmp_path / "training" / kind).mkdir(parents=True)
    for name in files:
        (tmp_path / "training" / name).write_bytes(b"")
    for command in (["check"], ["view"], ["view", "--rerun"], ["bank", "-o", tmp_path / "bank"]):
        assert cadet(monkeypatch, command[0], tmp_path, *command[1:]) == 2
        captured = capsys.readouterr()
        assert "0 frames" not in captured.out and captured.err.count("\n") == 1
        assert f"{tmp_path}: no frames: image_2 " in captured.err, captured.err
        assert all(Path(name).name in captured.err for name in files)


@pytest.mark.parametrize(
    ("kind", "instead", "said"),
    [
        ("velodyne", None, "none of 5 frames has a file"),
        ("image_2", "images", "images is there: rename it to image_2"),
        ("calib", "calib.txt", r"calib.txt is there: copy it to calib/ID.txt for every frame"),
        ("calib", "../calib.txt", r"calib.txt is there: copy it to calib/ID.txt for every frame"),
        ("velodyne", "velodyne_points", "velodyne_points is there: rename it to velodyne"),
        ("velodyne", "velodyne/part1", "; velodyne holds part1"),
        ("image_2", "colored_0", "colored_0 is there: rename it to image_2"),
        ("label_2", "labels", "labels is there: rename it to label_2"),
    ],
)
def test_a_folder_that_all_frames_lack_is_said_once(
    kind: str,
    instead: str | None,
    said: str,
    tmp_path: Path,
    monkeypatch: pytest.MonkeyPatch,
    capsys: pytest.CaptureFixture[str],
) -> None:
    root = write_set(tmp_path / "set", tuple(f"{number:06d}" for number in range(5)))
    shutil.rmtree(root / "training" / kind)
    if instead is not None:
        path = root / "training" / instead
        path.mkdir(parents=True) if path.suffix == "" else path.write_text("")
    missing = [one for one in kitti.lint(root) if one.rule == "missing-file"]
    assert len(missing) == 1 and missing[0].file.split("/")[-1] == kind and said in missing[0].message
    if kind == "label_2":
        assert missing[0].severity == "warning"
    else:
        assert missing[0].severity == "error"
    assert cadet(monkeypatch, "bank", root, "-o", tmp_path / "bank") == 2
    err = capsys.readouterr().err
    assert err.count("\n") == 1 and f"none of 5 frames has a file in {kind}, which is needed" in err
    assert instead is None or said in err


@pytest.mark.parametrize("kinds", [("velodyne",), ("image_2",), ("image_2", "label_2"), ("velodyne", "label_2")])
def test_frames_are_found_by_whatever_folders_there_are(kinds: tuple[str, ...], tmp_path: Path) -> None:
    root = write_set(tmp_path, ("a1", "b2", "c3"))
    for folder in (root / "training").iterdir():
        if folder.name not in kinds:
            shutil.rmtree(folder)
    assert Dataset(root).ids == ("a1", "b2", "c3")
    missing = {one.file.split("/")[-1] for one in kitti.lint(root) if one.rule == "missing-file"}
    assert missing == {"image_2", "velodyne", "calib", "label_2"} - set(kinds)


def test_scans_are_found_in_every_layout(tmp_path: Path) -> None:
    for number, folder in enumerate(
        (
            "training/velodyne",
            "velodyne",
            "object/training/velodyne",
            "training/velodyne/0000",
            "samples/LIDAR_TOP",
            "velodyne_points/data",
            "2011_09_26/2011_09_26_drive_0001_sync/velodyne_points/data",
        )
    ):
        path = tmp_path / str(number) / folder / "0.bin"
        path.parent.mkdir(parents=True)
        path.write_bytes(b"")
        assert find_scans([tmp_path / str(number)]) == [path]


@pytest.mark.parametrize("damaged", ["label_2/000001.txt", "image_2/000001.png", "velodyne/000001.bin"])
def test_a_frame_that_cannot_be_read_is_counted_and_the_others_are_taken(
    damaged: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    root = write_set(tmp_path / "set", ("000000", "000001", "000002", "000003"))
    (root / "training" / damaged).write_bytes(b"damaged")
    for command in (
        ["bank", root, "-o", tmp_path / "bank", "--min-points", 1],
        ["report", root, "-o", tmp_path / "page.html", "--workers", 1],
        ["view", root, "-o", tmp_path / "view.png"],
    ):
        assert cadet(monkeypatch, *command) == 0
        assert "1 of 4 frames cannot be read (000001: " in capsys.readouterr().err, command
    assert cadet(monkeypatch, "check", root) == 1
    assert "4 frames, " in capsys.readouterr().out
    for number in (0, 2):
        (root / "training" / damaged.replace("000001", f"{number:06d}")).write_bytes(b"damaged")
    for command in (["bank", root, "-o", tmp_path / "bank2"], ["view", root, "-o", tmp_path / "view2.png"]):
        assert cadet(monkeypatch, *command) == 2
        err = capsys.readouterr().err.splitlines()[-1]
        assert "3 of 4 frames cannot be read (000000: " in err and "more than half" in err
    assert not (tmp_path / "bank2" / "bank.json").exists() and not (tmp_path / "view2.png").exists()


def test_frames_without_points_pass_through_every_command(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    empty = make_frame().points_velo[:0]
    root = write_set(tmp_path / "set", points_velo=empty, plane=None)
    assert cadet(monkeypatch, "check", root, "--loose") == 0
    assert "no points" in capsys.readouterr().out
    assert cadet(monkeypatch, "view", root / "000000", "-o", tmp_path / "v.png") == 0
    assert cadet(monkeypatch, "report", root, "-o", tmp_path / "r.html", "--workers", 1) == 0
    assert cadet(monkeypatch, "bank", root, "-o", tmp_path / "bank") == 2
    assert "no object to put into a bank" in capsys.readouterr().err


def test_folders_that_no_program_should_meet_are_one_line(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    (tmp_path / "loop").symlink_to("loop")
    for command in (["check"], ["report"], ["bank", "-o", tmp_path / "bank"], ["view"]):
        assert cadet(monkeypatch, command[0], tmp_path / "loop", *command[1:]) == 2
        assert "loop: no such folder" in capsys.readouterr().err
    root = write_set(tmp_path / os.fsdecode(b"bad\xff"))
    (root / "training" / "image_2" / os.fsdecode(b"\xff\xfe.png")).write_bytes(b"")
    (root / "ImageSets").mkdir()
    os.mkfifo(root / "ImageSets" / "odd.txt")
    lists = [one for one in kitti.lint(root) if one.rule == "image-set"]
    assert [(one.file, one.message) for one in lists] == [("ImageSets/odd.txt", "expected a regular file, got a pipe")]
    assert cadet(monkeypatch, "report", root, "-o", tmp_path / "page.html", "--workers", 1) == 0
    with pytest.raises(CadetError, match="expected a regular file, got a pipe"):
        convert(root, tmp_path / "shards", "webdataset")
