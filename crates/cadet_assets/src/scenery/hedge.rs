//! Hedges: an uneven dark core with leaf cards all over it.

use super::draw::{direction, range};
use super::leaves::Leaves;
use super::materials::plant_slot as slot;
use super::{Detail, Mesh};
use cadet_base::geometry::MeshBuilder;
use cadet_base::math::Vec3;
use cadet_base::rng::Stream;

/// Number of variants that are at most a meter deep; they come first.
pub const NARROW_HEDGES: usize = 5;
/// (height, depth) of each variant. Those that are not narrow are as wide as a car: low, and much like one to a LIDAR.
pub(super) const SECTIONS_M: [(f32, f32); 7] =
    [(0.9, 0.6), (1.2, 0.7), (1.5, 0.8), (1.75, 0.9), (2.1, 1.0), (0.75, 1.3), (1.05, 1.7)];

/// Draws a piece of hedge from x = 0 to `length_m`, its depth to both sides of y = 0.
pub(super) fn mesh(variant: usize, length_m: f32, detail: Detail) -> Mesh {
    let (height, depth) = SECTIONS_M[variant % SECTIONS_M.len()];
    let s = &mut Stream::from_seed("hedge", variant as u64 * 1000 + (length_m * 100.0) as u64);
    let mut core = MeshBuilder::new();
    let step = detail.pick(0.3, 0.75, f32::INFINITY);
    let stations = ((length_m / step).ceil() as usize).max(1);
    let inset: f32 = detail.pick(0.06, 0.04, 0.0);
    let half = depth / 2.0 - inset;
    // Sections follow each other along x and run counter-clockwise seen against it.
    let rings: Vec<Vec<Vec3>> = (0..=stations)
        .map(|i| {
            let x = length_m * i as f32 / stations as f32;
            let mut bump = || if i == 0 || i == stations { 0.0 } else { range(s, -0.06, 0.06) };
            let top = height - inset;
            vec![
                Vec3::new(x, half + bump(), -0.3),
                Vec3::new(x, half + bump(), height * 0.5),
                Vec3::new(x, half * 0.85 + bump(), top + bump()),
                Vec3::new(x, -half * 0.85 + bump(), top + bump()),
                Vec3::new(x, -half + bump(), height * 0.5),
                Vec3::new(x, -half + bump(), -0.3),
            ]
        })
        .collect();
    core.loft(&rings, if detail == Detail::Far { slot::LEAF } else { slot::DARK_LEAF }, true);
    let mut leaves = Leaves::default();
    let area = length_m * (2.0 * height + depth);
    let size: f32 = detail.pick(0.10, 0.20, 0.7);
    let coverage: f32 = detail.pick(1.0, 0.9, 0.2);
    let ends = height * depth / area;
    // A card is two triangles of size^2 / 2.
    for _ in 0..(coverage * area * (1.0 + 2.0 * ends) / (size * size)) as usize {
        let x = range(s, 0.0, length_m);
        let along = range(s, 0.0, 2.0 * height + depth);
        let rough = range(s, -0.05, 0.07);
        let (p, out) = if s.chance(f64::from(2.0 * ends / (1.0 + 2.0 * ends))) {
            let (y, z) = (range(s, -half, half), range(s, 0.0, height - inset));
            let far = along > height;
            (Vec3::new(if far { length_m + rough } else { -rough }, y, z), if far { Vec3::X } else { -Vec3::X })
        } else if along < height {
            (Vec3::new(x, half + rough, along), Vec3::Y)
        } else if along < height + depth {
            (Vec3::new(x, (along - height - depth / 2.0) * 0.95, height - inset + rough), Vec3::Z)
        } else {
            (Vec3::new(x, -half - rough, along - height - depth), -Vec3::Y)
        };
        let facing = (direction(s) + out * 0.7).normalize_or(out);
        leaves.card(s, p, facing, out + Vec3::Z * 0.2, size);
    }
    leaves.build("hedge", &core)
}
