//! Normals and flows against planes, and against where formulas put moved points.

use nalgebra::Matrix3x4;

use super::{cuboid, gray, ground};
use crate::camera::{CameraModel, Distortion, Motions, SurfaceMapKinds, SurfaceMaps, View, visibility_pass};
use crate::sense::{PosedScene, RigidMotion};
use cadet_base::material::Semantic;
use cadet_base::math::{self, DMat3, DPose3, DQuat, DVec3, Vec3};

const SIZE: (usize, usize) = (320, 160);
const FOCAL_PX: f64 = 300.0;
const CENTER_PX: (f64, f64) = (159.5, 79.5);
const EYE_HEIGHT_M: f64 = 1.5;
const FLOW_S: f64 = 0.1;
/// Of the box's front.
const AHEAD_M: f64 = 10.0;
const BOX_ID: i32 = 7;
const ALL: SurfaceMapKinds = SurfaceMapKinds { normals: true, scene_flow: true, optical_flow_s: Some(FLOW_S) };

fn camera(distortion: Option<Distortion>) -> CameraModel {
    let (cx, cy) = CENTER_PX;
    let projection = Matrix3x4::new(FOCAL_PX, 0.0, cx, 0.0, 0.0, FOCAL_PX, cy, 0.0, 0.0, 0.0, 1.0, 0.0);
    CameraModel::new(SIZE.0, SIZE.1, projection, distortion).expect("valid")
}

/// A box 2 m wide on a level ground, seen along x from [`EYE_HEIGHT_M`].
fn maps(camera: &CameraModel, ego: RigidMotion, of_box: RigidMotion, kinds: &SurfaceMapKinds) -> SurfaceMaps {
    let axes = DMat3::from_cols(-DVec3::Y, -DVec3::Z, DVec3::X);
    let eye = DVec3::new(0.0, 0.0, EYE_HEIGHT_M);
    let world_from_cam = DPose3 { rotation: DQuat::from_mat3(&axes), translation: eye };
    let front = Vec3::new(AHEAD_M as f32, -1.0, 0.0);
    let car = cuboid(front, Vec3::new(14.0, 1.0, 1.2), gray(Semantic::Car, 0.3), BOX_ID);
    let scene = PosedScene::new(&[ground(), car], eye);
    let seen = visibility_pass(&scene, &View::new(camera, &world_from_cam)).expect("a view");
    let of_actor = |id| if id == BOX_ID { of_box } else { RigidMotion::default() };
    seen.surface_maps(&scene, |ray| camera.pixel_of_ray(ray), &Motions { camera: ego, of_actor: &of_actor }, kinds)
}

/// Slopes of a pixel's ray.
fn slopes(u: usize, v: usize) -> (f64, f64) {
    ((u as f64 - CENTER_PX.0) / FOCAL_PX, (v as f64 - CENTER_PX.1) / FOCAL_PX)
}

fn at<T: Copy>(map: &[T], u: usize, v: usize) -> T {
    map[v * SIZE.0 + u]
}

fn close(got: &[f32], want: &[f64], tolerance: f64) {
    let off = got.iter().zip(want).map(|(g, w)| (f64::from(*g) - w).abs()).fold(0.0, f64::max);
    assert!(off < tolerance, "{got:?} {want:?}");
}

/// A pixel of the box's front, of the ground before it, and of the sky.
const ON_BOX: (usize, usize) = (150, 100);
const ON_GROUND: (usize, usize) = (40, 140);
const ON_SKY: (usize, usize) = (20, 10);

#[test]
fn normals_are_those_of_planes_towards_the_camera_and_the_sky_has_none() {
    let rest = RigidMotion::default();
    let normals = maps(&camera(None), rest, rest, &ALL).normal_cam;
    for ((u, v), want) in [(ON_BOX, [0.0, 0.0, -1.0]), (ON_GROUND, [0.0, -1.0, 0.0]), (ON_SKY, [0.0; 3])] {
        close(&at(&normals, u, v), &want, 1e-5);
    }
}

#[test]
fn what_stands_flows_with_the_cameras_motion_alone() {
    // Ahead by 1 m, and to the left by 0.02 rad, about the optical center.
    let (ahead_m, left_rad) = (1.0, 0.02);
    let ego = RigidMotion {
        pivot_world: DVec3::new(0.0, 0.0, EYE_HEIGHT_M),
        velocity_world: DVec3::X * ahead_m / FLOW_S,
        angular_velocity_world: DVec3::Z * left_rad / FLOW_S,
    };
    let found = maps(&camera(None), ego, RigidMotion::default(), &ALL);
    for (u, v, depth_m) in
        [(ON_BOX.0, ON_BOX.1, AHEAD_M), (ON_GROUND.0, ON_GROUND.1, EYE_HEIGHT_M / slopes(ON_GROUND.0, ON_GROUND.1).1)]
    {
        let (x, y) = slopes(u, v);
        // The point as the camera sees it then: moved back, and turned to the right.
        let (right, ahead) = (x * depth_m, depth_m - ahead_m);
        let (sin, cos) = (math::sin(left_rad), math::cos(left_rad));
        let (right, ahead) = (right * cos + ahead * sin, ahead * cos - right * sin);
        let want = [FOCAL_PX * (right / ahead - x), FOCAL_PX * (y * depth_m / ahead - y)];
        assert!(want[0].abs() > 3.0);
        close(&at(&found.flow_px, u, v), &want, 1e-3);
        assert_eq!(at(&found.velocity_cam_m_per_s, u, v), [0.0; 3]);
    }
    assert!(at(&found.flow_px, ON_SKY.0, ON_SKY.1)[0].is_nan());
}

#[test]
fn what_moves_has_its_velocity_and_flows_with_it() {
    // To the left at 5 m/s, and turning about its front's middle.
    let of_box = RigidMotion {
        pivot_world: DVec3::new(AHEAD_M, 0.0, 0.0),
        velocity_world: DVec3::new(0.0, 5.0, 0.0),
        angular_velocity_world: DVec3::Z * 0.5,
    };
    let found = maps(&camera(None), RigidMotion::default(), of_box, &ALL);
    let (u, v) = ON_BOX;
    let (x, _) = slopes(u, v);
    // The camera's x axis is to the right, its z axis ahead; a point right of the pivot is turned ahead.
    let right_m = x * AHEAD_M;
    close(&at(&found.velocity_cam_m_per_s, u, v), &[-5.0, 0.0, 0.5 * right_m], 1e-5);
    let (sin, cos) = (math::sin(0.5 * FLOW_S), math::cos(0.5 * FLOW_S));
    let (right, ahead) = (right_m * cos - 5.0 * FLOW_S, AHEAD_M + right_m * sin);
    close(&at(&found.flow_px, u, v)[..1], &[FOCAL_PX * (right / ahead - x)], 1e-3);
    close(&at(&found.flow_px, ON_GROUND.0, ON_GROUND.1), &[0.0, 0.0], 1e-6);
}

#[test]
fn flow_is_that_of_the_bent_image_and_what_comes_behind_the_camera_has_none() {
    let lens = camera(Distortion::from_opencv([-0.3, 0.1, 0.0, 0.0, 0.0]));
    let ahead_m = 2.0;
    let ego = RigidMotion { velocity_world: DVec3::X * ahead_m / FLOW_S, ..RigidMotion::default() };
    let rest = RigidMotion::default();
    let warp = lens.warp().expect("a lens");
    let found = maps(&lens, ego, rest, &ALL).through(warp);
    let (u, v) = ON_BOX;
    let flow = at(&found.flow_px, u, v);
    // Of the nearest pixel before the lens.
    let depth_m = AHEAD_M;
    let start = slopes(u, v);
    let straight = (0..50).fold(start, |(x, y), _| {
        let r2 = x * x + y * y;
        let factor = 1.0 - 0.3 * r2 + 0.1 * r2 * r2;
        (start.0 / factor, start.1 / factor)
    });
    let bent = |x: f64, y: f64| {
        let r2 = x * x + y * y;
        let factor = 1.0 - 0.3 * r2 + 0.1 * r2 * r2;
        [FOCAL_PX * x * factor, FOCAL_PX * y * factor]
    };
    let nearer = depth_m / (depth_m - ahead_m);
    let (before, after) = (bent(straight.0, straight.1), bent(straight.0 * nearer, straight.1 * nearer));
    close(&flow, &[after[0] - before[0], after[1] - before[1]], 0.15);

    let past = RigidMotion { velocity_world: DVec3::X * 11.0 / FLOW_S, ..rest };
    assert!(at(&maps(&camera(None), past, rest, &ALL).flow_px, u, v)[0].is_nan());
}

#[test]
fn maps_that_nobody_asked_for_are_empty() {
    let rest = RigidMotion::default();
    assert_eq!(maps(&camera(None), rest, rest, &SurfaceMapKinds::default()), SurfaceMaps::default());
    let some = SurfaceMapKinds { normals: true, ..SurfaceMapKinds::default() };
    let found = maps(&camera(None), rest, rest, &some);
    assert_eq!((found.normal_cam.len(), found.flow_px.len()), (SIZE.0 * SIZE.1, 0));
}
