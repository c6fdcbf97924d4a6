"""`cadet-gen` as its own process: bytes, kills, resuming, and every way to go wrong."""

from __future__ import annotations

import json
import os
import re
import shutil
import signal
import subprocess
import sys
from collections import Counter
from collections.abc import Callable, Iterator
from pathlib import Path

import numpy as np
import pytest

from cadet import kitti
from cadet._util.interrupts import interrupts_held
from cadet._util.sink import LocalSink
from cadet.errors import CadetError, CadetWarning
from cadet.generate import generate
from cadet.generate import run as run_module
from cadet.generate.engines import local_engine
from cadet.generate.folder import open_folder
from gen_process import FAILED, FINE, INTERRUPTED, SIZE, run, start, tree, wait_for, workers_of, write_whole
from small_runs import make, small_settings


@pytest.fixture(autouse=True)
def _hears_ctrl_c() -> Iterator[None]:
    """Whoever runs the tests in the background has them ignore Ctrl-C, and all that they start."""
    before = signal.signal(signal.SIGINT, signal.default_int_handler)
    yield
    signal.signal(signal.SIGINT, before)


@pytest.fixture(scope="module")
def whole(tmp_path_factory: pytest.TempPathFactory) -> Path:
    return write_whole(tmp_path_factory)


def test_the_layout_is_kittis(whole: Path) -> None:
    dataset = kitti.Dataset(whole)
    assert dataset.ids == tuple(f"{number:06d}" for number in range(10))
    names = "ImageSets croissant.json manifest.json run.json testing training".split()
    assert sorted(path.name for path in whole.iterdir()) == names
    folders = ["calib", "image_2", "label_2", "meta", "planes", "velodyne"]
    assert sorted(path.name for path in (whole / "training").iterdir()) == folders
    frame = kitti.read_frame(whole, 5)
    assert frame.image.shape == (32, 64, 3)
    assert frame.meta is not None
    assert (frame.meta["episode"], frame.meta["sample"]) == (1, 1)
    assert any(not label.is_dont_care for label in frame.labels)


def test_the_manifest_holds_every_files_hash_and_nothing_of_the_machine(whole: Path) -> None:
    text = (whole / "manifest.json").read_text()
    manifest = json.loads(text)
    files = tree(whole)
    del files["manifest.json"], files["run.json"], files["croissant.json"]
    assert manifest["sha256"] == files
    labels = Counter(label.type for number in range(10) for label in kitti.read_frame(whole, number).labels)
    assert manifest["counts"] == {"frames": 10, "episodes": 3, "standing": 0, "labels": labels}
    assert manifest["seed"] == 3
    assert (manifest["policy"]["name"], manifest["rig"]["name"]) == ("kitti", "kitti_vlp16")
    # The rig that most episodes have stands there in full, the others by their hash.
    names = [f"kitti{day}_vlp16" for day in ("", "_2011_09_28", "_2011_09_29", "_2011_10_03")]
    assert list(manifest["policy"]["rigs"]) == names
    assert list(manifest["other_rigs"]) == names[1:]
    assert str(whole) not in text
    assert os.uname().nodename not in json.dumps({**manifest, "sha256": None})


def test_two_workers_write_the_same_bytes(whole: Path, tmp_path: Path) -> None:
    assert run(tmp_path / "out", "-n", 10, "--seed", 3, *SIZE, "--workers", 2).returncode == FINE
    assert tree(tmp_path / "out") == tree(whole)


def test_another_seed_writes_other_frames(whole: Path, tmp_path: Path) -> None:
    assert run(tmp_path / "out", "-n", 3, "--seed", 4, *SIZE).returncode == FINE
    ours, theirs = tree(tmp_path / "out"), tree(whole)
    names = [f"training/{folder}/00000{k}" for folder in ("image_2", "velodyne") for k in range(3)]
    assert all(ours[name + suffix(name)] != theirs[name + suffix(name)] for name in names)


def suffix(name: str) -> str:
    return ".png" if "image_2" in name else ".bin"


def test_a_larger_n_moves_no_frame(whole: Path, tmp_path: Path) -> None:
    out = tmp_path / "out"
    assert run(out, "-n", 6, "--seed", 3, *SIZE).returncode == FINE
    before = tree(out)
    done = run(out, "-n", 10, "--seed", 3, *SIZE, "--resume")
    assert done.returncode == FINE
    assert "10 frames (6 were there)" in done.stderr
    after = tree(out)
    assert after == tree(whole)
    assert all(after[name] == digest for name, digest in before.items() if name.startswith("training/"))


@pytest.mark.parametrize("kill_at", ["000001", "000005", "000007"])
def test_after_kill_9_resuming_gives_the_same_bytes(whole: Path, tmp_path: Path, kill_at: str) -> None:
    out = tmp_path / "out"
    with start(out, "-n", 10, "--seed", 3, *SIZE, "--workers", 2, fault="slow=0.5") as process:
        wait_for(out / "training" / "velodyne" / f"{kill_at}.bin", process)
        os.killpg(process.pid, signal.SIGKILL)
    assert not (out / "manifest.json").exists()
    assert run(out, "-n", 10, "--seed", 3, *SIZE, "--resume").returncode == FINE
    assert tree(out) == tree(whole)


def test_a_worker_that_is_killed_is_replaced_and_the_bytes_stay(whole: Path, tmp_path: Path) -> None:
    out = tmp_path / "out"
    with start(out, "-n", 10, "--seed", 3, *SIZE, "--workers", 2, fault="slow=0.5") as process:
        wait_for(out / "training" / "meta" / "000001.json", process)
        os.kill(workers_of(process)[0], signal.SIGKILL)
        _, stderr = process.communicate(timeout=60)
    assert process.returncode == FINE, stderr
    assert re.match(r"a worker died by signal 9 in episode \d: another one continues\n", stderr)
    # Frames that two workers have told of count once.
    assert re.search(r"^10 frames( \(\d were there\))? in ", stderr, re.MULTILINE)
    assert tree(out) == tree(whole)


def test_workers_end_when_their_parent_is_killed(tmp_path: Path) -> None:
    out = tmp_path / "out"
    with start(out, "-n", 2000, *SIZE, "--workers", 2) as process:
        wait_for(out / "training" / "meta" / "000002.json", process)
        process.kill()
        # stdout and stderr close when the last of the processes that share them is gone.
        assert process.communicate(timeout=20) == ("", "")


@pytest.mark.parametrize(
    "damage",
    [
        lambda training: (training / "velodyne" / "000003.bin").write_bytes(b"short"),
        lambda training: (training / "image_2" / "000005.png").unlink(),
        lambda training: (training / "meta" / "000009.json").write_text("{"),
        lambda training: shutil.rmtree(training / "label_2"),
        lambda training: (training.parent / ".partial").mkdir(),
    ],
)
def test_resuming_mends_what_is_damaged(whole: Path, tmp_path: Path, damage: Callable[[Path], object]) -> None:
    out = tmp_path / "out"
    shutil.copytree(whole, out)
    damage(out / "training")
    make(out, 10)
    assert tree(out) == tree(whole)


def test_ctrl_c_while_workers_start_is_answered_afterwards() -> None:
    born = []

    def start_workers() -> None:
        with interrupts_held():
            os.kill(os.getpid(), signal.SIGINT)
            deaf = "import signal; print(signal.SIGINT in signal.pthread_sigmask(signal.SIG_BLOCK, []))"
            born.append(subprocess.run([sys.executable, "-c", deaf], capture_output=True, text=True, check=True))

    with pytest.raises(KeyboardInterrupt):
        start_workers()
    assert [child.stdout for child in born] == ["True\n"]
    assert signal.getsignal(signal.SIGINT) is signal.default_int_handler
    assert signal.SIGINT not in signal.pthread_sigmask(signal.SIG_BLOCK, [])


def test_ctrl_c_ends_cleanly_and_says_how_to_go_on(whole: Path, tmp_path: Path) -> None:
    out = tmp_path / "out"
    with start(out, "-n", 10, "--seed", 3, *SIZE, "--workers", 2, fault="slow=1") as process:
        wait_for(out / "training" / "meta" / "000002.json", process)
        # As a terminal does it: to the whole group, workers included.
        os.killpg(process.pid, signal.SIGINT)
        stdout, stderr = process.communicate(timeout=20)
    assert process.returncode == INTERRUPTED
    assert stdout == ""
    assert stderr.count("\n") == 1
    assert stderr.startswith("interrupted; at least ")
    assert f"frames are whole; go on with: cadet-gen {out} -n 10 --seed 3" in stderr
    assert stderr.endswith("--resume\n")
    assert not (out / ".partial").exists()
    assert run(out, "-n", 10, "--seed", 3, *SIZE, "--resume").returncode == FINE
    assert tree(out) == tree(whole)


@pytest.mark.parametrize("number", [signal.SIGTERM, signal.SIGHUP])
@pytest.mark.parametrize("to_group", [False, True])
def test_a_signal_to_end_is_answered_like_ctrl_c(tmp_path: Path, number: signal.Signals, to_group: bool) -> None:
    out = tmp_path / "out"

    def heed() -> None:
        """Under nohup, SIGHUP is ignored by all that is started."""
        signal.signal(number, signal.SIG_DFL)

    with start(out, "-n", 10, *SIZE, "--workers", 2, fault="slow=1", preexec=heed) as process:
        wait_for(out / "training" / "meta" / "000001.json", process)
        (os.killpg if to_group else os.kill)(process.pid, number)
        _, stderr = process.communicate(timeout=20)
    assert process.returncode == 128 + number
    assert stderr.startswith(f"ended by {number.name}; at least ")
    assert stderr.count("\n") == 1
    assert not (out / ".partial").exists()


def test_a_signal_that_is_ignored_at_the_start_stays_ignored(tmp_path: Path) -> None:
    out = tmp_path / "out"

    def ignore() -> None:
        signal.signal(signal.SIGHUP, signal.SIG_IGN)

    with start(out, "-n", 3, *SIZE, "--workers", 1, fault="slow=0.3", preexec=ignore) as process:
        wait_for(out / "training" / "meta" / "000000.json", process)
        os.killpg(process.pid, signal.SIGHUP)
        process.communicate(timeout=60)
    assert process.returncode == FINE


def test_a_whole_set_that_is_only_to_read_is_resumed(whole: Path, tmp_path: Path) -> None:
    out = tmp_path / "out"
    shutil.copytree(whole, out)
    again = ("-n", 10, "--seed", 3, *SIZE, "--resume")
    done = run(out, *again, fault="readonly")
    assert (done.returncode, done.stderr.count("\n")) == (FINE, 1)
    assert done.stderr.startswith(f"10 frames (10 were there: it was complete) in {out}: ")
    (out / "ImageSets" / "val.txt").write_text("000001\n")
    done = run(out, *again, fault="readonly")
    assert (done.returncode, done.stderr) == (FAILED, f"cadet-gen: {out}/ImageSets/val.txt: Read-only file system\n")


def test_a_new_folder_is_held_before_it_is_looked_into(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    settings = small_settings(1)
    put = LocalSink.put
    refusals: list[str] = []

    def put_late(self: LocalSink, name: str, data: bytes) -> None:
        # Another generator looks at the folder after ours has found it empty and before anything is in it.
        if not refusals:
            with pytest.raises(CadetError) as refused, open_folder(tmp_path / "out", settings, resume=False):
                pass
            refusals.append(str(refused.value))
        put(self, name, data)

    monkeypatch.setattr(LocalSink, "put", put_late)
    with open_folder(tmp_path / "out", settings, resume=False):
        pass
    assert refusals == [f"another cadet-gen is writing to {tmp_path / 'out'}: let it end first"]
    assert sorted(tree(tmp_path / "out")) == ["run.json"]


def test_a_worker_that_says_nothing_is_named(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(local_engine, "SILENCE_S", 0.05)
    monkeypatch.setattr(local_engine, "_POLL_S", 0.05)
    lines: list[str] = []
    generate(tmp_path / "out", small_settings(1), workers=1, on_warning=lines.append)
    # Starting alone takes longer.
    assert lines
    assert re.fullmatch(r"worker \d+ has not answered for \d+ s, in episode 0", lines[0])


def test_two_runs_in_one_folder_do_not_meet(tmp_path: Path) -> None:
    out = tmp_path / "out"
    # The first would take minutes: it goes on, however late the second starts.
    with start(out, "-n", 400, *SIZE, fault="slow=1") as process:
        wait_for(out / "training" / "meta" / "000001.json", process)
        second = run(out, "-n", 400, *SIZE, "--resume")
        assert second.returncode == FAILED
        assert second.stderr == f"cadet-gen: another cadet-gen is writing to {out}: let it end first\n"
        assert process.poll() is None
        os.killpg(process.pid, signal.SIGINT)
        process.communicate(timeout=60)
        assert process.returncode == INTERRUPTED


def test_every_fifth_episode_is_validation(tmp_path: Path) -> None:
    out = tmp_path / "out"
    assert run(out, "-n", 22, *SIZE, "--val-fraction", 0.2).returncode == FINE
    val = (out / "ImageSets" / "val.txt").read_text().split()
    train = (out / "ImageSets" / "train.txt").read_text().split()
    assert val == [f"{number:06d}" for number in range(4, 8)]
    assert train == [f"{number:06d}" for number in [*range(4), *range(8, 22)]]
    assert (out / "ImageSets" / "trainval.txt").read_text().split() == sorted(train + val)


def test_a_set_of_one_episode_has_an_empty_val_file_and_says_so(tmp_path: Path) -> None:
    done = run(tmp_path / "out", "-n", 4, *SIZE)
    assert done.returncode == FINE
    assert (tmp_path / "out" / "ImageSets" / "val.txt").read_text() == ""
    assert done.stderr.endswith("val.txt is empty: validation starts with the second episode, at frame 4\n")


def test_two_episodes_have_a_val_file_and_more_frames_move_none(tmp_path: Path) -> None:
    out = tmp_path / "out"
    done = run(out, "-n", 5, *SIZE)
    assert (done.returncode, "val.txt" in done.stderr) == (FINE, False)
    assert (out / "ImageSets" / "val.txt").read_text().split() == ["000004"]
    splits = {split: (out / "ImageSets" / f"{split}.txt").read_text().split() for split in ("train", "val")}
    assert run(out, "-n", 26, *SIZE, "--resume").returncode == FINE
    for split, ids in splits.items():
        assert set(ids) <= set((out / "ImageSets" / f"{split}.txt").read_text().split())
    val = (out / "ImageSets" / "val.txt").read_text().split()
    assert val == [f"{number:06d}" for number in [*range(4, 8), 24, 25]]


def test_without_a_val_fraction_nothing_is_said_about_it(tmp_path: Path) -> None:
    done = run(tmp_path / "out", "-n", 1, *SIZE, "--val-fraction", 0)
    assert (done.returncode, "val.txt" in done.stderr) == (FINE, False)


def test_val_fraction_changes_the_period(tmp_path: Path) -> None:
    assert run(tmp_path / "out", "-n", 9, *SIZE, "--val-fraction", 0.5).returncode == FINE
    val = (tmp_path / "out" / "ImageSets" / "val.txt").read_text().split()
    assert val == [f"{number:06d}" for number in range(4, 8)]


def test_extras_are_written_on_demand(tmp_path: Path) -> None:
    out = tmp_path / "out"
    assert run(out, "-n", 1, *SIZE, "--write", "depth,semantic").returncode == FINE
    frame = kitti.read_frame(out, 0)
    assert frame.depth is not None and frame.depth.shape == (32, 64)
    assert frame.semantic is not None and len(np.unique(frame.semantic)) > 2
    assert frame.instance is None


def test_more_workers_than_memory_is_said_before_they_start(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    def engine(workers: int, free_gb: float | None) -> None:
        monkeypatch.setattr(run_module, "free_memory_gb", lambda: free_gb)
        run_module._engine("local", str(tmp_path), small_settings(40), workers, None, pytest.fail)

    with pytest.warns(
        CadetWarning, match=r"10 workers take about 3\.7 GB of memory, and 2\.5 GB are free: workers=6 fits"
    ):
        engine(64, 2.5)
    for workers, free_gb in ((4, 2.5), (64, 6.5), (64, None)):
        engine(workers, free_gb)
