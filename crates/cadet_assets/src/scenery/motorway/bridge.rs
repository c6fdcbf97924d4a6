//! A bridge that leads a road over a motorway: deck, railings, abutments, a pier on the median, and its ramps of earth.

use super::super::draw::{CREASE_RAD, v};
use super::super::{Detail, Mesh, SceneryModel};
use super::{palette, slot};
use cadet_base::geometry::MeshBuilder;
use cadet_base::math::{DVec2, Vec3};
use cadet_base::rng::Stream;

/// Underside and top of the deck over the motorway, and half of its width.
pub const BRIDGE_DECK_M: (f64, f64) = (5.2, 6.5);
const HALF: f32 = 4.6;
/// How far the ramps reach beyond the abutments, and how deep their earth goes.
pub const RAMP_M: f64 = 80.0;
const DEPTH: f32 = -7.0;
/// Slopes of earth: meters out a meter down.
const SLOPE: f32 = 1.5;
/// The slopes beside an abutment begin at its wing walls and are whole so far behind it.
const WINGS: f32 = 16.0;

/// A bridge along y; the motorway runs along x at z = 0, and the abutments stand at y = -`half_span_m` and `half_span_m`.
#[must_use]
pub fn overpass(variant: usize, half_span_m: f64) -> SceneryModel {
    let name = format!("overpass/{variant}");
    let palette = palette(&mut Stream::from_seed("overpass", variant as u64));
    let half_span = half_span_m as f32;
    let shape = Detail::levels([90.0, 220.0, f32::INFINITY], move |detail| mesh(variant, half_span, detail));
    let height_m = f64::from(shape.bounds.max.z);
    SceneryModel::about_origin(name, shape, palette, DVec2::new(f64::from(HALF), half_span_m + RAMP_M), height_m)
}

fn mesh(variant: usize, half_span: f32, detail: Detail) -> Mesh {
    let mut b = MeshBuilder::new();
    let (low, top) = (BRIDGE_DECK_M.0 as f32, BRIDGE_DECK_M.1 as f32);
    let reach = half_span + 1.2;
    // Beams below, the deck's overhang with its edge over them.
    b.cuboid(v(-HALF + 1.1, -reach, low), v(HALF - 1.1, reach, top - 0.25), slot::CONCRETE);
    b.cuboid(v(-HALF, -reach, top - 0.4), v(HALF, reach, top), slot::CONCRETE);
    let [p, q, r, s] = [(-3.2, -reach), (3.2, -reach), (3.2, reach), (-3.2, reach)].map(|(x, y)| v(x, y, top + 0.01));
    b.quad(p, q, r, s, slot::ASPHALT);
    for side in [-1.0, 1.0] {
        let x = side * (HALF - 0.12);
        b.block(v(x, 0.0, top + 0.05), v(0.3, 2.0 * reach, 0.3), slot::CONCRETE);
        railing(&mut b, x, reach, top + 0.2, detail);
    }
    pier(&mut b, variant, low, detail);
    for side in [-1.0, 1.0] {
        let y = side * half_span;
        // The wall, and wing walls that go back along the ramp.
        let middle = v(0.0, y + side * 0.7, (top + DEPTH) / 2.0 - 0.1);
        b.block(middle, v(2.0 * HALF, 1.4, top - DEPTH - 0.2), slot::CONCRETE);
        for wing in [-1.0, 1.0] {
            let x = wing * (HALF - 0.2);
            b.block(v(x, y + side * WINGS / 2.0, (top + DEPTH) / 2.0), v(0.4, WINGS, top - DEPTH), slot::CONCRETE);
        }
        ramp(&mut b, side, half_span, top);
    }
    b.build("overpass", CREASE_RAD)
}

fn railing(b: &mut MeshBuilder, x: f32, reach: f32, z: f32, detail: Detail) {
    let thick = detail.pick(0.05, 0.06, 0.09);
    let rails: &[f32] = if detail == Detail::Far { &[1.0, 0.5] } else { &[1.0, 0.75, 0.5, 0.25] };
    for height in rails {
        b.block(v(x, 0.0, z + height), v(thick, 2.0 * reach, thick), slot::STEEL);
    }
    let count = (2.0 * reach / detail.pick(2.0, 2.0, 6.0)) as usize;
    for k in 0..=count {
        let y = -reach + 2.0 * reach * k as f32 / count as f32;
        b.block(v(x, y, z + 0.5), v(0.07, 0.07, 1.0), slot::STEEL);
    }
}

/// Round columns, or a wall.
fn pier(b: &mut MeshBuilder, variant: usize, low: f32, detail: Detail) {
    if variant.is_multiple_of(2) {
        for x in [-2.2, 0.0, 2.2] {
            b.tube(&[(v(x, 0.0, -1.0), 0.42), (v(x, 0.0, low + 0.1), 0.42)], detail.pick(18, 10, 8), slot::CONCRETE);
        }
    } else {
        b.block(v(0.0, 0.0, (low - 1.0) / 2.0), v(6.4, 0.7, low + 1.0), slot::CONCRETE);
    }
}

/// Earth behind an abutment, falling to the land.
fn ramp(b: &mut MeshBuilder, side: f32, half_span: f32, top: f32) {
    // Distance behind the abutment, height of the road there, share of the slopes that is there.
    let stations =
        [(0.3, 0.0, 0.0), (WINGS * 0.5, 0.0, 0.5), (WINGS, 0.0, 1.0), (30.0, -0.6, 1.0), (RAMP_M as f32, -6.5, 1.0)];
    let rings: Vec<Vec<Vec3>> = stations
        .iter()
        .map(|(behind, fall, share)| {
            let (y, z) = (side * (half_span + behind), top + fall - 0.02);
            let toe = HALF + SLOPE * (z - DEPTH).max(0.5) * share;
            let ring = vec![v(-toe, y, DEPTH), v(toe, y, DEPTH), v(HALF, y, z), v(-HALF, y, z)];
            if side > 0.0 { ring.into_iter().rev().collect() } else { ring }
        })
        .collect();
    b.loft(&rings, slot::EARTH, true);
    for pair in stations.windows(2) {
        let [near, far] = [pair[0], pair[1]].map(|(behind, fall, _)| (side * (half_span + behind), top + fall + 0.01));
        let [a, c] = [near, far].map(|(y, z)| [v(-3.2, y, z), v(3.2, y, z)]);
        let (l, r) = if side > 0.0 { (0, 1) } else { (1, 0) };
        b.quad(a[l], a[r], c[r], c[l], slot::ASPHALT);
    }
}
