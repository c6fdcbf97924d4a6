//! Things thinner than a pixel show as much as in a picture of thirty-six times as many pixels, and do not flicker.

use std::sync::Arc;

use crate::camera::{View, visibility_pass};
use crate::sense::PosedScene;
use cadet_assets::props::{ARM_LAMP, LAMP, NAME_SIGN, PICKET, RAILING, ROUND_SIGN, WIRE};
use cadet_assets::scenery::SceneryModel;
use cadet_base::frames::upright;
use cadet_base::geometry::LodSet;
use cadet_base::instance::Instance;
use cadet_base::math::{DMat3, DPose3, DQuat, DVec3};

/// Of KITTI's camera.
const FOCAL_PX: f64 = 721.5;
const SIZE: (usize, usize) = (192, 288);
const FINER: usize = 6;

/// What of a thing is looked at.
#[derive(Clone, Copy)]
enum Part {
    /// Stretches of rows.
    All,
    /// The part that is higher than this above the ground, meters; stretches of columns.
    Above(f64),
}

/// How much of an actor is seen in each stretch of rows or columns, in pixels of KITTI's camera.
fn shown(instance: &Instance, eye: DVec3, finer: usize, of: Part) -> Vec<f64> {
    let axes = DMat3::from_cols(-DVec3::Y, -DVec3::Z, DVec3::X);
    let world_from_cam = DPose3 { rotation: DQuat::from_mat3(&axes), translation: eye };
    let (width, height, scale) = (SIZE.0 * finer, SIZE.1 * finer, finer as f64);
    let intrinsics = [FOCAL_PX * scale, FOCAL_PX * scale, scale * SIZE.0 as f64 / 2.0, scale * SIZE.1 as f64 * 0.7];
    let posed = PosedScene::new(std::slice::from_ref(instance), eye);
    let seen = visibility_pass(&posed, &View { intrinsics_px: intrinsics, width, height, world_from_cam }).unwrap();
    // So many pixels are taken together: some bars of a fence.
    let stretch = if matches!(of, Part::All) { 8 } else { 24 };
    let step = stretch * finer;
    let distance_m = instance.world_from_local.translation.x;
    let row_at = |z: f64| (intrinsics[3] + intrinsics[1] * (eye.z - z) / distance_m).round() as usize;
    let samples = |i: usize| {
        let along = i * step..(i + 1) * step;
        // There are two rows of samples for each of pixels.
        match of {
            Part::All => seen.samples_of_actor(1, 2 * along.start..2 * along.end, 0..width),
            Part::Above(z) => seen.samples_of_actor(1, 0..2 * row_at(z).min(height), along),
        }
    };
    let stretches = if matches!(of, Part::All) { SIZE.1 } else { SIZE.0 } / stretch;
    (0..stretches).map(|i| samples(i) as f64 / (2.0 * scale * scale)).collect()
}

/// Over stretches and small steps of the camera: how much more is shown than in the finer picture of the finest mesh, and
/// how far single stretches are from it, as shares of the mean.
fn errors(model: &SceneryModel, distance_m: f64, yaw: f64, of: Part) -> (f64, f64) {
    // Fences reach to both sides.
    let aside_m = if matches!(of, Part::Above(_)) { -4.8 } else { 0.0 };
    let at = |shape: &Arc<LodSet>| Instance {
        shape: Arc::clone(shape),
        actor_id: 1,
        ..model.at(upright(DVec3::new(distance_m, aside_m, 0.0), yaw))
    };
    let finest = Arc::new(LodSet::single((**model.shape.finest()).clone()));
    let (mut count, mut sum, mut excess, mut square) = (0.0, 0.0, 0.0, 0.0);
    for step in 0..6 {
        let px_m = distance_m / FOCAL_PX;
        let (aside, up) = (0.37 * f64::from(step) * px_m, 0.23 * f64::from(step) * px_m);
        let eye = DVec3::new(0.0, aside, 1.65 + up);
        let coarse = shown(&at(&model.shape), eye, 1, of);
        let fine = shown(&at(&finest), eye, FINER, of);
        for i in 1..fine.len() - 1 {
            // Where it is seen all along the stretch.
            if fine[i - 1].min(fine[i]).min(fine[i + 1]) > 0.0 {
                count += 1.0;
                sum += fine[i];
                excess += coarse[i] - fine[i];
                let off = coarse[i] - fine[i];
                square += off * off;
            }
        }
    }
    assert!(count >= 6.0, "{} is not in the picture", model.name);
    (excess / sum, (square / count).sqrt() * count / sum)
}

fn assert_close(model: &SceneryModel, distance_m: f64, excess: f64, error: f64) {
    let what = format!("{} at {distance_m} m: {excess:.2} more, single stretches off by {error:.2}", model.name);
    assert!(excess.abs() < 0.35 && error < 0.45, "{what}");
}

#[test]
fn fences_show_as_much_at_every_level_and_do_not_break_into_dashes() {
    for (kind, above_m, at_m) in [
        // Above its plinth.
        (RAILING, 0.6, [20.0, 32.0, 55.0, 80.0, 120.0].as_slice()),
        (WIRE, 0.0, &[7.0, 14.0, 20.0, 30.0, 45.0, 60.0]),
        (PICKET, 0.0, &[20.0, 40.0, 80.0, 120.0]),
    ] {
        for (variant, distance_m) in (0..2).flat_map(|v| at_m.iter().map(move |d| (v, *d))) {
            let model = kind.piece(variant, 0);
            let (excess, error) = errors(&model, distance_m, std::f64::consts::FRAC_PI_2, Part::Above(above_m));
            assert_close(&model, distance_m, excess, error);
        }
    }
}

#[test]
fn posts_show_as_much_at_every_level_and_do_not_break_into_dashes() {
    for kind in [LAMP, ARM_LAMP, ROUND_SIGN, NAME_SIGN] {
        for distance_m in [20.0, 40.0, 62.0, 80.0, 100.0] {
            let model = kind.model(0);
            let (excess, error) = errors(&model, distance_m, std::f64::consts::PI, Part::All);
            assert_close(&model, distance_m, excess, error);
        }
    }
}
