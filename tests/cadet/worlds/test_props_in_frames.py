"""A user's own props in generated towns: placed and seen, and bad ones refused in one line."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

import cadet
from cadet.cli import run_cadet_gen

# Retro-reflective pillars, more than there is of signs otherwise.
PILLAR = """levels_m = [60, 90, 200]
semantic = "traffic_sign"
let = "h = range(2.2, 2.4)"
parts = [{ of = "film", block = "0.4, 0.4, h", at = "0, 0, h / 2" }]

[materials]
film = { color = [0.7, 0.7, 0.1], reflectance = 0.9, retro = 1 }

[[place]]
where = "sidewalk"
every_m = 5
"""


def folder_of(root: Path, text: str) -> Path:
    root.mkdir()
    (root / "own-pillar.toml").write_text(text)
    return root


def test_a_users_prop_stands_in_the_town_and_is_seen(tmp_path: Path) -> None:
    props = cadet.Props.read(folder_of(tmp_path / "own", PILLAR))
    policy = cadet.ResetPolicy.kitti()
    num_pixels, num_returns = np.zeros(2), np.zeros(2)
    for seed in range(4):
        for k, chosen in enumerate((policy, policy.with_props(props))):
            scene = cadet.Scene.random(seed=seed, policy=chosen)
            frame, scan = scene.capture(), scene.scan()
            assert frame.semantic is not None
            num_pixels[k] += np.count_nonzero(frame.semantic == cadet.Semantic.TRAFFIC_SIGN)
            num_returns[k] += np.count_nonzero(scan.points_velo[:, 3] > 0.98)
    assert num_pixels[1] > 2 * num_pixels[0] + 1000, num_pixels
    assert num_returns[1] > num_returns[0] + 200, num_returns


def test_no_props_are_the_same_bytes_as_props_that_stand_nowhere_near(tmp_path: Path) -> None:
    far = PILLAR.replace("every_m = 5", "every_m = 1e5")
    policy = cadet.ResetPolicy.kitti()
    one, other = (
        cadet.Scene.random(seed=3, policy=chosen)
        for chosen in (policy, policy.with_props(cadet.Props.read(folder_of(tmp_path / "own", far))))
    )
    np.testing.assert_array_equal(one.capture().image, other.capture().image)
    np.testing.assert_array_equal(one.scan().points_velo, other.scan().points_velo)


def test_a_bad_prop_is_one_line_before_anything_is_written(
    tmp_path: Path, capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch
) -> None:
    bad = folder_of(tmp_path / "bad", PILLAR.replace("0.4, 0.4, h", "0.4, 0.4, hight"))
    monkeypatch.setattr("sys.argv", ["cadet-gen", str(tmp_path / "out"), "-n", "2", "--props", str(bad)])
    with pytest.raises(SystemExit) as ended:
        run_cadet_gen()
    assert ended.value.code == 2
    reason = 'own-pillar.toml:4: unknown name "hight"; known here: variant, level, near, mid, far, length, h'
    assert capsys.readouterr().err == f"cadet-gen: --props: {reason}\n"
    assert not (tmp_path / "out").exists()
