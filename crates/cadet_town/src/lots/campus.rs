//! Institutes: set back behind lawns with large trees, a paved way to the door, racks of bicycles, benches.

use crate::ground::land::YardSurface;
use crate::lots::{BEFORE_M, LotLayout, fitting};
use crate::placement::Boundary;
use cadet_assets::props::{BENCH, BICYCLE, CYCLE_HOOP, TUB};
use cadet_assets::scenery::{HallKind, NARROW_HEDGES, TreeKind};
use cadet_base::math::DVec2;
use cadet_base::rng::Stream;

/// Width of the way to a door.
const WAY_M: f64 = 3.0;

/// Lays one out.
pub(super) fn lay_out(length_m: f64, depth_m: f64, s: &mut Stream) -> LotLayout {
    let mut lot = LotLayout::default();
    let half = length_m / 2.0;
    let setback_m = s.range(6.0, 14.0);
    let kinds = [HallKind::Institute, HallKind::Office];
    let building = fitting(&kinds, length_m - 3.0, depth_m - setback_m - 2.0, s);
    let way_m = s.range(-0.3, 0.3) * length_m;
    // A plaza in place of the lawn, now and then.
    let is_plaza = s.chance(0.3);
    let surface = if s.chance(0.5) { YardSurface::Slabs } else { YardSurface::Pavers };
    let paved = if is_plaza { [-half + 1.0, half - 1.0] } else { [way_m - WAY_M / 2.0, way_m + WAY_M / 2.0] };
    lot.paved.push((surface, [paved[0], paved[1], -BEFORE_M, setback_m - 0.1]));
    if let Some((kind, model)) = building {
        let free_m = (length_m - 2.0 - model.footprint_size().y) / 2.0;
        let at_m = s.range(-free_m, free_m);
        lot.walks.push((1.6, vec![DVec2::new(way_m, 0.8), DVec2::new(way_m, setback_m - 1.2)]));
        lot.building(kind, model, at_m, setback_m, s);
    }
    let mut taken = vec![[way_m - WAY_M / 2.0 - 0.6, way_m + WAY_M / 2.0 + 0.6]];
    racks(&mut lot, half, &mut taken, s);
    benches(&mut lot, half, &mut taken, s);
    if !is_plaza || s.chance(0.5) {
        trees(&mut lot, (half, setback_m), &taken, s);
    }
    if s.chance(0.3) {
        let hedge = Boundary::Hedge(s.below(NARROW_HEDGES));
        lot.border_along(hedge, [-half + 1.0, half - 1.0], 4.3, &[[paved[0] - 0.5, paved[1] + 0.5]]);
    }
    lot
}

/// Whether [from, to] along the front is free, and takes it.
fn take(taken: &mut Vec<[f64; 2]>, [from, to]: [f64; 2]) -> bool {
    let is_free = taken.iter().all(|t| to < t[0] || from > t[1]);
    if is_free {
        taken.push([from, to]);
    }
    is_free
}

/// Hoops in a row with bicycles at most of them, square to the street.
fn racks(lot: &mut LotLayout, half: f64, taken: &mut Vec<[f64; 2]>, s: &mut Stream) {
    for _ in 0..1 + s.below(3) {
        let count = 6 + s.below(12);
        let length_m = 0.8 * count as f64;
        let from = s.range(-half + 1.2, (half - 1.2 - length_m).max(-half + 1.3));
        if from + length_m > half - 1.0 || !take(taken, [from - 0.5, from + length_m + 0.5]) {
            continue;
        }
        let fullness = s.range(0.5, 0.95);
        lot.paved.push((YardSurface::Pavers, [from - 0.3, from + length_m + 0.3, -BEFORE_M, 2.9]));
        for k in 0..count {
            let a = from + 0.8 * (k as f64 + 0.5);
            lot.prop(CYCLE_HOOP, DVec2::new(a, 1.7), DVec2::X, s);
            if s.chance(fullness) {
                let facing = if s.chance(0.8) { DVec2::Y } else { -DVec2::Y };
                let at = DVec2::new(a + 0.36, 1.7 + s.range(-0.12, 0.12));
                lot.prop(BICYCLE, at, facing + DVec2::X * s.range(-0.06, 0.06), s);
            }
        }
    }
}

fn benches(lot: &mut LotLayout, half: f64, taken: &mut Vec<[f64; 2]>, s: &mut Stream) {
    for _ in 0..1 + s.below(4) {
        let a = s.range(-half + 2.0, half - 2.0);
        if !take(taken, [a - 1.3, a + 1.3]) {
            continue;
        }
        lot.prop(BENCH, DVec2::new(a, 0.9), -DVec2::Y, s);
        if s.chance(0.4) {
            lot.prop(TUB, DVec2::new(a + 2.2, 0.9), -DVec2::Y, s);
        }
    }
}

/// Large ones on the lawn, and shrubs at the wall.
fn trees(lot: &mut LotLayout, (half, setback_m): (f64, f64), taken: &[[f64; 2]], s: &mut Stream) {
    let count = 2 + s.below(2 + (half / 5.0) as usize);
    for _ in 0..count {
        let at = DVec2::new(s.range(-half + 2.5, half - 2.5), s.range(3.4, (setback_m - 2.5).max(3.6)));
        let is_off = taken[..1].iter().all(|t| at.x < t[0] - 0.5 || at.x > t[1] + 0.5);
        if is_off {
            let kind = if s.chance(0.7) { TreeKind::Wood } else { TreeKind::Garden };
            lot.trees.push((kind, at));
        }
    }
    for _ in 0..2 + s.below(6) {
        let at = DVec2::new(s.range(-half + 1.5, half - 1.5), setback_m - s.range(1.4, 1.9));
        let is_off = taken[..1].iter().all(|t| at.x < t[0] - 1.5 || at.x > t[1] + 1.5);
        if is_off {
            lot.trees.push((TreeKind::Shrub, at));
        }
    }
}
