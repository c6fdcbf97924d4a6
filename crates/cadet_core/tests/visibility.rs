//! The visibility kernel against single rays, and against what closed forms say.
#![allow(missing_docs, clippy::print_stderr)]

mod common;

use common::{Agreement, compare, cuboid, place, posed, random_rotation, random_scene, soup, sphere};

use cadet_core::math::{self, DPose3, DQuat, DVec3, TAU, Vec3};
use cadet_core::rng::Stream;
use cadet_core::sense::{BeamGrid, Hits, LaserRing, NO_HIT, PinholeGrid, SpinningGrid, SurfaceFilter, cast};
use proptest::prelude::*;

/// Rings from `top` to `bottom` degrees with heights that fall as the HDL-64E's do.
fn spinning(pose: DPose3, rings: usize, top: f64, bottom: f64, heights: [f64; 2], columns: usize) -> SpinningGrid {
    let ring = |i: usize| {
        let t = i as f64 / (rings.max(2) - 1) as f64;
        LaserRing {
            elevation_rad: math::lerp(top, bottom, t).to_radians(),
            height_m: if t < 0.5 { heights[0] } else { heights[1] },
            left_m: [0.3, -0.2][i % 2] * (heights[0] - heights[1]),
        }
    };
    let azimuths: Vec<f64> = (0..columns).map(|j| j as f64 * TAU / columns as f64).collect();
    SpinningGrid::new(pose, &(0..rings).map(ring).collect::<Vec<_>>(), &azimuths).expect("a valid spinning")
}

fn pinhole(pose: DPose3) -> PinholeGrid {
    PinholeGrid::new(pose, [721.5, 721.5, 609.6, 172.9], [0.0, 0.0, 4.0, 4.0], 94, 311).expect("a valid camera")
}

fn assert_agrees(what: &str, agreement: &Agreement) {
    eprintln!("{what}: {agreement:?}");
    let rate = 1.0 - agreement.disagreements as f64 / agreement.beams as f64;
    assert!(rate >= 0.9999, "{what}: {rate} {agreement:?}");
    assert!(agreement.farthest_from_edge_rad < 1e-8, "{what}: {agreement:?}");
}

#[test]
fn spinning_grids_agree_with_single_rays_on_random_scenes() {
    for seed in 0..6 {
        let mut s = Stream::from_seed("turret scenes", seed);
        let center = DVec3::new(s.range(-400.0, 400.0), s.range(-400.0, 400.0), s.range(-5.0, 30.0));
        let scene = posed(&random_scene(&mut s, center));
        let tilt = DQuat::from_rotation_x(s.normal() * 0.03) * DQuat::from_rotation_z(s.range(0.0, TAU));
        let pose = DPose3 { rotation: tilt, translation: center };
        assert_agrees("kitti-like", &compare(&scene, &spinning(pose, 64, 2.0, -25.0, [0.205, 0.12], 521)));
        assert_agrees("wide", &compare(&scene, &spinning(pose, 48, 80.0, -85.0, [0.1, -0.1], 180)));
        assert_agrees("reversed", &compare(&scene, &spinning(pose, 33, -30.0, 15.0, [-0.1, 0.3], 77)));
        let any = DPose3 { rotation: random_rotation(&mut s), translation: center };
        assert_agrees("turned over", &compare(&scene, &spinning(any, 40, 60.0, -60.0, [0.0, 0.0], 128)));
    }
}

#[test]
fn cameras_agree_with_single_rays_on_random_scenes() {
    for seed in 0..6 {
        let mut s = Stream::from_seed("camera scenes", seed);
        let center = DVec3::new(s.range(-400.0, 400.0), s.range(-400.0, 400.0), s.range(-5.0, 30.0));
        let scene = posed(&random_scene(&mut s, center));
        for _ in 0..3 {
            let pose = DPose3 { rotation: random_rotation(&mut s), translation: center };
            assert_agrees("camera", &compare(&scene, &pinhole(pose)));
        }
    }
}

proptest! {
    #![proptest_config(ProptestConfig { cases: 4000, failure_persistence: None, ..ProptestConfig::default() })]

    /// Wherever the sphere lies, the plane through the camera and what is behind it included.
    #[test]
    fn a_sphere_is_looked_for_where_any_of_it_is_seen(
        row in 0_usize..94, column in 0_usize..311, depth in 0.01_f64..60.0, radius in 0.01_f64..30.0, seed in 0_u64..1_000_000,
    ) {
        let (grid, mut s) = (pinhole(DPose3::IDENTITY), Stream::from_seed("sphere", seed));
        let seen = grid.beam(row, column).direction_world * depth;
        let center = seen + random_rotation(&mut s) * DVec3::new(0.999 * radius, 0.0, 0.0);
        let ([window, _], near_depth) = grid.sphere_windows(center.as_vec3(), radius as f32);
        prop_assert!(window.rows.contains(&row) && window.columns.contains(&column), "{center} {radius}: {window:?}");
        prop_assert!(f64::from(near_depth) < depth);
    }
}

proptest! {
    #![proptest_config(ProptestConfig { cases: 24, failure_persistence: None, ..ProptestConfig::default() })]

    #[test]
    fn triangle_soups_agree_with_single_rays(seed in 0_u64..1_000_000, n in 1_usize..300, far in any::<bool>()) {
        let mut s = Stream::from_seed("soup", seed);
        let center = if far { DVec3::new(300.0, -250.0, 10.0) } else { DVec3::ZERO };
        let scene = posed(&[soup(&mut s, n, 12.0, center)]);
        let pose = DPose3 { rotation: random_rotation(&mut s), translation: center };
        assert_agrees("soup, spinning", &compare(&scene, &spinning(pose, 40, 70.0, -70.0, [0.2, 0.1], 90)));
        assert_agrees("soup, camera", &compare(&scene, &pinhole(pose)));
    }

    #[test]
    fn no_beam_leaves_a_closed_mesh(seed in 0_u64..1_000_000, rings in 3_u32..40, radius in 0.5_f32..80.0) {
        let mut s = Stream::from_seed("closed", seed);
        let center = DVec3::new(s.range(-400.0, 400.0), s.range(-400.0, 400.0), 0.0);
        let around = DPose3 { rotation: random_rotation(&mut s), translation: center };
        let scene = posed(&[place(sphere(radius, rings), around, 1)]);
        let inside = DVec3::new(s.normal(), s.normal(), s.normal()).normalize() * f64::from(radius) * 0.4;
        let pose = DPose3 { rotation: random_rotation(&mut s), translation: center + inside };
        let grid = spinning(pose, 60, 88.0, -88.0, [0.0, 0.0], 360);
        let mut hits = Hits::new(grid.rows(), grid.columns());
        cast(&scene, &grid, SurfaceFilter::All, |_| true, &mut hits);
        prop_assert!(hits.depth_m.iter().all(|d| d.is_finite()));
        let grid = pinhole(pose);
        cast(&scene, &grid, SurfaceFilter::All, |_| true, &mut hits);
        prop_assert!(hits.depth_m.iter().all(|d| d.is_finite()));
        // Corners lie on the sphere, so every hit lies between it and the sphere through the faces' middles.
        let pitch = math::PI / f64::from(rings);
        let least = f64::from(radius) * math::cos(pitch.min(1.0) / 1.2) * math::cos(pitch.min(1.0) / 1.2) - 1e-3;
        for row in 0..grid.rows() {
            for column in 0..grid.columns() {
                let beam = grid.beam(row, column);
                let depth = f64::from(hits.depth_m[row * grid.columns() + column]);
                let r = (beam.origin_world + beam.direction_world * depth - center).length();
                prop_assert!(r <= f64::from(radius) * (1.0 + 1e-6) + 1e-4, "{r} {radius}");
                prop_assert!(r >= least, "{r} {least} {radius} {rings}");
            }
        }
    }
}

#[test]
fn ranges_to_a_plane_are_the_closed_form() {
    // z = -1.73 below the frame's origin: range = (1.73 + h) / -sin(elevation).
    let ground = place(cuboid(Vec3::new(400.0, 400.0, 0.5)), common::at(0.0, 0.0, -2.23), 0);
    let scene = posed(&[ground]);
    let grid = spinning(DPose3::IDENTITY, 64, 2.0, -25.0, [0.2, 0.12], 720);
    let mut hits = Hits::new(grid.rows(), grid.columns());
    cast(&scene, &grid, SurfaceFilter::All, |_| true, &mut hits);
    for row in 0..64 {
        let t = row as f64 / 63.0;
        let elevation = math::lerp(2.0, -25.0, t).to_radians();
        let h = if t < 0.5 { 0.2 } else { 0.12 };
        let expected = (f64::from(1.73_f32) + h) / -math::sin(elevation);
        for column in 0..720 {
            let got = f64::from(hits.depth_m[row * 720 + column]);
            if elevation >= 0.0 {
                assert!(got.is_infinite());
            } else if expected < 399.0 {
                assert!((got - expected).abs() < 1e-5 * expected.max(10.0), "{got} {expected}");
            }
        }
    }
}

#[test]
fn a_wall_in_the_camera_has_its_depth_and_its_edges() {
    // Camera at the origin looking along world x; a wall 10 m ahead from y = -2 to 1 (right to left), z = -1 to 3.
    let wall = place(cuboid(Vec3::new(0.25, 1.5, 2.0)), common::at(10.25, -0.5, 1.0), 7);
    let scene = posed(&[wall]);
    let axes = cadet_core::frames::cam_axes_from_velo_axes().transpose();
    let pose = DPose3 { rotation: DQuat::from_mat3(&axes), translation: DVec3::ZERO };
    let grid = PinholeGrid::new(pose, [100.0, 100.0, 50.0, 50.0], [0.0, 0.0, 1.0, 1.0], 100, 100).expect("valid");
    let mut hits = Hits::new(100, 100);
    cast(&scene, &grid, SurfaceFilter::All, |i| i.actor_id == 7, &mut hits);
    for row in 0..100 {
        for column in 0..100 {
            let (x, y) = ((column as f64 - 50.0) / 10.0, (row as f64 - 50.0) / 10.0);
            let inside = x > -0.999 && x < 1.999 && y > -2.999 && y < 0.999;
            let outside = !(-1.001..=2.001).contains(&x) || !(-3.001..=1.001).contains(&y);
            let i = row * 100 + column;
            if inside {
                assert!((hits.depth_m[i] - 10.0).abs() < 1e-5 && hits.instance[i] == 0);
            } else if outside {
                assert!(hits.depth_m[i].is_infinite() && hits.instance[i] == NO_HIT && hits.face[i] == NO_HIT);
            }
        }
    }
    hits.clear();
    cast(&scene, &grid, SurfaceFilter::All, |i| i.actor_id != 7, &mut hits);
    cast(&scene, &grid, SurfaceFilter::Transparent, |_| true, &mut hits);
    assert!(hits.depth_m.iter().all(|d| d.is_infinite()));
}

#[test]
fn equal_depths_go_to_the_earlier_instance() {
    let at = |id| place(cuboid(Vec3::splat(1.0)), common::at(10.0, 0.0, 0.0), id);
    let grid = spinning(DPose3::IDENTITY, 16, 5.0, -5.0, [0.0, 0.0], 720);
    let mut hits = Hits::new(16, 720);
    cast(&posed(&[at(3), at(2), at(1)]), &grid, SurfaceFilter::All, |_| true, &mut hits);
    assert!(hits.instance.contains(&0));
    assert!(hits.instance.iter().all(|i| *i == 0 || *i == NO_HIT));
}
