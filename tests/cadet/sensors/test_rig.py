from __future__ import annotations

import re
from dataclasses import replace
from pathlib import Path
from typing import Any, cast

import numpy as np
import pytest

import cadet
from cadet import CadetError, Camera, Extrinsics, Lidar, Rig
from cadet.formats.kitti import Calibration
from cadet.formats.kitti.from_sample import calibration_of
from cadet.sensors.lidar import LIDAR_PRESETS
from cadet.sensors.rig import RIG_PRESETS

SHARED = Path(__file__).parents[4] / "shared"

KITTI = Camera.kitti()

# The published calibration of 26 September 2011.
KITTI_P2 = [[721.5377, 0.0, 609.5593, 44.85728], [0.0, 721.5377, 172.854, 0.2163791], [0.0, 0.0, 1.0, 0.002745884]]

PRESETS = Path(cadet.__file__).parent / "sensors" / "presets" / "rigs"


def calibration(rig: Rig) -> Calibration:
    return calibration_of(rig)


def test_the_kitti_rig_has_kittis_projection_and_mount() -> None:
    rig = Rig.kitti()
    calib = calibration(rig)
    np.testing.assert_array_equal(calib.P2, KITTI_P2)
    # P1 is 54 cm to the right of camera 0, so its fourth column is -fx times that.
    assert calib.P1[0, 3] == pytest.approx(-387.5744, abs=1e-4)
    camera0_velo = calib.velo_from_cam @ [0.0, 0.0, 0.0, 1.0]
    np.testing.assert_allclose(camera0_velo[:3], [0.27, 0.0, -0.08], atol=0.01)
    # Camera 0 is 1.65 m over the road, as KITTI's ground planes say.
    assert rig.velo_in_ego_m[2] + camera0_velo[2] == pytest.approx(1.65, abs=0.01)
    # What is ahead, left and above is far, left and high in the image.
    point_cam = calib.cam_from_velo @ [20.0, 3.0, 1.0, 1.0]
    assert point_cam[2] > 19.0
    assert point_cam[0] < 0.0 > point_cam[1]


def test_the_camera_leans_and_looks_up_beside_the_lidar_as_kittis_does() -> None:
    """Pitch 0.60 and roll -0.61 degrees on 26 September: where the LIDAR's up direction is in the cam frame."""
    up_cam = calibration(Rig.kitti()).cam_from_velo[:3, 2]
    assert np.degrees(np.arcsin(up_cam[2])) == pytest.approx(0.60, abs=0.005)
    assert np.degrees(np.arcsin(up_cam[0])) == pytest.approx(-0.61, abs=0.005)


@pytest.mark.parametrize(
    ("name", "frame", "size"),
    [
        ("2011_09_26", "kitti/training/calib/000001.txt", (1242, 375)),
        ("2011_09_28", "kitti/training/calib/000000.txt", (1224, 370)),
        ("2011_09_29", "kitti_dev/training/calib/000015.txt", (1238, 374)),
    ],
)
def test_what_is_written_is_kittis_own_file(name: str, frame: str, size: tuple[int, int]) -> None:
    path = SHARED / frame
    if not path.is_file():
        pytest.skip(f"needs {frame} in ../shared/")
    rig = Rig.kitti(calibration=name)
    assert (rig.camera.width, rig.camera.height) == size
    written = calibration(rig).to_text()
    # Some of the files end without a line break.
    assert written.strip() == path.read_text().strip()
    assert Calibration.from_text(written) == calibration(rig)


def test_the_calibration_of_october_is_the_odometry_benchmarks() -> None:
    """Its files give the product of R0_rect and Tr_velo_to_cam with 12 digits."""
    odometry_cam_from_velo = [
        [4.276802385584e-04, -9.999672484946e-01, -8.084491683471e-03, -1.198459927713e-02],
        [-7.210626507497e-03, 8.081198471645e-03, -9.999413164504e-01, -5.403984729748e-02],
        [9.999738645903e-01, 4.859485810390e-04, -7.206933692422e-03, -2.921968648686e-01],
    ]
    odometry_p3 = [
        [718.856, 0.0, 607.1928, -337.2877],
        [0.0, 718.856, 185.2157, 2.369057],
        [0.0, 0.0, 1.0, 0.004915215],
    ]
    rig = Rig.kitti(calibration="2011_10_03")
    calib = calibration(rig)
    np.testing.assert_allclose(calib.cam_from_velo[:3], odometry_cam_from_velo, atol=3e-7)
    np.testing.assert_array_equal(calib.P3, odometry_p3)
    np.testing.assert_array_equal(calib.P1[0], [718.856, 0.0, 607.1928, -386.1448])
    np.testing.assert_array_equal(calib.P2[:, 3], [45.38225, -0.1130887, 0.003779761])
    assert (rig.camera.width, rig.camera.height) == (1241, 376)


def test_kittis_rigs_differ_in_name_and_share() -> None:
    rigs = Rig.every_kitti()
    assert rigs[0][0] == Rig.kitti()
    assert len({rig.name for rig, _ in rigs}) == 4
    # Frames of the object benchmark's training set by recording day.
    assert [round(7481 * share) for _, share in rigs] == [6057, 770, 358, 296]


def test_a_rig_with_another_sensor_has_another_name() -> None:
    rig = Rig.kitti()
    assert rig.with_lidar(Lidar.vlp16()).name == "kitti_vlp16"
    assert Rig.kitti(calibration="2011_09_28").with_lidar(Lidar.vlp16()).name == "kitti_2011_09_28_vlp16"
    # How the same sensor takes its scans is told beside its name.
    assert rig.with_lidar(Lidar.hdl64e_kitti(rolling=True)).name == "kitti"
    with pytest.raises(CadetError, match=r"^Rig\.lidar: expected a Lidar, got 'vlp16'$"):
        rig.with_lidar("vlp16")  # type: ignore[arg-type]


def test_the_shipped_tools_rig_sees_90_degrees_from_one_point() -> None:
    rig = Rig.cadet()
    calib = calibration(rig)
    camera = rig.camera
    assert (camera.width, camera.height) == (1248, 384)
    # The outer edges of the outer pixels.
    left, right = (-0.5 - camera.cx) / camera.fx, (camera.width - 0.5 - camera.cx) / camera.fx
    assert np.degrees(np.arctan([left, right])) == pytest.approx([-45.0, 45.0])
    assert (camera.fx, camera.cy) == (camera.fy, (384 - 1) / 2)
    np.testing.assert_array_equal(calib.cam_from_velo @ [5.0, 2.0, 1.0, 1.0], [-2.0, -1.0, 5.0, 1.0])
    np.testing.assert_array_equal(calib.P2[:, 3], 0.0)
    assert rig.lidar == Lidar.cadet()
    assert (rig.velo_in_ego_m, rig.velo_roll_pitch_yaw_deg) == ((0.0, 0.0, 1.6), (0.0, 0.0, 0.0))


def test_the_papers_rig_has_one_origin() -> None:
    rig = Rig.paper()
    calib = calibration(rig)
    np.testing.assert_array_equal(calib.P2[:, 3], 0.0)
    np.testing.assert_array_equal(calib.cam_from_velo[:3, 3], 0.0)
    assert rig.lidar.single_origin is True
    assert rig.lidar.name == "hdl64e_kitti"


def test_a_resized_camera_sees_what_a_resized_image_shows() -> None:
    camera = Camera.kitti()
    small = camera.resized(621, 125)
    point = np.array([2.0, 1.0, 9.0, 1.0])
    u, v, w = camera.projection(camera.cam2_from_cam0_m) @ point
    us, vs, ws = small.projection(small.cam2_from_cam0_m) @ point
    # Edges scale: pixel centers lie half a pixel inside.
    assert us / ws + 0.5 == pytest.approx((u / w + 0.5) * 621 / 1242, abs=1e-6)
    assert vs / ws + 0.5 == pytest.approx((v / w + 0.5) * 125 / 375, abs=1e-6)
    assert camera.resized(1242, 375) == camera


def test_a_field_of_view_reaches_from_edge_to_edge() -> None:
    camera = Camera.from_fov(640, 360, horizontal_deg=100.0, rolling_shutter_s=0.02)
    left, right = ((column - camera.cx) / camera.fx for column in (-0.5, 639.5))
    assert np.rad2deg(np.arctan([left, right])) == pytest.approx([-50.0, 50.0], abs=1e-8)
    assert camera.fx == camera.fy and (camera.cx, camera.cy) == (319.5, 179.5)
    assert camera.rolling_shutter_s == 0.02
    assert all((p == camera.projections()["P0"]).all() for p in camera.projections().values()), "it is alone"
    # The principal point of a camera without intrinsics of its own would be KITTI's.
    with pytest.raises(TypeError, match="missing 4 required keyword-only arguments: 'fx', 'fy', 'cx', and 'cy'"):
        Camera(width=100, height=100)  # type: ignore[call-arg]


@pytest.mark.parametrize(
    ("make", "message"),
    [
        (lambda: replace(KITTI, width=0), "Camera.width: expected a whole number from 16 to 8192, got 0"),
        (lambda: replace(KITTI, fx=-1.0), "Camera.fx: expected a number from 1 to 1e+06, got -1.0"),
        (
            lambda: replace(KITTI, cx=float("nan")),
            "Camera.cx: expected a number from -1e+06 to 1e+06, got nan",
        ),
        (
            lambda: Camera.from_fov(640, 480, horizontal_deg=180.0),
            "Camera.horizontal_deg: expected a number from 1 to 175, got 180.0",
        ),
        (
            lambda: Camera.from_fov(640, 4, horizontal_deg=90.0),
            "Camera.height: expected a whole number from 16 to 8192, got 4",
        ),
        (lambda: KITTI.resized(9, 9), "Camera.width: expected a whole number from 16 to 8192, got 9"),
        (
            lambda: Lidar("vlp-16"),
            f"unknown lidar 'vlp-16'; known: {', '.join(LIDAR_PRESETS)}; did you mean 'vlp16'?",
        ),
        (lambda: Rig(lidar=cast(Lidar, "cadet")), "Rig.lidar: expected a Lidar, got 'cadet'"),
        (
            lambda: Rig.kitti(calibration="2011_09_30"),
            "unknown calibration '2011_09_30'; known: 2011_09_26, 2011_09_28, 2011_09_29, 2011_10_03",
        ),
        (
            lambda: Rig.named("velo"),
            "unknown rig 'velo'; known: kitti, paper, cadet, nuscenes, or the path of a file that ends in .toml",
        ),
        (
            lambda: Rig(extrinsics=cast(Extrinsics, None)),
            "Rig.extrinsics: expected an Extrinsics, got None",
        ),
        (
            lambda: Extrinsics(r0_rect=((1.0, 0.0, 0.0), (0.0, 1.0, 0.0), (0.0, 0.0, -1.0))),
            "Extrinsics.r0_rect: expected a rotation in its first three columns, got "
            "((1.0, 0.0, 0.0), (0.0, 1.0, 0.0), (0.0, 0.0, -1.0))",
        ),
        (
            lambda: Extrinsics(r0_rect=cast(Any, ((1.0, 0.0), (0.0, 1.0)))),
            "Extrinsics.r0_rect: expected three rows of 3 numbers, got ((1.0, 0.0), (0.0, 1.0))",
        ),
        (
            lambda: Rig(velo_roll_pitch_yaw_deg=(0.0, 0.0, 181.0)),
            "Rig.velo_roll_pitch_yaw_deg: expected a number from -180 to 180, got 181.0",
        ),
        (lambda: Rig(camera=cast(Camera, None)), "Rig.camera: expected a Camera, got None"),
        (lambda: Rig(velo_in_ego_m=cast(Any, (0.0, 1.7))), "Rig.velo_in_ego_m: expected three numbers, got (0.0, 1.7)"),
    ],
)
def test_nonsense_is_refused_by_name(make: Any, message: str) -> None:
    with pytest.raises(CadetError) as caught:
        make()
    assert str(caught.value) == message


def test_how_a_scan_is_taken_is_checked_and_recorded() -> None:
    lidar = Lidar.hdl64e_kitti(rolling=True, returns="last", divergence_mrad=3)
    assert Lidar(rolling=True) == Lidar.hdl64e_kitti(rolling=True) != Lidar.hdl64e_kitti()
    recorded = Rig(lidar=lidar).to_dict()
    assert (recorded["rolling"], recorded["returns"], recorded["divergence_mrad"]) == (True, "last", 3.0)
    plain = Rig.kitti().to_dict()
    assert (plain["rolling"], plain["returns"], plain["divergence_mrad"]) == (False, "strongest", 0.0)


@pytest.mark.parametrize(
    ("settings", "message"),
    [
        ({"rolling": 1}, "Lidar.rolling: expected True or False, got 1"),
        ({"returns": "loudest"}, "Lidar.returns: expected one of strongest, last, first, dual, triple, got 'loudest'"),
        ({"divergence_mrad": -1.0}, "Lidar.divergence_mrad"),
        ({"divergence_mrad": float("nan")}, "Lidar.divergence_mrad"),
        ({"divergence_mrad": 21}, "Lidar.divergence_mrad"),
    ],
)
def test_impossible_scans_are_refused(settings: dict[str, Any], message: str) -> None:
    with pytest.raises(CadetError, match=message):
        Lidar(**settings)


@pytest.mark.parametrize(
    "old",
    ["origin_in_ego_m = [-1.385", "position_m = [0.943713", "quaternion_wxyz = [0.7077955119163518"]
    + ["width = 1600", "fx = 1266.417203046554", "cx = 816.2670197447984"],
)
def test_endless_numbers_in_a_rigs_file_are_refused(old: str, tmp_path: Path) -> None:
    text = (PRESETS / "nuscenes.toml").read_text()
    name, bracket = re.split(r" = (\[?)", old)[:2]
    assert old in text
    endless = (f"1{'0' * 400}", r"(\[0\])?: a whole number of 401 digits")
    for given, reason in (endless, ("-1e300", "(: value)?: expected a")):
        (tmp_path / "mine.toml").write_text(text.replace(old, f"{name} = {bracket}{given}", 1))
        with pytest.raises(CadetError, match=rf"/mine\.toml: .*{name}{reason}"):
            Rig.read(tmp_path / "mine.toml")


@pytest.mark.parametrize("path", sorted(PRESETS.glob("*.toml")), ids=str)
def test_a_file_is_a_preset(path: Path) -> None:
    assert path.stem in RIG_PRESETS
    assert Rig.named(path.stem) == Rig.read(path) and Rig.named(path.stem).name == path.stem
