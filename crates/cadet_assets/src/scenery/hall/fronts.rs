//! The walls of large buildings: openings, cladding, signs.

use super::super::Detail;
use super::super::city::{Shop, city_slot, write_name};
use super::super::draw::range;
use super::super::facade::{Curtain, Filling, Opening, WallShape, wall};
use super::super::materials::house_slot as slot;
use super::super::wall_plane::WallPlane;
use super::{Cladding, FOOT_M, HallDesign, HallKind, parts};
use cadet_base::geometry::MeshBuilder;
use cadet_base::math::Vec3;
use cadet_base::rng::Stream;

/// What signs say.
const MARKETS: [&str; 5] = ["MARKT", "BAUMARKT", "DROGERIE", "MOEBEL", "GETRAENKE"];
const WORKS: [&str; 7] = ["METALLBAU", "SPEDITION", "REIFEN", "DRUCKEREI", "LAGERHAUS", "ELEKTRO", "KUNSTSTOFFE"];
/// Width and height of a roller gate, and of a dock's.
const GATE_M: (f32, f32) = (4.0, 4.3);
const DOCK_M: (f32, f32) = (2.7, 2.8);
/// Height of a dock's floor over the ground.
const DOCK_FLOOR_M: f32 = 1.15;
/// Pitch and depth of ribs, and height of panels.
const RIB_PITCH_M: f32 = 0.62;
const RIB_DEPTH_M: f32 = 0.045;
const PANEL_M: f32 = 1.1;
const DOOR_M: (f32, f32) = (1.1, 2.2);

/// Draws the wall of a side: 0 is the front, 2 the back.
pub(super) fn draw(
    b: &mut MeshBuilder,
    d: &HallDesign,
    plane: &WallPlane,
    (width_m, rise_m): (f32, f32),
    side: usize,
    detail: Detail,
) {
    // The same stream for every level of detail: the same openings.
    let mut s = Stream::from_seed("hall front", d.seed ^ side as u64);
    let openings = match d.kind {
        HallKind::Market => market(d, width_m, side, &mut s),
        HallKind::Works => works(d, width_m, side, &mut s),
        HallKind::Office | HallKind::Institute => floors(d, width_m, side, &mut s),
    };
    let apex_m = d.eaves_m + rise_m;
    let shape = WallShape { width_m, bottom_m: FOOT_M, eaves_m: d.eaves_m, apex_m, face: slot::WALL };
    wall(b, plane, &shape, &openings, detail);
    if detail != Detail::Far {
        clad(b, d, plane, width_m, &openings, detail);
        if side != 0 || d.kind != HallKind::Market {
            plane.block(b, [0.0, width_m, FOOT_M, 0.12], -0.03, 0.0, slot::PLINTH);
        }
        for end in [0.12, width_m - 0.12] {
            let foot = plane.at(end, -0.3, -0.1);
            b.tube(&[(foot, 0.06), (foot + Vec3::Z * (d.eaves_m + 0.2), 0.06)], 5, slot::METAL);
        }
    }
    if side == 0 {
        sign(b, d, plane, width_m, &mut s, detail);
    }
    let docks = openings.iter().filter(|o| o.rect[2] > 0.5 && o.filling == Filling::RollerGate);
    docks.for_each(|o| parts::dock(b, plane, o.rect));
}

fn market(d: &HallDesign, width: f32, side: usize, s: &mut Stream) -> Vec<Opening> {
    let mut openings = Vec::new();
    match side {
        0 => {
            // A glass front about a third of the way, at one end or in the middle.
            let count = ((width * 0.45) / 4.6).floor().max(2.0);
            let from = (width - count * 4.6) * [0.06_f32, 0.5, 0.94][s.below(3)];
            for k in 0..count as usize {
                let u = from + 4.6 * k as f32;
                let mut shop = Shop::draw(s);
                (shop.has_awning, shop.has_hanging_sign, shop.sill_m) = (false, false, 0.35);
                openings.push(Opening { rect: [u + 0.15, u + 4.45, 0.1, 3.05], filling: Filling::Shop(shop) });
            }
        }
        2 => {
            let u = width * range(s, 0.3, 0.6);
            openings.push(gate([u, DOCK_FLOOR_M], DOCK_M));
            openings.push(door(u - 4.0));
        }
        _ => {
            let count = (width / 6.0) as usize;
            for k in 0..count {
                let u = 6.0 * (k as f32 + 0.4);
                openings.push(window([u, u + 2.2, d.eaves_m - 2.6, d.eaves_m - 1.7], 2));
            }
        }
    }
    openings
}

fn works(d: &HallDesign, width: f32, side: usize, s: &mut Stream) -> Vec<Opening> {
    let mut openings = Vec::new();
    let has_gates = side != 2 && (side == 0 || s.chance(0.5));
    if has_gates {
        let has_docks = s.chance(0.35);
        let size = if has_docks { DOCK_M } else { (GATE_M.0, GATE_M.1.min(d.eaves_m - 1.8)) };
        let most = ((width - 3.0) / (size.0 + 2.2)) as usize;
        let count = (1 + s.below(4)).min(most);
        let from = range(s, 1.2, (width - (size.0 + 2.2) * count as f32).max(1.3));
        for k in 0..count {
            let low = if has_docks { DOCK_FLOOR_M } else { 0.05 };
            openings.push(gate([from + (size.0 + 2.2) * k as f32, low], size));
        }
        let u = if from > 2.6 { from - 1.9 } else { from + (size.0 + 2.2) * count as f32 + 0.4 };
        if u > 0.5 && u + DOOR_M.0 < width - 0.5 {
            openings.push(door(u));
        }
    }
    // A band of windows below the eaves.
    if s.chance(0.75) && d.eaves_m > 6.6 {
        let (low, high) = (d.eaves_m - 1.75, d.eaves_m - 0.65);
        let count = ((width - 1.6) / 2.5) as usize;
        let from = (width - 2.5 * count as f32) / 2.0;
        for k in 0..count {
            let u = from + 2.5 * k as f32;
            openings.push(window([u + 0.08, u + 2.42, low, high], 2));
        }
    }
    openings
}

/// Bands of windows, floor over floor; institutes have a stairwell of glass.
fn floors(d: &HallDesign, width: f32, side: usize, s: &mut Stream) -> Vec<Opening> {
    let mut openings = Vec::new();
    let is_end = side % 2 == 1;
    let pitch = range(s, 1.7, 2.6);
    let pier = if s.chance(0.6) { 0.14 } else { 0.5 };
    let count = ((width - 1.0) / pitch) as usize;
    let from = (width - pitch * count as f32) / 2.0;
    let stair = (d.kind == HallKind::Institute && side == 0).then(|| 1 + s.below(count.saturating_sub(3).max(1)));
    let entrance = if side == 0 { s.below(count.max(1)) } else { usize::MAX };
    let (sill, head) = (range(s, 0.75, 1.0), range(s, 2.45, 2.75));
    for k in 0..count {
        let u = from + pitch * k as f32;
        if stair.is_some_and(|at| k == at || k == at + 1) {
            continue;
        }
        for story in 0..d.floors {
            // End walls have windows in the middle alone.
            if is_end && !(count / 3..=2 * count / 3).contains(&k) {
                continue;
            }
            let z = d.floor(story);
            if story == 0 && k == entrance {
                let (low, high) = (z, z + 2.3);
                openings.push(Opening { rect: [u + 0.2, u + 1.4, low, high], filling: Filling::Door });
                continue;
            }
            let curtain = Curtain::draw(s, 0.3);
            let shutter = if s.chance(0.15) { [0.3, 0.6, 1.0][s.below(3)] } else { 0.0 };
            let filling = Filling::Window { sashes: 1, shutter, curtain };
            openings.push(Opening { rect: [u + pier / 2.0, u + pitch - pier / 2.0, z + sill, z + head], filling });
        }
    }
    if let Some(at) = stair {
        let u = from + pitch * at as f32;
        let step = (d.eaves_m - 0.7) / (2 * d.floors) as f32;
        for k in 0..2 * d.floors {
            let low = 0.15 + step * k as f32;
            openings.push(window([u + 0.1, u + 2.0 * pitch - 0.1, low, low + step - 0.06], 2));
        }
    }
    openings
}

fn gate([u, v]: [f32; 2], (w, h): (f32, f32)) -> Opening {
    Opening { rect: [u, u + w, v, v + h], filling: Filling::RollerGate }
}

fn door(u: f32) -> Opening {
    Opening { rect: [u, u + DOOR_M.0, 0.05, DOOR_M.1], filling: Filling::Door }
}

fn window(rect: [f32; 4], sashes: u8) -> Opening {
    Opening { rect, filling: Filling::Window { sashes, shutter: 0.0, curtain: Curtain::None } }
}

/// Ribs or seams where nothing opens.
fn clad(b: &mut MeshBuilder, d: &HallDesign, plane: &WallPlane, width: f32, openings: &[Opening], detail: Detail) {
    match d.cladding {
        Cladding::Sheet if detail == Detail::Near => {
            let count = ((width - 0.6) / RIB_PITCH_M) as usize;
            let from = (width - RIB_PITCH_M * count as f32) / 2.0;
            for k in 0..count {
                let u = from + RIB_PITCH_M * k as f32;
                for [low, high] in free(openings, [u - 0.05, u + 0.36], [0.14, d.eaves_m - 0.15], 1) {
                    plane.block(b, [u, u + 0.31, low, high], -RIB_DEPTH_M, 0.0, slot::WALL);
                }
            }
        }
        Cladding::Panels => {
            let rows = ((d.eaves_m - 0.5) / PANEL_M) as usize;
            for k in 1..=rows {
                let v = 0.1 + PANEL_M * k as f32;
                for [u0, u1] in free(openings, [v - 0.1, v + 0.1], [0.0, width], 0) {
                    plane.rect(b, [u0, u1, v, v + 0.035], -0.004, city_slot::BASE);
                }
            }
        }
        Cladding::Plain if d.has_floors() => {
            for story in 1..d.floors {
                let v = d.floor(story);
                for [u0, u1] in free(openings, [v - 0.3, v + 0.3], [0.0, width], 0) {
                    plane.rect(b, [u0, u1, v - 0.02, v + 0.02], -0.004, slot::STONE);
                }
            }
        }
        _ => {}
    }
}

/// What openings leave of [from, to] along one axis (0: along the wall, 1: upright) within a strip across it.
fn free(openings: &[Opening], strip: [f32; 2], whole: [f32; 2], axis: usize) -> Vec<[f32; 2]> {
    let across = |o: &&Opening| {
        let (low, high) = if axis == 0 { (o.rect[2], o.rect[3]) } else { (o.rect[0], o.rect[1]) };
        low < strip[1] && high > strip[0]
    };
    let mut cuts: Vec<[f32; 2]> = openings
        .iter()
        .filter(across)
        .map(|o| if axis == 0 { [o.rect[0], o.rect[1]] } else { [o.rect[2], o.rect[3]] })
        .collect();
    cuts.sort_by(|a, c| a[0].total_cmp(&c[0]));
    let (mut left, mut from) = (Vec::new(), whole[0]);
    for cut in cuts {
        if cut[0] - 0.12 > from + 0.2 {
            left.push([from, cut[0] - 0.12]);
        }
        from = from.max(cut[1] + 0.12);
    }
    if whole[1] > from + 0.2 {
        left.push([from, whole[1]]);
    }
    left
}

/// The band over the entrance of a market, or a company's name under the eaves.
fn sign(b: &mut MeshBuilder, d: &HallDesign, plane: &WallPlane, width: f32, s: &mut Stream, detail: Detail) {
    let (name, [u0, u1, v0, v1]) = match d.kind {
        HallKind::Market => {
            // The edge of the roof runs along the whole front, over a canopy.
            plane.block(b, [0.0, width, 3.3, 3.55], -1.4, 0.0, slot::METAL);
            plane.block(b, [0.0, width, 3.55, 4.55], -0.25, 0.0, city_slot::SIGN);
            let at = width * range(s, 0.25, 0.75);
            (MARKETS[s.below(MARKETS.len())], [at - 4.0, at + 4.0, 3.7, 4.4])
        }
        HallKind::Works if d.eaves_m > 7.4 => {
            let (half, at) = (range(s, 2.5, 5.0), width * range(s, 0.3, 0.7));
            let top = d.eaves_m - 1.95;
            (WORKS[s.below(WORKS.len())], [at - half, at + half, top - 1.0, top])
        }
        _ => return,
    };
    if d.kind == HallKind::Works {
        plane.block(b, [u0 - 0.3, u1 + 0.3, v0 - 0.15, v1 + 0.15], -0.25, 0.0, city_slot::SIGN);
    }
    if detail != Detail::Far {
        write_name(b, plane, name, [u0, u1], [v0 + 0.05, v1 - 0.05], -0.25);
    }
}
