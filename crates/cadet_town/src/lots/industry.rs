//! Works and offices: a hall with a forecourt, a yard beside it, lawns with young trees, and fences with gates.

use crate::ground::land::YardSurface;
use crate::lots::{BEFORE_M, LotLayout, fitting};
use crate::network::SpotKind;
use crate::placement::Boundary;
use cadet_assets::props::{
    BILLBOARD, CRATES, PALLETS, PROFILES, PYLON, SHIPPING_CONTAINER, SITE_CONTAINER, SKIP, WIRE,
};
use cadet_assets::scenery::{HallKind, NARROW_HEDGES, TreeKind};
use cadet_base::math::DVec2;
use cadet_base::rng::Stream;

const BAY_M: (f64, f64) = (5.0, 2.5);
const SPOT_WIDTH_M: f64 = 1.95;
/// A truck's place in a yard.
const TRUCK_BAY_M: (f64, f64) = (11.5, 3.6);
/// Between what stands in a yard and its fence.
const AT_FENCE_M: f64 = 0.9;
const GATE_M: f64 = 7.0;

/// Lays one out.
pub(super) fn lay_out(length_m: f64, depth_m: f64, s: &mut Stream) -> LotLayout {
    let mut lot = LotLayout::default();
    let half = length_m / 2.0;
    let lawn_m = if s.chance(0.65) { s.range(2.5, 6.5) } else { 0.6 };
    let kind = s.pick(&[(HallKind::Works, 0.66), (HallKind::Office, 0.2), (HallKind::Market, 0.14)]);
    let court_m = if s.chance(0.7) { BAY_M.0 + 6.8 } else { s.range(4.0, 8.0) };
    let front = lawn_m + court_m;
    let yard_m = s.range(10.0, 18.0).min(length_m * 0.4);
    let is_left = s.chance(0.5);
    // The yard lies at one end of the lot, the hall fills what it can of the rest.
    let built = if is_left { [-half + yard_m, half - 1.2] } else { [-half + 1.2, half - yard_m] };
    let building = fitting(&[kind, HallKind::Office], built[1] - built[0], depth_m - front - 1.0, s);
    let mut yard = if is_left { [-half + AT_FENCE_M, built[0] - 0.8] } else { [built[1] + 0.8, half - AT_FENCE_M] };
    if let Some((kind, model)) = building {
        let width_m = model.footprint_size().y;
        let at_m = if is_left { built[1] - width_m / 2.0 } else { built[0] + width_m / 2.0 };
        if is_left {
            yard[1] = at_m - width_m / 2.0 - 0.8
        } else {
            yard[0] = at_m + width_m / 2.0 + 0.8
        }
        if court_m > BAY_M.0 {
            forecourt(&mut lot, [at_m - width_m / 2.0, at_m + width_m / 2.0], lawn_m, s);
        }
        lot.building(kind, model, at_m, front, s);
    }
    let gate = if is_left { yard[0] + 0.5 } else { yard[1] - GATE_M - 0.5 };
    lot.paved.push((YardSurface::Asphalt, [-half + 0.6, half - 0.6, lawn_m - 0.1, depth_m - 0.5]));
    lot.paved.push((YardSurface::Asphalt, [gate, gate + GATE_M, -BEFORE_M, lawn_m + 1.0]));
    goods(&mut lot, yard, (front, depth_m), is_left, s);
    lawn(&mut lot, half, lawn_m, [gate, gate + GATE_M], s);
    let wire = Boundary::fence(WIRE, s);
    let around = if s.chance(0.75) { wire } else { Boundary::Hedge(s.below(NARROW_HEDGES)) };
    for a in [-half + 0.35, half - 0.35] {
        lot.borders.push((around, DVec2::new(a, lawn_m + 0.2), DVec2::new(a, depth_m - 0.3)));
    }
    lot.border_along(around, [-half + 1.0, half - 1.0], depth_m - 0.3, &[]);
    if s.chance(0.45) {
        let d = lawn_m - 0.25;
        lot.border_along(wire, [-half + 0.6, half - 0.6], d.max(0.3), &[[gate - 0.2, gate + GATE_M + 0.2]]);
    }
    lot
}

/// Cars in a row before the building, noses to the street.
fn forecourt(lot: &mut LotLayout, [a0, a1]: [f64; 2], lawn_m: f64, s: &mut Stream) {
    let count = ((a1 - a0) / BAY_M.1) as usize;
    let from = a0 + (a1 - a0 - BAY_M.1 * count as f64) / 2.0;
    let d = lawn_m + 0.6;
    let first = s.below(3);
    for k in first..count {
        let a = from + BAY_M.1 * k as f64;
        lot.lines.push([DVec2::new(a, d + 0.1), DVec2::new(a, d + BAY_M.0 - 0.1)]);
        let at = DVec2::new(a + BAY_M.1 / 2.0, d + BAY_M.0 / 2.0 + 0.1);
        lot.bay(SpotKind::Lot, at, -DVec2::Y, (BAY_M.0 + 0.15, SPOT_WIDTH_M));
    }
    let a = from + BAY_M.1 * count as f64;
    lot.lines.push([DVec2::new(a, d + 0.1), DVec2::new(a, d + BAY_M.0 - 0.1)]);
    lot.walks.push((1.6, vec![DVec2::new(a0 + 1.0, d + BAY_M.0 + 3.0), DVec2::new(a1 - 1.0, d + BAY_M.0 + 3.0)]));
}

/// Along the fence of the yard: trucks and vans, containers, goods, skips.
fn goods(lot: &mut LotLayout, [a0, a1]: [f64; 2], (front, depth_m): (f64, f64), is_left: bool, s: &mut Stream) {
    let edge = if is_left { a0 } else { a1 };
    let inward = if is_left { DVec2::X } else { -DVec2::X };
    let room_m = a1 - a0;
    let mut d = front.max(9.0);
    while d < depth_m - 10.3 {
        let at = |across_m: f64, along_m: f64| DVec2::new(edge, d + along_m) + inward * across_m;
        match s.weighted(&[0.3, 0.2, 0.18, 0.12, 0.1, 0.1]) {
            0 if room_m > TRUCK_BAY_M.0 - 1.0 => {
                // Square to the fence, where it does not reach the hall.
                let count = 1 + s.below(3);
                for k in 0..count {
                    let along_m = TRUCK_BAY_M.1 * (k as f64 + 0.5);
                    if d + along_m > depth_m - 2.5 {
                        break;
                    }
                    let length_m = TRUCK_BAY_M.0.min(room_m - 0.6);
                    lot.bay(SpotKind::Yard, at(length_m / 2.0, along_m), -inward, (length_m, 2.9));
                }
                d += TRUCK_BAY_M.1 * count as f64 + 0.8;
            }
            0 | 1 => {
                let heading = if s.chance(0.5) { DVec2::Y } else { -DVec2::Y };
                lot.bay(SpotKind::Yard, at(1.6, 4.6), heading, (8.8, 2.8));
                d += 9.8;
            }
            2 => {
                let rows = 1 + s.below(2);
                for k in 0..rows {
                    lot.prop(SHIPPING_CONTAINER, at(1.4 + 2.6 * k as f64, 3.2), DVec2::Y, s);
                }
                d += 7.0;
            }
            3 => {
                lot.prop(CRATES, at(1.2, 2.2), inward, s);
                d += 4.8;
            }
            4 => {
                lot.prop(PROFILES, at(1.1, 3.0), inward, s);
                d += 6.6;
            }
            _ => {
                let kind = [SKIP, SITE_CONTAINER, PALLETS][s.below(3)];
                lot.prop(kind, at(1.7, 3.2), inward, s);
                d += 7.0;
            }
        }
    }
}

/// Grass along the street with young trees, shrubs, and a sign or a poster.
fn lawn(lot: &mut LotLayout, half: f64, lawn_m: f64, gate: [f64; 2], s: &mut Stream) {
    if lawn_m < 2.0 {
        return;
    }
    let is_off = |p: DVec2| p.x < gate[0] - 1.5 || p.x > gate[1] + 1.5;
    if s.chance(0.7) {
        let spacing_m = s.range(7.0, 12.0);
        lot.tree_line([-half, half].map(|a| DVec2::new(a, lawn_m * 0.5)), spacing_m, s, is_off);
    }
    for _ in 0..s.below(5) {
        let at = DVec2::new(s.range(-half + 1.5, half - 1.5), s.range(1.0, lawn_m - 0.8));
        if is_off(at) {
            lot.trees.push((TreeKind::Shrub, at));
        }
    }
    let beside = if gate[0] > 0.0 { gate[0] - 2.5 } else { gate[1] + 2.5 };
    if s.chance(0.5) {
        lot.prop(PYLON, DVec2::new(beside, 1.3), DVec2::X, s);
    } else if s.chance(0.5) {
        lot.prop(BILLBOARD, DVec2::new(beside, 1.2), -DVec2::Y + DVec2::X * s.range(-0.4, 0.4), s);
    }
}
