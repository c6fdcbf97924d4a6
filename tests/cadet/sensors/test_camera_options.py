"""What users may change of a camera: exposure, noise, white balance, and response, and the light before them."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from numpy.typing import NDArray

import cadet
from cadet import Camera, Lidar, MountedCamera, Pose, Rig, Scene
from cadet.generate import Settings, generate

LENS = Camera(width=400, height=200, fx=300.0, fy=300.0, cx=199.5, cy=99.5)
CURVE = ((0.0, 0.0), (0.2, 0.5), (1.0, 1.0))


def rig(**options: Any) -> Rig:
    return Rig(camera=replace(LENS, **options), lidar=Lidar.vlp16(), extrinsics=cadet.Extrinsics.aligned())


def seen(**options: Any) -> cadet.Frame:
    """A square with cars, by a camera with these options: the same light for all of them."""
    scene = Scene.empty(rig=rig(**options))
    for k in range(4):
        scene.add("car", x_m=10.0 + 5 * k, y_m=3.0 - 2.2 * k, yaw_rad=0.4 * k, model_seed=k)
    return scene.capture(more_maps=["radiance"])


def light(frame: cadet.Frame) -> NDArray[np.float64]:
    assert frame.radiance is not None
    return frame.radiance.astype(np.float64)


def smooth(frame: cadet.Frame) -> NDArray[np.bool_]:
    """Find the pixels whose color filters see nearly one light."""
    values = light(frame)
    padded = np.pad(values, ((1, 1), (1, 1), (0, 0)), mode="edge")
    height, width = values.shape[:2]
    shifts = [padded[r : r + height, c : c + width] for r in range(3) for c in range(3)]
    return np.asarray((np.max(shifts, axis=0) - np.min(shifts, axis=0)).max(axis=2) < 0.006)


def srgb(share: NDArray[np.float64]) -> NDArray[np.float64]:
    """IEC 61966-2-1."""
    share = np.clip(share, 0.0, 1.0)
    return np.where(share <= 0.0031308, 12.92 * share, 1.055 * share ** (1 / 2.4) - 0.055)


def test_values_follow_the_light_by_the_response() -> None:
    curves: dict[Any, Callable[[NDArray[np.float64]], NDArray[np.float64]]] = {
        "linear": lambda share: np.clip(share, 0.0, 1.0),
        "srgb": srgb,
        CURVE: lambda share: np.interp(share, *np.transpose(CURVE)),
    }
    for response, value in curves.items():
        frame = seen(response=response, noise=0.0)
        flat = smooth(frame)
        assert flat.sum() > 2000 and np.ptp(light(frame)[flat]) > 0.1
        off = np.abs(frame.image - 255.0 * value(light(frame)))[flat]
        # Rounding, and what the filters of neighbors mix.
        assert np.percentile(off, 99) < 3.0 and np.median(off) < 0.6, response


def test_the_meter_aims_at_middle_gray_behind_a_curve() -> None:
    """18 % of white, half of what KITTI's images have; what is clipped counts as white."""
    plain, bent = light(seen()), light(seen(response="srgb"))
    factor = np.median(bent / plain)
    np.testing.assert_allclose(bent, plain * factor, rtol=1e-4)
    luma = np.minimum(bent, 1.0) @ [0.2126, 0.7152, 0.0722]
    assert luma.mean() == pytest.approx(0.18, abs=0.025)
    assert 0.4 < factor < 0.51


def test_exposure_and_white_balance_are_factors_of_the_light() -> None:
    plain = light(seen())
    np.testing.assert_allclose(light(seen(exposure_ev=-2.0)), plain / 4.0, rtol=1e-5)
    balanced = light(seen(white_balance=(0.5, 1.0, 2.0)))
    np.testing.assert_allclose(balanced, plain * [0.5, 1.0, 2.0], rtol=1e-5)
    dark, bright = seen(exposure_ev=-2.0), seen(exposure_ev=1.0)
    assert dark.image.mean() < 0.3 * seen().image.mean() < 0.3 * bright.image.mean()


def test_noise_has_the_deviation_that_is_asked_for() -> None:
    """Read-out and photons as measured of KITTI's cameras (`camera/sensor/noise.rs`), times the factor."""
    still = seen(noise=0.0)
    flat = smooth(still) & (light(still).max(axis=2) < 0.9)
    deviations = {}
    for factor in (0.0, 1.0, 3.0):
        frame = seen(noise=factor)
        np.testing.assert_array_equal(light(frame), light(still))
        off = (frame.image.astype(np.float64) - 255.0 * light(frame))[flat]
        deviations[factor] = off[:, 1].std()
    value = 255.0 * light(still)[flat][:, 1].mean()
    expected = np.sqrt(0.3 + 0.018 * value)
    assert deviations[0.0] < 0.5
    assert deviations[1.0] == pytest.approx(np.hypot(expected, deviations[0.0]), rel=0.1)
    assert deviations[3.0] == pytest.approx(np.hypot(3 * expected, deviations[0.0]), rel=0.1)


def test_the_usual_options_change_no_byte_and_no_manifest() -> None:
    usual = {
        "motion_blur_s": 0.0,
        "exposure_ev": 0.0,
        "noise": 1.0,
        "white_balance": (1.0, 1.0, 1.0),
        "response": "linear",
    }
    np.testing.assert_array_equal(seen().image, seen(**usual).image)
    mounted = MountedCamera(name="rear", camera=LENS, pose=Pose.of_camera((0.0, 0.0, 1.5)))
    assert not {"noise", "response"} & {
        *rig().with_sensors(mounted).to_dict()["more"]["rear"]["camera"],
        *rig().to_dict(),
    }
    changed = replace(LENS, noise=0.0, response=CURVE)
    assert changed.unusual() == {"noise": 0.0, "response": [[0.0, 0.0], [0.2, 0.5], [1.0, 1.0]]}
    assert replace(mounted, camera=changed).to_dict()["camera"]["noise"] == 0.0
    assert "noise=0.0" in repr(changed) and "white_balance" not in repr(changed)


def test_rig_files_have_the_same_options(tmp_path: Path) -> None:
    options = {"motion_blur_s": 0.01, "exposure_ev": -1.0, "noise": 0.5, "white_balance": (1.1, 1.0, 0.9)}
    for response in ("srgb", CURVE):
        first = rig(**options, response=response)
        pose = Pose.of_camera((0.0, 0.0, 1.5))
        of = first.with_sensors(MountedCamera(name="rear", camera=first.camera, pose=pose))
        (tmp_path / "rig.toml").write_text(of.to_toml())
        assert Rig.read(tmp_path / "rig.toml") == of
    text = (tmp_path / "rig.toml").read_text()
    (tmp_path / "bad.toml").write_text(text.replace("noise = 0.5", "noise = -0.5", 1))
    with pytest.raises(cadet.CadetError, match=r"bad.toml.*Camera.noise: expected a number from 0 to 16, got -0.5"):
        Rig.read(tmp_path / "bad.toml")


@pytest.mark.parametrize(
    ("options", "message"),
    [
        ({"exposure_ev": 9.0}, "Camera.exposure_ev: expected a number from -8 to 8, got 9.0"),
        ({"motion_blur_s": 0.06}, "Camera.motion_blur_s: expected a number from 0 to 0.05, got 0.06"),
        ({"noise": -0.1}, "Camera.noise: expected a number from 0 to 16"),
        ({"noise": "none"}, "Camera.noise: expected a number from 0 to 16"),
        ({"white_balance": (1.0, 0.0, 1.0)}, "Camera.white_balance: expected a number from 0.125 to 8, got 0.0"),
        ({"white_balance": 1.0}, "Camera.white_balance: expected three numbers, got 1.0"),
        ({"response": "gamma"}, 'Camera.response: expected "linear", "srgb", or points'),
        ({"response": ((0.0, 0.0), (0.5, 0.6), (0.5, 0.7), (1.0, 1.0))}, "Camera.response: expected"),
        ({"response": ((0.0, 0.1), (1.0, 1.0))}, "Camera.response: expected"),
        ({"response": ((0.0, 0.0), (2.0, 1.0))}, "Camera.response: expected a number from 0 to 1, got 2.0"),
    ],
)
def test_options_out_of_range_are_refused(options: dict[str, Any], message: str) -> None:
    with pytest.raises(cadet.CadetError, match=message):
        replace(LENS, **options)


def test_radiance_is_written_in_16_bit(tmp_path: Path) -> None:
    policy = cadet.ResetPolicy.kitti().with_rig(Rig.kitti().with_image_size(310, 94))
    generate(tmp_path, Settings(seed=2, num_frames=1, policy=policy, write=("radiance",)), workers=1)
    assert cadet.kitti.lint(tmp_path) == []
    env = cadet.Environment(policy=policy, more_maps=["radiance"])
    env.reset(seed=2)
    ours, read = env.step().radiance, cadet.kitti.read_frame(tmp_path, 0).radiance
    assert ours is not None and read is not None and ours.max() > 1.0
    np.testing.assert_allclose(read, np.minimum(ours, 65535 / 4096), atol=0.5001 / 4096)


def test_what_crosses_is_blurred_along_its_way_and_what_stands_is_not() -> None:
    """12 m/s 14 m ahead is 300 * 12 * 0.02 / 14 = 5 pixels in 20 ms: edges are less steep, and in place."""
    images = {}
    for motion_blur_s in (0.0, 0.02):
        scene = Scene.empty(rig=rig(motion_blur_s=motion_blur_s, noise=0.0))
        scene.add("car", x_m=14.0, y_m=-1.0, yaw_rad=1.57, model_seed=1, speed_mps=12.0)
        scene.add("car", x_m=14.0, y_m=4.5, yaw_rad=1.57, model_seed=1)
        images[motion_blur_s] = scene.capture(more_maps=["radiance"])
    sharp, blurred = images[0.0], images[0.02]
    assert sharp.labels == blurred.labels and sharp.instance is not None
    np.testing.assert_array_equal(sharp.instance, blurred.instance)
    steep = {}
    for actor_id in (1, 2):
        rows, columns = np.nonzero(sharp.instance == actor_id)
        window = (slice(rows.min(), rows.max()), slice(columns.min() - 8, columns.max() + 8))
        steep[actor_id] = [np.abs(np.diff(light(one)[window], axis=1)).max(axis=2).mean() for one in (sharp, blurred)]
    assert steep[1][1] < 0.75 * steep[1][0]
    assert steep[2][1] == pytest.approx(steep[2][0], rel=0.05)


def test_lenses_and_rolling_shutters_keep_image_and_light_together() -> None:
    for options in ({"distortion": (-0.2, 0.05, 0.0, 0.0, 0.0)}, {"rolling_shutter_s": 0.002}):
        frame = seen(**options, noise=0.0)
        flat = smooth(frame)
        off = np.abs(frame.image - 255.0 * np.clip(light(frame), 0.0, 1.0))[flat]
        assert flat.sum() > 2000 and np.percentile(off, 99) < 3.0, options
