//! Boards on posts, gantries, speed limits, kilometer plates and telephones; all face +x.

use std::sync::Arc;

use super::super::draw::{CREASE_RAD, block, disc, tube};
use super::super::{Detail, Mesh, SceneryModel};
use super::writing::{arrow, width, write};
use super::{PANELS, palette, slot};
use crate::geometry::MeshBuilder;
use crate::math::{DVec2, Vec3};
use crate::rng::Stream;

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

fn v(x: f32, y: f32, z: f32) -> Vec3 {
    Vec3::new(x, y, z)
}

/// A blue board with a white rim about (x, y, z).
fn blank(b: &mut MeshBuilder, (x, y, z): (f32, f32, f32), (wide, high): (f32, f32), slot: u8) {
    block(b, v(x - 0.03, y, z), v(0.05, wide, high), slot::BACK);
    for (k, (inset, slot)) in [(0.0, slot::WHITE), (0.07, slot)].into_iter().enumerate() {
        let (w, h, x) = (wide / 2.0 - inset, high / 2.0 - inset, x + 0.004 * (k + 1) as f32);
        b.quad(v(x, y - w, z - h), v(x, y + w, z - h), v(x, y + w, z + h), v(x, y - w, z + h), slot);
    }
}

/// Three or four places, with how far they are.
pub(super) fn board(variant: usize, detail: Detail) -> Mesh {
    let mut b = MeshBuilder::new();
    let lines = 3 + variant % 2;
    let (letters, wide) = (0.42, 4.3);
    let high = 0.5 + 0.66 * lines as f32;
    let middle = 1.7 + high / 2.0;
    for side in [-1.0, 1.0] {
        let y = side * wide * 0.3;
        tube(
            &mut b,
            (v(-0.14, y, -0.6), 0.09),
            (v(-0.14, y, middle + high * 0.4), 0.09),
            detail.pick(10, 6, 4),
            slot::STEEL,
        );
    }
    blank(&mut b, (0.0, 0.0, middle), (wide, high), slot::BLUE);
    for line in 0..lines {
        let z = middle + high / 2.0 - 0.58 - 0.66 * line as f32;
        let place = PLACES[(variant * 3 + line * 2) % PLACES.len()];
        let far = format!("{}", 9 + (variant * 17 + line * 31) % 20 + 38 * line);
        write(&mut b, place, (0.012, -wide / 2.0 + 0.3, z), letters, slot::WHITE);
        write(&mut b, &far, (0.012, wide / 2.0 - 0.3 - width(&far) * letters, z), letters, slot::WHITE);
    }
    b.build("motorway-board", CREASE_RAD)
}

/// Digits of a kilometer and its half.
pub(super) fn kilometer_plate(variant: usize, detail: Detail) -> Mesh {
    let mut b = MeshBuilder::new();
    tube(&mut b, (v(-0.03, 0.0, -0.4), 0.03), (v(-0.03, 0.0, 1.35), 0.03), detail.pick(8, 6, 4), slot::STEEL);
    block(&mut b, v(0.0, 0.0, 1.25), v(0.03, 0.62, 0.34), slot::BACK);
    b.quad(v(0.017, -0.31, 1.08), v(0.017, 0.31, 1.08), v(0.017, 0.31, 1.42), v(0.017, -0.31, 1.42), slot::BLUE);
    if detail != Detail::Far {
        let text = format!("{},{}", 12 + 29 * variant, 5 * (variant % 2));
        write(&mut b, &text, (0.022, -width(&text) * 0.11, 1.25), 0.22, slot::WHITE);
    }
    b.build("kilometer-plate", CREASE_RAD)
}

pub(super) fn telephone(detail: Detail) -> Mesh {
    let mut b = MeshBuilder::new();
    block(&mut b, v(0.0, 0.0, -0.1), v(0.5, 0.5, 0.3), slot::CONCRETE);
    block(&mut b, v(0.0, 0.0, 0.72), v(0.26, 0.32, 1.4), slot::ORANGE);
    block(&mut b, v(0.0, 0.0, 1.48), v(0.34, 0.4, 0.16), slot::ORANGE);
    if detail != Detail::Far {
        b.quad(v(0.135, -0.12, 0.95), v(0.135, 0.12, 0.95), v(0.135, 0.12, 1.3), v(0.135, -0.12, 1.3), slot::WHITE);
    }
    b.build("emergency-telephone", CREASE_RAD)
}

/// A round speed limit on a post.
#[must_use]
pub fn speed_sign(speed_kmh: u32) -> SceneryModel {
    let name = format!("speed-sign/{speed_kmh}");
    let palette = palette(&mut Stream::from_seed("speed-sign", 0), PANELS[0]);
    let shape = Detail::levels([45.0, 110.0, 300.0], move |detail| {
        let mut b = MeshBuilder::new();
        let (z, sides) = (2.35, detail.pick(28, 16, 10));
        tube(&mut b, (v(-0.05, 0.0, -0.4), 0.038), (v(-0.05, 0.0, z + 0.3), 0.038), detail.pick(10, 6, 4), slot::STEEL);
        let ring = |x: f32| -> Vec<Vec3> {
            let turn = |i: usize| std::f32::consts::TAU * i as f32 / sides as f32;
            (0..sides)
                .map(|i| v(x, 0.375 * crate::math::cosf(turn(i)), z + 0.375 * crate::math::sinf(turn(i))))
                .collect()
        };
        b.loft(&[ring(-0.01), ring(0.0)], slot::BACK, true);
        disc(&mut b, v(0.004, 0.0, z), 0.375, sides, 0.0, slot::RED);
        disc(&mut b, v(0.008, 0.0, z), 0.30, sides, 0.0, slot::WHITE);
        if detail != Detail::Far {
            let text = speed_kmh.to_string();
            write(&mut b, &text, (0.012, -width(&text) * 0.12, z), 0.24, slot::INK);
        }
        b.build("speed-sign", CREASE_RAD)
    });
    let half = DVec2::splat(0.12);
    SceneryModel { name, shape, palette, footprint_min: -half, footprint_max: half, height_m: 2.7 }
}

/// A gantry over one carriageway, from y = -`half_m` to `half_m`, with boards over its lanes.
#[must_use]
pub fn gantry(variant: usize, half_m: f64, num_lanes: usize) -> SceneryModel {
    let name = format!("gantry/{variant}/{num_lanes}");
    let palette = palette(&mut Stream::from_seed("gantry", variant as u64), PANELS[0]);
    let half = half_m as f32;
    let shape = Detail::levels([60.0, 140.0, 600.0], move |detail| gantry_mesh(variant, half, num_lanes, detail));
    let height_m = f64::from(shape.bounds.max.z);
    let footprint_max = DVec2::new(0.6, half_m + 0.3);
    SceneryModel { name, shape: Arc::clone(&shape), palette, footprint_min: -footprint_max, footprint_max, height_m }
}

fn gantry_mesh(variant: usize, half: f32, num_lanes: usize, detail: Detail) -> Mesh {
    let mut b = MeshBuilder::new();
    let (low, high) = (CLEARANCE + 0.7, CLEARANCE + 2.0);
    for y in [-half, half] {
        block(&mut b, v(-0.35, y, -0.1), v(1.1, 0.9, 0.9), slot::CONCRETE);
        block(&mut b, v(-0.35, y, high / 2.0 + 0.1), v(0.42, 0.36, high), slot::STEEL);
    }
    // A box truss behind the boards.
    let thick = detail.pick(0.11, 0.12, 0.16);
    let chords = [(-0.15, low), (-0.15, high), (-0.75, low), (-0.75, high)];
    for (x, z) in chords {
        block(&mut b, v(x, 0.0, z), v(thick, 2.0 * half, thick), slot::STEEL);
    }
    let bays = (2.0 * half / 1.5).round().max(1.0) as usize;
    let at = |k: usize| -half + 2.0 * half * k as f32 / bays as f32;
    if detail != Detail::Far {
        for k in 0..bays {
            for x in [-0.15, -0.75] {
                let (from, to) = if k % 2 == 0 { (low, high) } else { (high, low) };
                tube(&mut b, (v(x, at(k), from), 0.035), (v(x, at(k + 1), to), 0.035), 4, slot::STEEL);
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
            write(&mut b, place, (0.065, y - wide / 2.0 + 0.25, z), height, slot::WHITE);
        }
        let arrows = if boards == 1 { num_lanes } else { 1 };
        for lane in 0..arrows {
            let aside = (lane as f32 - (arrows as f32 - 1.0) / 2.0) * 1.5;
            arrow(&mut b, (0.065, y + aside, middle - tall / 2.0 + 0.55), 0.8);
        }
    }
    b.build("gantry", CREASE_RAD)
}
