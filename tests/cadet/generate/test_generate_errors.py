"""Every way in which `cadet-gen` fails: one line, and nothing half written."""

from __future__ import annotations

import re
import sys
from pathlib import Path

import pytest

from cadet import ResetPolicy
from cadet.cli import run_cadet_gen
from gen_process import FAILED, FINE, HERE, SIZE, run, tree, write_whole
from small_runs import small_policy


@pytest.fixture(scope="module")
def whole(tmp_path_factory: pytest.TempPathFactory) -> Path:
    return write_whole(tmp_path_factory)


@pytest.mark.parametrize(
    ("fault", "message"),
    [
        ("panic=0", "Panic in episode 0: index out of bounds: the len is 3; at least 0 of 4 frames are whole; go on"),
        ("object=0", "scene: no ground ahead of the camera\n"),
        ("empty", "episode 0: no labeled object in sight in 6 worlds of 10 views each; allow more traffic or labels"),
    ],
)
def test_a_failing_worker_costs_one_line(tmp_path: Path, fault: str, message: str) -> None:
    done = run(tmp_path / "out", "-n", 4, *SIZE, fault=fault)
    assert done.returncode == FAILED
    assert done.stderr.startswith(f"cadet-gen: {message}")
    assert done.stderr.count("\n") == 1
    assert run(tmp_path / "out", "-n", 4, *SIZE, "--resume").returncode == FINE


def test_a_worker_that_dies_again_in_the_same_episode_is_named(tmp_path: Path) -> None:
    out = tmp_path / "out"
    done = run(out, "-n", 10, *SIZE, "--workers", 1, fault="die=1")
    assert done.returncode == FAILED
    first, second = done.stderr.splitlines()
    assert first == "a worker died by signal 9 in episode 1: another one continues"
    assert second.startswith(
        "cadet-gen: a worker died by signal 9 in episode 1, as the one before it did; "
        "at least 4 of 10 frames are whole; go on with: cadet-gen "
    )
    assert (out / "training" / "meta" / "000003.json").exists()
    assert "10 frames (4 were there)" in run(out, "-n", 10, *SIZE, "--resume").stderr


WEATHERS = (
    "clear_noon, cloudy_noon, wet_noon, wet_cloudy_noon, soft_rain_noon, mid_rain_noon, hard_rain_noon, clear_sunset, "
    "cloudy_sunset, wet_sunset, wet_cloudy_sunset, soft_rain_sunset, mid_rain_sunset, hard_rain_sunset, light_fog, "
    "dense_fog, snow, dusk"
)


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        ([], "Missing argument 'OUT'."),
        (["OUT", "-n", "0"], "Invalid value for '-n' / '--num-frames': 0 is not in the range 1<=x<=1000000."),
        (["OUT", "--seed", "x"], "Invalid value for '--seed': 'x' is not a valid integer range."),
        (["OUT", "--workers", "0"], "Invalid value for '--workers': 0 is not in the range 1<=x<=1024."),
        (
            ["OUT", "--policy", "nu"],
            "--policy: unknown policy 'nu'; known: kitti, paper, or the path of a",
        ),
        (["OUT", "--weather", "fog"], "--weather: expected JSON such as {"),
        (["OUT", "--weather", "[]"], "--weather: expected JSON such as {"),
        (["OUT", "--weather", '{"hail": 1}'], "--weather: hail: unknown key"),
        (["OUT", "--weather", "{}", "--weathers", "snow"], "--weather: expected it or --weathers, not both"),
        (
            ["OUT", "--weathers", "hail"],
            f"--weathers: unknown weather 'hail'; known: {WEATHERS}",
        ),
        (["OUT", "--maps", "nix.xodr"], "--maps: unknown map 'nix.xodr': expected an OpenDRIVE file (.xodr)"),
        (["OUT", "--maps", "HERE/conftest.py"], "conftest.py:1: not readable as XML"),
        (["OUT", "--image-size", "0x9"], "--image-size: expected a whole number from 1 to 1000000, got 0"),
        (["OUT", "--val-fraction", "nan"], "--val-fraction: expected a number from 0 to 0.5, got nan"),
        (["OUT", "--image-size", "wide"], "--image-size: expected WxH such as 1242x375, got 'wide'"),
        (["OUT", "--write", "flow"], "--write: cannot write 'flow'; known: depth, instance, semantic"),
        (["HERE"], "HERE is not empty: name a new folder, or go on with --resume"),
        (["HERE", "--resume"], "HERE holds no run to go on with: there is no run.json in it; name a new folder"),
        (["HERE/conftest.py"], "Invalid value for 'OUT': Directory 'HERE/conftest.py' is a file."),
        (["HERE/conftest.py/out"], "HERE/conftest.py/out: Not a directory"),
        (["/proc/out"], "/proc/out: No such file or directory"),
        (["OUT", "--image-size", "8192x8192"], "--image-size: Camera: 8192 x 8192 pixels, expected at most 16777216"),
        (
            ["WHOLE", "-n", "10", "--seed", "3", "--resume"],
            "WHOLE was begun with other settings: rig.camera.height was 32, now 375; give the same ones, or name a new",
        ),
        (
            ["WHOLE", "-n", "10", "--seed", "4", "--image-size", "64x32", "--resume"],
            "WHOLE was begun with other settings: seed was 3, now 4; give the same ones, or name a new folder",
        ),
        (
            [
                "WHOLE",
                "-n",
                "10",
                "--seed",
                "3",
                "--image-size",
                "64x32",
                "--resume",
                "--policy",
                "paper",
                "--rig",
                "kitti",
            ],
            "WHOLE was begun with other settings: policy.blocked_s was 6.0, now 2.0; give the same ones, or name",
        ),
        (
            ["WHOLE", "-n", "9", "--seed", "3", "--image-size", "64x32", "--resume"],
            "WHOLE has frames up to 000009 already: give at least -n 10",
        ),
    ],
)
def test_what_the_user_can_mend_costs_one_line_and_no_file(
    whole: Path,
    tmp_path: Path,
    arguments: list[str],
    message: str,
    monkeypatch: pytest.MonkeyPatch,
    capsys: pytest.CaptureFixture[str],
) -> None:
    places = {"OUT": str(tmp_path / "out"), "HERE": str(HERE), "WHOLE": str(whole)}
    before = tree(whole)
    for name, place in places.items():
        arguments = [argument.replace(name, place) for argument in arguments]
        message = message.replace(name, place) if name != "OUT" else message
    # All of this is found out before a worker starts, so this process may run it.
    monkeypatch.setattr(ResetPolicy, "kitti", small_policy)
    monkeypatch.setattr(sys, "argv", ["cadet-gen", *arguments])
    with pytest.raises(SystemExit) as ended:
        run_cadet_gen()
    assert ended.value.code == FAILED
    stdout, stderr = capsys.readouterr()
    assert stdout == ""
    assert stderr.startswith(f"cadet-gen: {message}")
    assert stderr.count("\n") == 1
    assert not (tmp_path / "out").exists()
    assert tree(whole) == before


def _limit_file_size() -> None:
    import resource

    resource.setrlimit(resource.RLIMIT_FSIZE, (16384, 16384))


def test_a_full_disk_costs_one_line_and_leaves_whole_files(tmp_path: Path) -> None:
    out = tmp_path / "out"
    # An image takes more than the limit, run.json less.
    arguments = (out, "-n", 4, "--image-size", "248x75")
    done = run(*arguments, preexec=_limit_file_size)
    assert done.returncode == FAILED
    assert done.stderr == f"cadet-gen: {out}/training/image_2/000000.png: File too large\n"
    assert sorted(tree(out)) == ["run.json"]
    assert run(*arguments, "--resume").returncode == FINE


def test_a_log_gets_plain_lines(tmp_path: Path) -> None:
    done = run(tmp_path / "out", "-n", 2, *SIZE)
    assert "\x1b" not in done.stderr
    assert done.stderr.startswith(f"2 frames in {tmp_path / 'out'} at ")
    assert re.search(r"/s: (\d+ [A-Z]\w+, )*\d+ [A-Z]\w+\n", done.stderr)
