//! Car parks: rows of bays along aisles, islands with trees, hedges about them, and a market behind some.

use crate::ground::land::YardSurface;
use crate::lots::{BEFORE_M, LotLayout, fitting};
use crate::network::SpotKind;
use crate::placement::Boundary;
use cadet_assets::props::{ISLAND, PYLON, TALL_LAMP, TROLLEY_SHELTER, WALL, WIRE};
use cadet_assets::scenery::{HallKind, NARROW_HEDGES, TreeKind};
use cadet_base::math::DVec2;
use cadet_base::rng::Stream;

/// A bay and an aisle (EAR 05: 2.5 m by 5.0 m, aisles of 6.0 m).
const BAY_M: (f64, f64) = (5.0, 2.5);
const AISLE_M: f64 = 6.0;
/// Two rows with their aisle.
const MODULE_M: f64 = 2.0 * BAY_M.0 + AISLE_M;
/// A hedge or a wall and what is beside it.
const EDGE_M: f64 = 1.15;
/// Of the walk before a market.
const BEFORE_MARKET_M: f64 = 3.2;
/// Bays between two islands.
const BETWEEN_ISLANDS: (usize, usize) = (8, 13);
const WALK_M: f64 = 2.6;
/// Room for a car beside the lines.
const SPOT_WIDTH_M: f64 = 1.95;

/// Rows along the street or across to it.
#[derive(Clone, Copy)]
struct Axes {
    is_across: bool,
}

impl Axes {
    /// The place `u` along rows and `w` across them.
    fn at(self, u: f64, w: f64) -> DVec2 {
        if self.is_across { DVec2::new(w, u) } else { DVec2::new(u, w) }
    }
}

/// Lays one out. `is_aisle`: the street itself is one, and rows begin right behind its walk.
pub(super) fn lay_out(length_m: f64, depth_m: f64, is_aisle: bool, s: &mut Stream) -> LotLayout {
    let mut lot = LotLayout::default();
    let half = length_m / 2.0;
    let front = if is_aisle { 0.3 } else { s.range(1.7, 3.4) };
    let (a0, a1) = (-half + EDGE_M, half - EDGE_M);
    let wants_market = s.chance(0.6);
    let room_m = depth_m - front - MODULE_M - BEFORE_MARKET_M - 0.6;
    let market = if wants_market { fitting(&[HallKind::Market], length_m - 1.5, room_m, s) } else { None };
    let behind_m = market.as_ref().map_or(EDGE_M, |(_, m)| m.footprint_size().x + BEFORE_MARKET_M + 0.4);
    let rows_m = depth_m - front - behind_m;
    let is_across = rows_m > 22.0 && s.chance(0.4);
    let axes = Axes { is_across };
    let mut entries = Vec::new();
    if is_across {
        let count = ((a1 - a0) / MODULE_M) as usize;
        let from = -(count as f64) * MODULE_M / 2.0;
        for k in 0..count {
            let w = from + MODULE_M * k as f64;
            module(&mut lot, axes, [front + 0.2, front + rows_m], (w, true), k == 0, s);
            let middle = w + MODULE_M / 2.0;
            entries.push([middle - AISLE_M / 2.0, middle + AISLE_M / 2.0]);
            let end = front + rows_m - if market.is_some() { -1.4 } else { 1.5 };
            lot.walks.push((WALK_M, vec![DVec2::new(middle, 0.7), DVec2::new(middle, end)]));
        }
    } else {
        let is_left = s.chance(0.5);
        let cross = if is_left { [a0, a0 + AISLE_M] } else { [a1 - AISLE_M, a1] };
        let rows = if is_left { [cross[1], a1] } else { [a0, cross[0]] };
        let count = ((rows_m / MODULE_M) as usize).max(1);
        for k in 0..count {
            let w = front + MODULE_M * k as f64;
            module(&mut lot, axes, rows, (w, rows_m >= MODULE_M - 0.1), k == 0, s);
            let (middle, aisle) = ((cross[0] + cross[1]) / 2.0, w + BAY_M.0 + AISLE_M / 2.0);
            let end = if is_left { rows[1] - 2.0 } else { rows[0] + 2.0 };
            let line = vec![DVec2::new(middle, 0.7), DVec2::new(middle, aisle), DVec2::new(end, aisle)];
            lot.walks.push((WALK_M, line));
        }
        entries.push(cross);
    }
    if let Some((kind, market)) = market {
        let free_m = (length_m - 1.0 - market.footprint_size().y) / 2.0;
        let at_m = s.range(-free_m, free_m);
        lot.building(kind, market, at_m, depth_m - behind_m + BEFORE_MARKET_M, s);
        lot.prop(PYLON, DVec2::new(entries[0][0] - 0.2, 1.0), DVec2::X, s);
    }
    let surface = if s.chance(0.8) { YardSurface::Asphalt } else { YardSurface::Pavers };
    let (p0, p1) = (a0 - 0.2, a1 + 0.2);
    if is_aisle {
        lot.paved.push((surface, [p0, p1, -BEFORE_M, depth_m - 0.4]));
    } else {
        lot.paved.push((surface, [p0, p1, front - 0.15, depth_m - 0.4]));
        lot.paved.extend(entries.iter().map(|e| (surface, [e[0], e[1], -BEFORE_M, front + 1.0])));
    }
    edges(&mut lot, [-half, half], (front, depth_m, behind_m), (is_aisle, &entries), s);
    lot
}

/// Two rows with an aisle between them, or one where there is no room for both, from `w` on across.
fn module(
    lot: &mut LotLayout,
    axes: Axes,
    along: [f64; 2],
    (w, has_both): (f64, bool),
    has_trolleys: bool,
    s: &mut Stream,
) {
    let trolleys = has_trolleys && s.chance(0.6);
    row(lot, axes, along, (w, -1.0), trolleys, s);
    if has_both {
        row(lot, axes, along, (w + BAY_M.0 + AISLE_M, 1.0), false, s);
    }
}

/// One row of bays, noses toward `side`.
fn row(lot: &mut LotLayout, axes: Axes, [u0, u1]: [f64; 2], (w, side): (f64, f64), has_trolleys: bool, s: &mut Stream) {
    let count = ((u1 - u0) / BAY_M.1 + 1e-9) as usize;
    let from = u0 + (u1 - u0 - BAY_M.1 * count as f64) / 2.0;
    let heading = axes.at(0.0, side);
    let every = BETWEEN_ISLANDS.0 + s.below(BETWEEN_ISLANDS.1 - BETWEEN_ISLANDS.0);
    let has_islands = s.chance(0.75);
    let trolleys_at = if has_trolleys { 2 + s.below(count.saturating_sub(4).max(1)) } else { usize::MAX };
    let mut was_bay = false;
    for k in 0..count {
        let u = from + BAY_M.1 * (k as f64 + 0.5);
        let at = axes.at(u, w + BAY_M.0 / 2.0);
        let is_end = k == 0 || k + 1 == count;
        let is_island = has_islands && (is_end || k % every == every / 2) && k != trolleys_at;
        let is_bay = !is_island && k != trolleys_at;
        if is_bay || was_bay {
            lot.lines.push(line(axes, u - BAY_M.1 / 2.0, w));
        }
        if is_bay && k + 1 == count {
            lot.lines.push(line(axes, u + BAY_M.1 / 2.0, w));
        }
        was_bay = is_bay;
        if is_bay {
            // Long cars reach into the aisle, not over their neighbors' noses.
            lot.bay(SpotKind::Lot, at - heading * 0.1, heading, (BAY_M.0 + 0.15, SPOT_WIDTH_M));
        } else if is_island {
            lot.prop(ISLAND, at, heading, s);
            let (has_tree, has_lamp) = (s.chance(0.75), s.chance(0.4));
            if has_tree {
                lot.trees.push((TreeKind::Street, at + heading * 0.6));
            }
            if has_lamp {
                let ahead = if has_tree { heading * -1.7 } else { DVec2::ZERO };
                lot.prop(TALL_LAMP, at + ahead, heading, s);
            }
        } else {
            lot.prop(TROLLEY_SHELTER, at, -heading, s);
        }
    }
}

fn line(axes: Axes, u: f64, w: f64) -> [DVec2; 2] {
    [axes.at(u, w + 0.1), axes.at(u, w + BAY_M.0 - 0.1)]
}

/// Hedges, fences, or low walls about it, and trees along the street.
fn edges(
    lot: &mut LotLayout,
    [left, right]: [f64; 2],
    (front, depth_m, behind_m): (f64, f64, f64),
    (is_aisle, entries): (bool, &[[f64; 2]]),
    s: &mut Stream,
) {
    let mut border = || match s.weighted(&[0.6, 0.15, 0.1, 0.15]) {
        0 => Boundary::Hedge(s.below(NARROW_HEDGES)),
        1 => Boundary::fence(WIRE, s),
        2 => Boundary::fence(WALL, s),
        _ => Boundary::Open,
    };
    let (beside, along) = (border(), border());
    let inset = 0.5;
    let (d0, d1) = (front + 0.2, depth_m - behind_m);
    for a in [left + inset, right - inset] {
        lot.borders.push((beside, DVec2::new(a, d0), DVec2::new(a, d1)));
    }
    if behind_m <= EDGE_M {
        lot.border_along(beside, [left + 1.0, right - 1.0], depth_m - inset, &[]);
    }
    if is_aisle {
        return;
    }
    let gaps: Vec<[f64; 2]> = entries.iter().map(|e| [e[0] - 1.2, e[1] + 0.6]).collect();
    lot.border_along(along, [left + 1.0, right - 1.0], front - 0.6, &gaps);
    if s.chance(0.6) && front > 2.2 {
        let spacing_m = s.range(8.0, 13.0);
        let ends = [left + 1.0, right - 1.0].map(|a| DVec2::new(a, front - 1.7));
        lot.tree_line(ends, spacing_m, s, |p| gaps.iter().all(|g| p.x < g[0] - 0.4 || p.x > g[1] + 0.4));
    }
}
