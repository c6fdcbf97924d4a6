//! Pictures of posts that pass by, against where each row's moment puts them.

use nalgebra::Matrix3x4;

use super::{cuboid, gray, ground};
use crate::camera::{
    CameraModel, Distortion, Foreground, Maps, Moving, Rendered, SurfaceMapKinds, View, render, render_rolling,
    visibility_pass,
};
use crate::sense::{PosedScene, RigidMotion};
use crate::weather::Weather;
use cadet_base::frames::upright;
use cadet_base::instance::Instance;
use cadet_base::material::Semantic;
use cadet_base::math::{self, DMat3, DPose3, DQuat, DVec3, Vec3};
use cadet_base::rng::Stream;

const POST_ID: i32 = 7;
const READ_OUT_S: f64 = 0.04;
/// Of the post's left side, seen from the front.
const AHEAD_M: f64 = 10.0;
const LEFT_M: f64 = 1.0;

fn camera(distortion: Option<Distortion>) -> CameraModel {
    let projection = Matrix3x4::new(300.0, 0.0, 159.5, 0.0, 0.0, 300.0, 79.5, 0.0, 0.0, 0.0, 1.0, 0.0);
    CameraModel::new(320, 160, projection, distortion).expect("valid").with_rolling_shutter(READ_OUT_S).expect("valid")
}

/// Looks along x from 1.5 m above the ground.
fn world_from_cam() -> DPose3 {
    let axes = DMat3::from_cols(-DVec3::Y, -DVec3::Z, DVec3::X);
    DPose3 { rotation: DQuat::from_mat3(&axes), translation: DVec3::new(0.0, 0.0, 1.5) }
}

fn scene() -> PosedScene {
    let post = cuboid(Vec3::new(10.0, -1.2, -8.0), Vec3::new(10.2, 1.0, 12.0), gray(Semantic::Pole, 0.3), POST_ID);
    // So low that it hides nothing of the post.
    let ground = Instance { world_from_local: upright(DVec3::new(0.0, 0.0, -2.0), 0.0), ..ground() };
    PosedScene::new(&[ground, post], world_from_cam().translation)
}

fn rolled(camera: &CameraModel, ego: RigidMotion, of_post: RigidMotion) -> Rendered {
    let (scene, pose) = (scene(), world_from_cam());
    let motion_of = |id| if id == POST_ID { of_post } else { RigidMotion::default() };
    let foreground = Foreground { warp: camera.warp(), with_radiance: true, ..Default::default() };
    let moving = Moving { scene: &scene, world_from_cam: &pose, camera: ego, motion_of, foreground };
    let weather = Weather::preset("clear_noon").expect("a preset");
    render_rolling(&moving, camera, &weather, Some(&SurfaceMapKinds::default()), &mut Stream::from_seed("camera", 1))
        .expect("an image")
}

/// The column of the first pixel of a row that shows the post, half a pixel to its left.
fn left_side(maps: &Maps, row: usize) -> f64 {
    let line = &maps.instance[row * 320..(row + 1) * 320];
    line.iter().position(|id| *id == POST_ID).expect("the post is in each row") as f64 - 0.5
}

fn to_the_left(speed_m_per_s: f64) -> RigidMotion {
    RigidMotion { velocity_world: DVec3::Y * speed_m_per_s, ..RigidMotion::default() }
}

/// Where the left side is, of a camera that moves to the left: to the right by f v t / z.
fn expected(row: usize, speed_m_per_s: f64) -> f64 {
    let time_s = READ_OUT_S * (row as f64 / 159.0 - 0.5);
    159.5 + 300.0 * (-LEFT_M + speed_m_per_s * time_s) / AHEAD_M
}

/// A pixel's rounding, and half of a band's motion.
const NEAR_PX: f64 = 0.57;

#[test]
fn a_post_leans_as_far_as_the_camera_or_the_post_moves() {
    let still = RigidMotion::default();
    for (ego, of_post, speed) in [(to_the_left(8.0), still, 8.0), (still, to_the_left(8.0), -8.0), (still, still, 0.0)]
    {
        let maps = rolled(&camera(None), ego, of_post).maps.expect("asked for");
        for row in 0..160 {
            let (found, expected) = (left_side(&maps, row), expected(row, speed));
            assert!((found - expected).abs() < NEAR_PX, "{speed} m/s, row {row}: {found} {expected}");
        }
    }
}

#[test]
fn a_camera_that_turns_sees_the_post_lean() {
    let turn = RigidMotion {
        pivot_world: world_from_cam().translation,
        angular_velocity_world: DVec3::Z,
        ..RigidMotion::default()
    };
    let maps = rolled(&camera(None), turn, RigidMotion::default()).maps.expect("asked for");
    for row in 0..160 {
        let angle = math::atan(LEFT_M / AHEAD_M) - READ_OUT_S * (row as f64 / 159.0 - 0.5);
        let (found, expected) = (left_side(&maps, row), 159.5 - 300.0 * math::tan(angle));
        assert!((found - expected).abs() < NEAR_PX, "row {row}: {found} {expected}");
    }
}

#[test]
fn rows_behind_a_lens_have_the_times_of_the_distorted_image() {
    let lens = Distortion::from_opencv([-0.3, 0.09, 0.0, 0.0, 0.0]).expect("distorts");
    let maps = rolled(&camera(Some(lens)), to_the_left(8.0), RigidMotion::default()).maps.expect("asked for");
    for row in 0..160 {
        let slope = (expected(row, 8.0) - 159.5) / 300.0;
        let [x, _] = lens.invert([(left_side(&maps, row) - 159.5) / 300.0, (row as f64 - 79.5) / 300.0]).expect("seen");
        // A pixel of a distorted map is rounded twice.
        assert!(300.0 * (x - slope).abs() < 2.0 * NEAR_PX, "row {row}: {x} {slope}");
    }
}

#[test]
fn what_rests_looks_the_same_under_both_shutters() {
    let (scene, camera) = (scene(), camera(None));
    let view = View::new(&camera, &world_from_cam());
    let seen = visibility_pass(&scene, &view).expect("looks");
    let weather = Weather::preset("clear_noon").expect("a preset");
    let global = render(&scene, &view, &weather, &seen, &mut Stream::from_seed("camera", 1));
    let rolled = rolled(&camera, RigidMotion::default(), RigidMotion::default());
    assert_eq!(rolled.maps, Some(seen.maps(&scene)));
    let differ = global.iter().zip(&rolled.image).filter(|(a, b)| a.abs_diff(**b) > 1).count();
    assert!(differ * 200 < global.len(), "{differ} of {}", global.len());
}

#[test]
fn impossible_shutters_are_refused() {
    for seconds in [-0.01, 0.11, f64::NAN] {
        assert!(camera(None).with_rolling_shutter(seconds).is_err(), "{seconds}");
    }
}

/// Light of a row, green, in shares of the post's and the background's: 0 to the left of the post and 1 on it.
fn shares_of_post(seen: &Rendered, row: usize) -> Vec<f64> {
    let green = |u: usize| f64::from(seen.radiance.as_ref().expect("asked for")[(row * 320 + u) * 3 + 1]);
    let (left, on_post) = (green(100), green(145));
    (100..146).map(|u| (green(u) - left) / (on_post - left)).collect()
}

#[test]
fn an_edge_that_moves_spreads_over_its_way() {
    let still = CameraModel::new(
        320,
        160,
        Matrix3x4::new(300.0, 0.0, 159.5, 0.0, 0.0, 300.0, 79.5, 0.0, 0.0, 0.0, 1.0, 0.0),
        None,
    );
    let still = still.expect("valid");
    let blurred = still.clone().with_motion_blur(0.04).expect("valid");
    let rest = RigidMotion::default();
    // Its way is 300 px 10 m/s 0.04 s / 10 m = 12 px.
    let (sharp, spread) = (rolled(&blurred, rest, rest), rolled(&blurred, rest, to_the_left(10.0)));
    let (sharp_row, spread_row) = (shares_of_post(&sharp, 60), shares_of_post(&spread, 60));
    let between = |row: &[f64]| row.iter().filter(|share| (0.1..0.9).contains(*share)).count();
    assert!(between(&sharp_row) <= 2, "{sharp_row:?}");
    assert!((9..=11).contains(&between(&spread_row)), "{spread_row:?}");
    // The middle of its way is where it is at the frame's time, and light is kept.
    let (a, b): (f64, f64) = (sharp_row.iter().sum(), spread_row.iter().sum());
    assert!((a - b).abs() < 0.7, "{a} {b}");
    // Maps are the instant's.
    assert_eq!(sharp.maps, spread.maps);
    let instant = rolled(&still, rest, rest);
    let same = |u: usize| {
        (sharp.radiance.as_ref().expect("light")[u] - instant.radiance.as_ref().expect("light")[u]).abs() < 1e-4
    };
    assert!((0..320 * 160 * 3).all(same));
}

#[test]
fn impossible_exposures_are_refused() {
    for seconds in [-0.01, 0.06, f64::NAN] {
        assert!(camera(None).with_motion_blur(seconds).is_err(), "{seconds}");
    }
}
