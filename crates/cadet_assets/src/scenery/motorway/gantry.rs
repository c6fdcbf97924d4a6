//! Gantries over carriageways; their boards face +x.

use super::super::draw::{CREASE_RAD, v};
use super::super::letters::{width, write};
use super::super::{Detail, Mesh, SceneryModel};
use super::{palette, slot};
use cadet_base::geometry::MeshBuilder;
use cadet_base::math::{DVec2, Vec3};
use cadet_base::rng::Stream;

/// Places that signs name; none is meant.
const PLACES: [&str; 10] = [
    "NORDHEIM",
    "OSTERAU",
    "KIRCHFELD",
    "WALDECK",
    "STEINACH",
    "LINDENAU",
    "MITTELSTADT",
    "GRUNBACH",
    "HOHENFELS",
    "RHEINTAL",
];
/// The underside of a gantry's boards.
const CLEARANCE: f32 = 5.2;

/// A blue board with a white rim about (x, y, z).
fn blank(b: &mut MeshBuilder, (x, y, z): (f32, f32, f32), (wide, high): (f32, f32), slot: u8) {
    b.block(v(x - 0.03, y, z), v(0.05, wide, high), slot::BACK);
    for (k, (inset, slot)) in [(0.0, slot::WHITE), (0.07, slot)].into_iter().enumerate() {
        let (w, h, x) = (wide / 2.0 - inset, high / 2.0 - inset, x + 0.004 * (k + 1) as f32);
        b.quad(v(x, y - w, z - h), v(x, y + w, z - h), v(x, y + w, z + h), v(x, y - w, z + h), slot);
    }
}

/// A gantry over one carriageway, from y = -`half_m` to `half_m`, with boards over its lanes.
#[must_use]
pub fn gantry(variant: usize, half_m: f64, num_lanes: usize) -> SceneryModel {
    let name = format!("gantry/{variant}/{num_lanes}");
    let palette = palette(&mut Stream::from_seed("gantry", variant as u64));
    let half = half_m as f32;
    let shape = Detail::levels([60.0, 140.0, 600.0], move |detail| gantry_mesh(variant, half, num_lanes, detail));
    let height_m = f64::from(shape.bounds.max.z);
    SceneryModel::about_origin(name, shape, palette, DVec2::new(0.6, half_m + 0.3), height_m)
}

fn gantry_mesh(variant: usize, half: f32, num_lanes: usize, detail: Detail) -> Mesh {
    let mut b = MeshBuilder::new();
    let (low, high) = (CLEARANCE + 0.7, CLEARANCE + 2.0);
    for y in [-half, half] {
        b.block(v(-0.35, y, -0.1), v(1.1, 0.9, 0.9), slot::CONCRETE);
        b.block(v(-0.35, y, high / 2.0 + 0.1), v(0.42, 0.36, high), slot::STEEL);
    }
    // A box truss behind the boards.
    let thick = detail.pick(0.11, 0.12, 0.16);
    let chords = [(-0.15, low), (-0.15, high), (-0.75, low), (-0.75, high)];
    for (x, z) in chords {
        b.block(v(x, 0.0, z), v(thick, 2.0 * half, thick), slot::STEEL);
    }
    let bays = (2.0 * half / 1.5).round().max(1.0) as usize;
    let at = |k: usize| -half + 2.0 * half * k as f32 / bays as f32;
    if detail != Detail::Far {
        for k in 0..bays {
            for x in [-0.15, -0.75] {
                let (from, to) = if k % 2 == 0 { (low, high) } else { (high, low) };
                b.tube(&[(v(x, at(k), from), 0.035), (v(x, at(k + 1), to), 0.035)], 4, slot::STEEL);
            }
        }
    }
    // As who drives up sees it, the right lane is at +y.
    let boards = if variant.is_multiple_of(2) { num_lanes } else { 1 };
    let (wide, tall) = if boards == 1 { (5.6, 2.7) } else { (3.3, 2.5) };
    let middle = CLEARANCE + tall / 2.0;
    for k in 0..boards {
        let y = (k as f32 - (boards as f32 - 1.0) / 2.0) * 3.7;
        blank(&mut b, (0.05, y, middle), (wide, tall), slot::BLUE);
        for line in 0..2 {
            let place = PLACES[(variant * 3 + k * 2 + line) % PLACES.len()];
            let height = (0.4_f32).min((wide - 0.5) / width(place));
            let z = middle + tall / 2.0 - 0.5 - 0.62 * line as f32;
            write(&mut b, place, v(0.065, y - wide / 2.0 + 0.25, z), height, slot::WHITE);
        }
        let arrows = if boards == 1 { num_lanes } else { 1 };
        for lane in 0..arrows {
            let aside = (lane as f32 - (arrows as f32 - 1.0) / 2.0) * 1.5;
            arrow(&mut b, v(0.065, y + aside, middle - tall / 2.0 + 0.55), 0.8);
        }
    }
    b.build("gantry", CREASE_RAD)
}

/// An arrow that points down on a plane that faces +x, about `middle`.
fn arrow(b: &mut MeshBuilder, middle: Vec3, height: f32) {
    let p = |dy: f32, dz: f32| middle + v(0.0, dy * height, dz * height);
    b.quad(p(-0.09, -0.1), p(0.09, -0.1), p(0.09, 0.5), p(-0.09, 0.5), slot::WHITE);
    b.triangle(p(0.0, -0.5), p(0.3, -0.1), p(-0.3, -0.1), slot::WHITE);
}
