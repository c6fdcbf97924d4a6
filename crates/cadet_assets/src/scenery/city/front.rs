//! The fronts of a house in a closed row: windows in columns over shops or flats, and what stands out.

use super::super::Detail;

use super::super::facade::{Curtain, Filling, Opening, WallShape, wall};
use super::super::materials::house_slot as slot;
use super::super::wall_plane::WallPlane;
use super::shop::Shop;
use super::{CityDesign, city_slot};
use cadet_base::geometry::MeshBuilder;
use cadet_base::math::Vec3;
use cadet_base::rng::Stream;

/// Piers between the openings of a ground floor.
const PIER_M: f32 = 0.42;
const HOUSE_DOOR_M: f32 = 1.25;
const GATE_M: f32 = 3.0;
/// Below this the walls are foundation.
const FOOT_M: f32 = 0.1;
/// A bay stands out so far.
const BAY_DEPTH_M: f32 = 0.65;
/// How far balconies stand out.
const BALCONY_M: f32 = 1.05;

/// What one wall to a street has.
struct Layout {
    /// Openings of the ground floor.
    ground: Vec<Opening>,
    /// Those of the floors over it.
    upper: Vec<Opening>,
    /// Middles of the columns of windows.
    columns: Vec<f32>,
    /// Columns with balconies, and the column with a bay.
    balconies: Vec<usize>,
    bay: Option<usize>,
}

/// Draws a wall to a street. `is_crossing` marks the narrow one at a corner.
pub(super) fn draw(b: &mut MeshBuilder, d: &CityDesign, plane: &WallPlane, width_m: f32, index: usize, detail: Detail) {
    let (layout, mut s) = lay_out(d, width_m, index);
    wall(b, plane, &WallShape::level(width_m, -0.3, d.ground_m, city_slot::BASE), &layout.ground, detail);
    let top = d.cornice_m();
    wall(b, plane, &WallShape::level(width_m, d.ground_m, top, slot::WALL), &layout.upper, detail);
    if let Some(bay) = layout.bay {
        draw_bay(b, d, plane, layout.columns[bay], detail, &mut s);
    }
    if detail == Detail::Far {
        return;
    }
    // The band over the ground floor, and one under the cornice.
    plane.block(b, [0.0, width_m, d.ground_m - 0.12, d.ground_m + 0.14], -0.1, 0.0, slot::STONE);
    plane.block(b, [0.0, width_m, top - 0.35, top - 0.1], -0.06, 0.0, slot::STONE);
    for column in &layout.balconies {
        for story in 1..d.stories {
            balcony(b, plane, layout.columns[*column], d.floor(story), detail);
        }
    }
    if width_m > 8.0 {
        let foot = plane.at(0.16, -0.3, -0.09);
        b.tube(&[(foot, 0.05), (foot + Vec3::Z * (top + 0.2), 0.05)], 5, slot::METAL);
    }
    if detail == Detail::Near && d.has_surrounds {
        layout.upper.iter().for_each(|o| surround(b, plane, o, d.ground_m));
    }
}

/// A wall to the court or to where a neighbor may stand: plain windows, `index` of the wall, columns `spacing_m` apart.
pub(super) fn draw_plain(
    b: &mut MeshBuilder,
    d: &CityDesign,
    (plane, width_m): (&WallPlane, f32),
    (index, spacing_m): (usize, f32),
    detail: Detail,
) {
    let mut s = Stream::from_seed("plain", d.seed ^ index as u64);
    let count = (width_m / spacing_m).round().max(1.0) as usize;
    let mut openings = Vec::new();
    for story in 0..d.stories {
        for k in 0..count {
            let (u, v) = (width_m * (k as f32 + 0.5) / count as f32, d.floor(story) + 0.95);
            if s.chance(0.85) {
                let filling = Filling::Window { sashes: 1, shutter: 0.0, curtain: Curtain::draw(&mut s, 0.5) };
                openings.push(Opening { rect: [u - 0.5, u + 0.5, v, v + 1.4], filling });
            }
        }
    }
    let shape = WallShape::level(width_m, -0.3, d.cornice_m(), slot::WALL);
    wall(b, plane, &shape, &openings, if detail == Detail::Near { Detail::Mid } else { detail });
}

/// The ways in on the ground floor of a wall to a street, along it.
pub(super) fn doorways(d: &CityDesign, width_m: f32, index: usize) -> Vec<[f32; 2]> {
    lay_out(d, width_m, index).0.ground.iter().filter_map(Opening::doorway).collect()
}

/// What the wall has, and the stream that its bay is drawn from: the same for every level of detail.
fn lay_out(d: &CityDesign, width_m: f32, index: usize) -> (Layout, Stream) {
    let mut stream = Stream::from_seed("front", d.seed ^ index as u64);
    let s = &mut stream;
    let is_narrow = width_m < 6.0;
    let count = if is_narrow { 1 } else { (width_m / d.column_m).round().max(2.0) as usize };
    let cell = width_m / count as f32;
    let columns: Vec<f32> = (0..count).map(|k| cell * (k as f32 + 0.5)).collect();
    let ground = if d.has_shops { shops(d, width_m, is_narrow, s) } else { flats(d, &columns, is_narrow, s) };
    let has_bay = !is_narrow && count >= 4 && s.chance(d.bay_share);
    let bay = has_bay.then(|| 1 + s.below(count - 2));
    let mut balconies = Vec::new();
    if !has_bay && !is_narrow && s.chance(d.balcony_share) {
        let first = s.below(2);
        balconies = (first..count).step_by(if count > 5 { 3 } else { 2 }).collect();
    }
    let half = (d.window.0 / 2.0).min(cell / 2.0 - 0.3);
    let mut upper = Vec::new();
    for (k, u) in columns.iter().enumerate().filter(|(k, _)| bay != Some(*k)) {
        for story in 1..d.stories {
            let to_balcony = balconies.contains(&k);
            let low = d.floor(story) + if to_balcony { 0.12 } else { 0.8 };
            let high = d.floor(story) + 0.8 + d.window.1;
            upper.push(Opening { rect: [u - half, u + half, low, high], filling: Filling::draw_window(d.sashes, s) });
        }
    }
    (Layout { ground, upper, columns, balconies, bay }, stream)
}

/// A ground floor of shops, with the house's door and perhaps a gateway between them.
fn shops(d: &CityDesign, width: f32, is_narrow: bool, s: &mut Stream) -> Vec<Opening> {
    let (low, top) = (FOOT_M, d.ground_m - 0.85);
    let mut openings = Vec::new();
    let (mut from, mut to) = (PIER_M, width - PIER_M);
    if !is_narrow {
        let at_left = s.chance(0.5);
        let has_gate = d.has_gate && to - from > 9.0;
        let entry = if has_gate { GATE_M } else { HOUSE_DOOR_M };
        let rect = if at_left { [from, from + entry, low, 0.0] } else { [to - entry, to, low, 0.0] };
        let (high, filling) = if has_gate { (3.1, Filling::Gate) } else { (2.45, Filling::Door) };
        openings.push(Opening { rect: [rect[0], rect[1], low, high], filling });
        if at_left { from += entry + PIER_M } else { to -= entry + PIER_M }
    }
    let count = ((to - from) / 5.5).round().max(1.0) as usize;
    let each = (to - from + PIER_M) / count as f32;
    for k in 0..count {
        let u = from + each * k as f32;
        let filling = Filling::Shop(Shop::draw(s));
        openings.push(Opening { rect: [u, u + each - PIER_M, low, top], filling });
    }
    openings
}

/// A ground floor of flats: windows higher over the street, and the door in one column.
fn flats(d: &CityDesign, columns: &[f32], is_narrow: bool, s: &mut Stream) -> Vec<Opening> {
    let door = (!is_narrow).then(|| s.below(columns.len()));
    let gate = if d.has_gate && columns.len() > 4 { door } else { None };
    let cell = if columns.len() > 1 { columns[1] - columns[0] } else { 3.0 };
    let half = (d.window.0 / 2.0).min(cell / 2.0 - 0.3);
    let opening = |k: usize, u: f32, s: &mut Stream| {
        let sill = FOOT_M + 1.2;
        if gate == Some(k) {
            let wide = (cell / 2.0 - 0.15).min(GATE_M / 2.0);
            Opening { rect: [u - wide, u + wide, FOOT_M, 3.0], filling: Filling::Gate }
        } else if door == Some(k) {
            Opening { rect: [u - 0.6, u + 0.6, FOOT_M, 2.5], filling: Filling::Door }
        } else {
            let top = (sill + d.window.1).min(d.ground_m - 0.35);
            Opening { rect: [u - half, u + half, sill, top], filling: Filling::draw_window(d.sashes, s) }
        }
    };
    columns.iter().enumerate().map(|(k, u)| opening(k, *u, s)).collect()
}

/// Stone about a window, with a lintel over those of the first floor.
fn surround(b: &mut MeshBuilder, plane: &WallPlane, opening: &Opening, ground_m: f32) {
    let [u0, u1, v0, v1] = opening.rect;
    let w = 0.15;
    for bar in [[u0 - w, u0, v0, v1], [u1, u1 + w, v0, v1], [u0 - w, u1 + w, v1, v1 + w + 0.05]] {
        plane.block(b, bar, -0.045, 0.0, slot::STONE);
    }
    if v0 < ground_m + 1.5 {
        plane.block(b, [u0 - w - 0.1, u1 + w + 0.1, v1 + 0.32, v1 + 0.44], -0.2, 0.0, slot::STONE);
    }
}

/// A slab on brackets with an iron railing.
fn balcony(b: &mut MeshBuilder, plane: &WallPlane, u: f32, floor: f32, detail: Detail) {
    let (u0, u1) = (u - 1.15, u + 1.15);
    plane.block(b, [u0, u1, floor - 0.16, floor], -BALCONY_M, 0.0, slot::STONE);
    for bracket in [u0 + 0.2, u1 - 0.35] {
        plane.block(b, [bracket, bracket + 0.15, floor - 0.5, floor - 0.16], -0.5, 0.0, slot::STONE);
    }
    let (rail, out) = (floor + 0.95, BALCONY_M - 0.06);
    for v in [floor + 0.08, rail] {
        plane.block(b, [u0, u1, v, v + 0.05], -out, -out + 0.04, slot::METAL);
        for end in [u0, u1 - 0.04] {
            plane.block(b, [end, end + 0.04, v, v + 0.05], -out, 0.0, slot::METAL);
        }
    }
    let bars = detail.pick(15, 7, 0);
    for k in 0..=bars {
        let at = u0 + (u1 - u0 - 0.025) * k as f32 / bars.max(1) as f32;
        plane.block(b, [at, at + 0.025, floor, rail], -out, -out + 0.025, slot::METAL);
    }
    let across = detail.pick(6, 3, 0);
    for end in [u0, u1 - 0.025] {
        for k in 1..across {
            let near = -out * k as f32 / across as f32;
            plane.block(b, [end, end + 0.025, floor, rail], near, near + 0.025, slot::METAL);
        }
    }
}

/// A bay over all upper floors but the last, with windows of its own.
fn draw_bay(b: &mut MeshBuilder, d: &CityDesign, plane: &WallPlane, u: f32, detail: Detail, s: &mut Stream) {
    let (u0, u1) = (u - d.column_m * 0.46, u + d.column_m * 0.46);
    let (low, high) = (d.floor(1) - 0.1, d.floor(d.stories - 1) + if d.stories > 3 { -0.1 } else { 2.9 });
    let width_m = u1 - u0;
    let front = WallPlane { origin: plane.at(u0, 0.0, -BAY_DEPTH_M), u: plane.u };
    let half = (d.window.0 * 0.6).min(width_m / 2.0 - 0.25);
    let mut openings = Vec::new();
    let mut story = 1;
    while d.floor(story) + 0.8 + d.window.1 + 0.1 < high && story < d.stories {
        let v = d.floor(story) + 0.8;
        let filling = Filling::Window { sashes: 2, shutter: 0.0, curtain: Curtain::draw(s, 0.5) };
        openings.push(Opening { rect: [width_m / 2.0 - half, width_m / 2.0 + half, v, v + d.window.1], filling });
        story += 1;
    }
    // Rooms of this depth would come out of the wall behind, where there is none to be seen.
    wall(b, &front, &WallShape::level(width_m, low, high, slot::STONE), &openings, detail);
    plane.sides(b, [u0, u1, low, high], 0.0, -BAY_DEPTH_M, slot::STONE);
    plane.block(b, [u0 - 0.08, u1 + 0.08, high, high + 0.12], -BAY_DEPTH_M - 0.08, 0.0, slot::METAL);
    plane.block(b, [u0 + 0.3, u1 - 0.3, low - 0.3, low], -BAY_DEPTH_M + 0.2, 0.0, slot::STONE);
}
