"""Test episodes of `cadet-gen`, and resuming among files that are none of its own."""

from __future__ import annotations

import json
import shutil
from dataclasses import replace
from pathlib import Path

import pytest

from cadet import CadetWarning, Camera, Lidar, MountedLidar, Pose, Rig, kitti
from cadet.errors import CadetError, MissingFileError
from cadet.generate import generate
from cadet.generate.settings import Settings
from cadet.worlds.policy import ResetPolicy
from gen_process import FAILED, FINE, SIZE, run, tree
from small_runs import make, small_settings

FOLDERS = ["calib", "image_2", "label_2", "meta", "planes", "velodyne"]


def ids(root: Path, split: str) -> list[str]:
    return (root / "ImageSets" / f"{split}.txt").read_text().split()


def names(first: int, last: int) -> list[str]:
    return [f"{number:06d}" for number in range(first, last)]


@pytest.fixture(scope="module")
def split_set(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """Seven episodes, of which the third and the sixth are test."""
    out = tmp_path_factory.mktemp("split") / "out"
    done = run(out, "-n", 26, "--seed", 3, *SIZE, "--test-fraction", 0.34, "--workers", 1)
    assert (done.returncode, done.stdout) == (FINE, "")
    return out


def test_without_test_frames_there_are_an_empty_list_and_empty_folders(tmp_path: Path) -> None:
    out = tmp_path / "out"
    assert run(out, "-n", 2, *SIZE).returncode == FINE
    assert (out / "ImageSets" / "test.txt").read_bytes() == b""
    assert sorted(path.name for path in (out / "testing").iterdir()) == ["calib", "image_2", "velodyne"]
    assert not any(path.is_file() for path in (out / "testing").rglob("*"))
    assert len(kitti.Dataset(out, "test")) == 0
    assert run(out, "-n", 2, *SIZE, "--resume").returncode == FINE


def test_every_third_episode_is_test(split_set: Path) -> None:
    assert ids(split_set, "test") == names(8, 12) + names(20, 24)
    assert ids(split_set, "val") == names(4, 8) + names(24, 26)
    assert ids(split_set, "train") == names(0, 4) + names(12, 20)
    assert ids(split_set, "trainval") == sorted(ids(split_set, "train") + ids(split_set, "val"))
    for part, members in (("training", ids(split_set, "trainval")), ("testing", ids(split_set, "test"))):
        assert sorted(path.name for path in (split_set / part).iterdir()) == FOLDERS
        for folder in FOLDERS:
            assert sorted(path.stem for path in (split_set / part / folder).iterdir()) == members


def test_test_frames_are_those_of_the_same_command_without_them(split_set: Path, tmp_path: Path) -> None:
    out = tmp_path / "out"
    make(out, 12)
    plain, with_test = tree(out), tree(split_set)
    for folder, suffix in (("image_2", "png"), ("velodyne", "bin"), ("label_2", "txt"), ("meta", "json")):
        for frame_id in names(8, 12):
            name = f"{folder}/{frame_id}.{suffix}"
            assert with_test[f"testing/{name}"] == plain[f"training/{name}"]


def test_the_manifest_names_test_frames(split_set: Path) -> None:
    manifest = json.loads((split_set / "manifest.json").read_text())
    files = tree(split_set)
    del files["manifest.json"], files["run.json"], files["croissant.json"]
    assert manifest["sha256"] == files
    assert manifest["test_fraction"] == 0.34
    assert manifest["counts"]["frames"] == 26


def test_a_dataset_reads_its_test_frames(split_set: Path, tmp_path: Path) -> None:
    dataset = kitti.Dataset(split_set, "test")
    assert dataset.ids == tuple(ids(split_set, "test"))
    meta = [frame.meta for frame in (dataset[0], dataset["000023"])]
    assert [(one["episode"], one["sample"]) for one in meta if one is not None] == [(2, 0), (5, 3)]
    assert len(kitti.Dataset(split_set)) == 18
    assert kitti.Dataset(split_set / "training", "test").ids == dataset.ids
    shutil.copytree(split_set / "training", tmp_path / "training")
    with pytest.raises(
        MissingFileError, match=r"no test frames: no testing/image_2, testing/velodyne or testing/calib"
    ):
        kitti.Dataset(tmp_path, "test")


def test_labels_of_test_frames_can_be_evaluated(split_set: Path) -> None:
    from cadet.evaluation.sources import choose

    chosen = choose(split_set / "testing" / "label_2", split_set / "testing" / "label_2", "test", "results")
    assert len(chosen.ids) == 8


@pytest.mark.parametrize("num_first", [9, 22])
def test_more_frames_move_no_test_frame(split_set: Path, tmp_path: Path, num_first: int) -> None:
    out = tmp_path / "out"
    make(out, num_first, test_fraction=0.34)
    before = tree(out)
    make(out, 26, test_fraction=0.34)
    after = tree(out)
    assert after == tree(split_set)
    assert all(after[name] == digest for name, digest in before.items() if name.startswith(("training", "testing")))


def test_resuming_mends_test_frames(split_set: Path, tmp_path: Path) -> None:
    out = tmp_path / "out"
    shutil.copytree(split_set, out)
    (out / "testing" / "velodyne" / "000009.bin").write_bytes(b"short")
    (out / "testing" / "meta" / "000022.json").unlink()
    shutil.rmtree(out / "testing" / "calib")
    make(out, 26, test_fraction=0.34)
    assert tree(out) == tree(split_set)


def test_fewer_frames_than_testing_has_are_refused(split_set: Path, tmp_path: Path) -> None:
    out = tmp_path / "out"
    shutil.copytree(split_set, out)
    for folder in FOLDERS:
        for path in (out / "training" / folder).iterdir():
            path.unlink()
    done = run(out, "-n", 23, "--seed", 3, *SIZE, "--test-fraction", 0.34, "--resume")
    assert (done.returncode, done.stderr) == (
        FAILED,
        f"cadet-gen: {out} has frames up to 000023 already: give at least -n 24\n",
    )


def test_another_test_fraction_is_another_run(split_set: Path) -> None:
    done = run(split_set, "-n", 26, "--seed", 3, *SIZE, "--resume")
    assert done.returncode == FAILED
    assert "was begun with other settings: test_fraction was 0.34, now 0.0" in done.stderr


@pytest.mark.parametrize("fraction", ["nan", "1e-9"])
@pytest.mark.parametrize("option", ["--val-fraction", "--test-fraction"])
def test_fractions_that_are_no_share_are_refused(tmp_path: Path, option: str, fraction: str) -> None:
    done = run(tmp_path / "out", "-n", 1, *SIZE, option, fraction)
    assert done.returncode == FAILED
    assert done.stderr.startswith(f"cadet-gen: {option}: expected ")
    assert done.stderr.count("\n") == 1
    assert not (tmp_path / "out").exists()


def test_a_split_is_a_function_of_the_episode() -> None:
    settings = Settings(num_frames=20, policy=ResetPolicy.kitti(), test_fraction=0.25)
    assert [settings.split(episode) for episode in range(8)] == "train val test train train train test train".split()


@pytest.mark.parametrize("name", ["000039 (copy).png", "999999999.png", "0.png", "12345٣.png", "000050.png.bak"])
def test_resuming_passes_over_strange_files(tmp_path: Path, name: str) -> None:
    out = tmp_path / "out"
    make(out, 1)
    whole = tree(out)
    for part in ("training", "testing"):
        (out / part / "image_2" / name).write_bytes(b"a copy")
    make(out, 1)
    assert {path: digest for path, digest in tree(out).items() if Path(path).name != name} == whole


META = [
    '{"sha256": ["image_2", "velodyne", "calib", "label_2", "planes"]}',
    '{"sha256": {"image_2": 1, "velodyne": 2, "calib": 3, "label_2": 4, "planes": [5]}}',
    '{"sha256": {"../image_2": "0"}}',
    "[" * 100_000,
    "[]",
    "5",
    "\xff",
]


@pytest.mark.parametrize("meta", META)
def test_resuming_makes_a_frame_anew_whose_meta_holds_no_hashes(tmp_path: Path, meta: str) -> None:
    out = tmp_path / "out"
    make(out, 1)
    whole = tree(out)
    (out / "training" / "meta" / "000000.json").write_text(meta, encoding="latin-1")
    assert [made.is_new for made in make(out, 1)] == [True]
    assert tree(out) == whole


CHANGES = {
    "a value": ('"weather": "', '"weather": "x'),
    "a number": ('"time_s": ', '"time_s": 1'),
    "a blank": ("\n}", "\n }"),
    "the seal": ('"record": "', '"record": "0'),
    "the kind of seal": ('"record": "', '"record": 5, "old": "'),
    "another file's hash": ('"velodyne": "', '"velodyne": "0'),
}


@pytest.mark.parametrize("has_manifest", [True, False])
@pytest.mark.parametrize("change", CHANGES)
def test_a_damaged_record_is_named_and_made_anew(tmp_path: Path, change: str, has_manifest: bool) -> None:
    out = tmp_path / "out"
    make(out, 2)
    whole = tree(out)
    meta = out / "training" / "meta" / "000000.json"
    damaged = meta.read_text().replace(*CHANGES[change])
    assert damaged != meta.read_text()
    meta.write_text(damaged)
    if not has_manifest:
        (out / "manifest.json").unlink()
    found = [finding for finding in kitti.lint(out) if finding.rule == "wrong-hash"]
    assert {finding.file for finding in found} <= {"meta/000000.json", "velodyne/000000.bin"}
    assert [finding.file for finding in found].count("meta/000000.json") == 1
    assert sorted((made.number, made.is_new) for made in make(out, 2)) == [(0, True), (1, False)]
    assert tree(out) == whole


def test_frames_at_a_standstill_are_counted_and_said(tmp_path: Path) -> None:
    out = tmp_path / "out"
    done = run(out, "-n", 12, *SIZE, "--workers", 1, fault="stand=2")
    said = "8 of 12 frames were taken at a standstill, among them more than half of these episodes': 0, 1; "
    assert done.returncode == FINE and said in done.stderr
    whole = tree(out)
    assert json.loads((out / "manifest.json").read_text())["counts"]["standing"] == 8
    (out / "training" / "meta" / "000003.json").unlink()
    done = run(out, "-n", 12, *SIZE, "--workers", 1, "--resume", fault="stand=2")
    assert said in done.stderr and tree(out) == whole


def test_a_rig_of_the_settings_replaces_those_of_the_policy() -> None:
    given = Settings(policy=ResetPolicy.kitti(), rig=Rig.paper())
    asked = Settings(policy=ResetPolicy.kitti().with_rig(Rig.paper()))
    assert given == asked and given.identity() == asked.identity()
    assert given.identity() != Settings(policy=ResetPolicy.kitti()).identity()
    assert replace(given, num_frames=40).identity() == asked.identity()
    with pytest.raises(CadetError, match="rig: expected"):
        Settings(policy=ResetPolicy.kitti(), rig="paper")  # type: ignore[arg-type]


def test_a_run_says_which_sensors_its_format_does_not_write(tmp_path: Path) -> None:
    side = MountedLidar(name="side", lidar=Lidar.vlp16(), pose=Pose.of_angles((0.0, 0.9, 1.5)))
    rig = Rig(camera=Camera.kitti().resized(64, 32), lidar=Lidar.vlp16()).with_sensors(side)
    settings = small_settings(1, rig=rig)
    assert replace(settings, format="nuscenes", policy=settings.policy.as_sequence()).unwritten_sensors == ()
    with pytest.warns(CadetWarning, match=r"^kitti: not written: side \(the format nuscenes has every sensor\)$"):
        generate(tmp_path / "out", settings, workers=1)
