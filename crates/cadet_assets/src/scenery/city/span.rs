//! Lamps that hang over the middle of a street, on a wire from front to front.

use super::super::materials::{furniture_palette, furniture_slot as slot};
use super::super::{Detail, SceneryModel};
use cadet_base::geometry::{Memo, Mesh, MeshBuilder};
use cadet_base::material::Semantic;
use cadet_base::math::{DVec2, Vec3};
use cadet_base::rng::Stream;

/// Wires come in whole meters up to this.
const LONGEST_M: usize = 32;
const SHORTEST_M: usize = 8;
/// Where a wire begins, and where the lamp hangs.
const WIRE_M: f32 = 7.6;
const LAMP_M: f32 = 6.6;
const SAG_M: f32 = 0.55;
/// Height of the underside of its lens.
pub const SPAN_LENS_M: f32 = LAMP_M - 0.06;

/// A lamp on a wire along y; its ends are at least `span_m` apart, and less than a meter more. `None` for a street too
/// wide or too narrow for one.
#[must_use]
pub fn span_lamp(span_m: f64) -> Option<SceneryModel> {
    static MODELS: Memo<usize, SceneryModel> = Memo::new();
    let length_m = span_m.ceil() as usize;
    if !(SHORTEST_M..=LONGEST_M).contains(&length_m) {
        return None;
    }
    let model = MODELS.get(length_m, || {
        let mut s = Stream::from_seed("span lamp", length_m as u64);
        let shape = Detail::levels([30.0, 60.0, 120.0], move |d| mesh(length_m as f32 / 2.0, d));
        let height_m = f64::from(shape.bounds.max.z);
        let palette = furniture_palette(&mut s, Semantic::Pole, [0.30, 0.31, 0.32], [0.50, 0.50, 0.48]);
        SceneryModel::about_origin(format!("span-lamp/{length_m}"), shape, palette, DVec2::splat(0.1), height_m)
    });
    Some(model)
}

fn mesh(half: f32, detail: Detail) -> Mesh {
    let mut b = MeshBuilder::new();
    let pieces = detail.pick(12, 8, 4);
    let stations: Vec<(Vec3, f32)> = (0..=pieces)
        .map(|k| 2.0 * k as f32 / pieces as f32 - 1.0)
        .map(|t| (Vec3::new(0.0, half * t, WIRE_M - SAG_M * (1.0 - t * t)), 0.006))
        .collect();
    b.tube(&stations, 3, slot::BODY);
    let top = WIRE_M - SAG_M;
    b.tube(&[(Vec3::Z * (LAMP_M + 0.2), 0.02), (Vec3::Z * top, 0.02)], 4, slot::BODY);
    b.block(Vec3::Z * (LAMP_M + 0.12), Vec3::new(0.3, 0.7, 0.16), slot::BODY);
    b.block(Vec3::Z * LAMP_M, Vec3::new(0.24, 0.6, 0.1), slot::ACCENT);
    b.build("span lamp", 0.7)
}
