//! Bars and pods that belongings are made of.

use crate::person::tube::{Ring, Tubes};
use cadet_base::math::Vec3;

/// Corners of a thick tube and of a thin one at each level of detail.
pub(super) const SIDES: [[usize; 2]; 3] = [[16, 8], [8, 5], [5, 3]];

/// A direction square to another.
fn square_to(along: Vec3) -> Vec3 {
    if along.z.abs() > 0.9 { Vec3::X } else { (Vec3::Z - along * along.z).normalize() }
}

/// A thin tube through points.
pub(super) fn pipe(tubes: &mut Tubes, points: &[Vec3], radius_m: f32, slot: u8, level: usize) {
    let last = points.len() - 1;
    let whole = (points[last] - points[0]).normalize_or(Vec3::X);
    let rings: Vec<Ring> = (0..=last)
        .map(|i| {
            let along = (points[(i + 1).min(last)] - points[i.max(1) - 1]).normalize_or(whole);
            Ring::new(points[i], [along, square_to(whole)], [radius_m; 2], slot, 2)
        })
        .collect();
    tubes.tube(&rings, SIDES[level][1], level, -1.0);
}

/// A soft body along an axis: places with half axes, up (or forward of an upright one) and aside, and the coarsest level
/// that keeps each.
pub(super) fn pod(tubes: &mut Tubes, along: Vec3, places: &[(Vec3, [f32; 2], usize)], slot: u8, level: usize) {
    let axes = [along, square_to(along)];
    let rings: Vec<Ring> =
        places.iter().map(|(center, half, keeps)| Ring::new(*center, axes, *half, slot, *keeps)).collect();
    tubes.tube(&rings, SIDES[level][0], level, -1.0);
}

/// A ball, longer or flatter by its half axes.
pub(super) fn ball(tubes: &mut Tubes, center: Vec3, half: Vec3, slot: u8, level: usize) {
    let places = [(-0.92_f32, 2), (-0.6, 1), (0.0, 2), (0.6, 1), (0.92, 2)].map(|(z, keeps)| {
        let r = (1.0 - z * z).sqrt();
        (center + Vec3::Z * (z * half.z), [r * half.x, r * half.y], keeps)
    });
    pod(tubes, Vec3::Z, &places, slot, level);
}

/// A wheel whose axle lies along y.
pub(super) fn wheel(tubes: &mut Tubes, hub: Vec3, radius_m: f32, width_m: f32, [tire, rim]: [u8; 2], level: usize) {
    let ring =
        |y: f32, r: f32, slot: u8, keeps: usize| Ring::new(hub + Vec3::Y * y, [Vec3::Y, Vec3::Z], [r; 2], slot, keeps);
    let half = width_m / 2.0;
    let rings = [
        ring(-0.7 * half, 0.70 * radius_m, rim, 0),
        ring(-0.95 * half, 0.74 * radius_m, tire, 1),
        ring(-half, 0.95 * radius_m, tire, 2),
        ring(-0.6 * half, radius_m, tire, 0),
        ring(0.6 * half, radius_m, tire, 0),
        ring(half, 0.95 * radius_m, tire, 2),
        ring(0.95 * half, 0.74 * radius_m, rim, 1),
        ring(0.7 * half, 0.70 * radius_m, rim, 0),
    ];
    // Even numbers, so that a corner is on the ground.
    tubes.tube(&rings, [16, 8, 6][level], level, -1.0);
}
