//! Shapes in plan: strips of lanes, and what is made of them.
//!
//! Boolean operations and offsets run on integers of 1 mm (crate `i_overlay`), which makes them exact in topology and
//! the same on every machine.

use i_overlay::core::fill_rule::FillRule;
use i_overlay::core::overlay::{IntOverlayOptions, Overlay, ShapeType};
use i_overlay::core::overlay_rule::OverlayRule;
use i_overlay::core::solver::Solver;
use i_overlay::i_float::int::angle::Angle;
use i_overlay::i_float::int::point::IntPoint;
use i_overlay::mesh::int::arc::ArcOptions;
use i_overlay::mesh::int::outline::offset::IntOutlineOffset;
use i_overlay::mesh::int::style::{IntLineJoin, IntOutlineStyle};

use crate::network::Lane;
use cadet_base::math::DVec2;
use cadet_base::plane::{bounds, edges};

/// A closed line: outer boundaries run counter-clockwise, holes clockwise; the first point is not repeated.
pub(crate) type Ring = Vec<DVec2>;

pub(crate) type Contour = Vec<IntPoint<i32>>;
pub(crate) type Shapes = Vec<Vec<Contour>>;

const UNITS_PER_M: f64 = 1e3;
/// Strips are this much too wide to either side until cracks are closed: edges that two lanes share would else cross each
/// other again and again within their rounding.
pub(crate) const WIDEN_M: f64 = 0.02;
/// Corners that stand out less are straightened: in outlines, and between the steps that lead to them.
const STRAIGHT_M: f64 = 0.015;
const STRAIGHT_BETWEEN_M: f64 = 0.008;

/// Meters to integers and back.
pub(crate) struct Frame {
    pub(crate) origin: DVec2,
}

impl Frame {
    pub(crate) fn point(&self, p: DVec2) -> IntPoint<i32> {
        let q = ((p - self.origin) * UNITS_PER_M).round();
        IntPoint::new(q.x as i32, q.y as i32)
    }

    pub(crate) fn strip(&self, lane: &Lane) -> Option<Contour> {
        let n = lane.center.len();
        let at = |i: usize| lane.center[i].truncate();
        // Where a lane closes on itself its ends have one direction.
        let is_closed = lane.is_closed();
        let side = |i: usize| {
            let is_seam = is_closed && (i == 0 || i == n - 1);
            let (before, after) = if is_seam { (n - 2, 1) } else { (i.saturating_sub(1), (i + 1).min(n - 1)) };
            let along = (at(after) - at(before)).normalize_or_zero();
            along.perp() * (lane.width_m[i] / 2.0 + WIDEN_M)
        };
        let right = (0..n).map(|i| self.point(at(i) - side(i)));
        let left = (0..n).rev().map(|i| self.point(at(i) + side(i)));
        let ring = thin_out(&right.chain(left).collect::<Contour>(), STRAIGHT_BETWEEN_M);
        (ring.len() >= 3).then_some(ring)
    }

    pub(crate) fn rings(&self, shapes: &Shapes) -> Vec<Ring> {
        shapes.iter().flatten().map(|c| self.ring(c)).filter(|r| r.len() >= 3).collect()
    }

    fn ring(&self, contour: &[IntPoint<i32>]) -> Ring {
        thin_out(contour, STRAIGHT_M)
            .iter()
            .map(|p| DVec2::new(p.x.into(), p.y.into()) / UNITS_PER_M + self.origin)
            .collect()
    }
}

pub(crate) fn union(contours: &[Contour]) -> Shapes {
    let num_points = contours.iter().map(Vec::len).sum();
    let mut overlay = Overlay::new_custom(num_points, IntOverlayOptions::default(), Solver::FRAG);
    overlay.add_source(contours, ShapeType::Subject);
    overlay.overlay(OverlayRule::Subject, FillRule::NonZero)
}

/// What a set of outlines leaves of another.
pub(crate) fn difference(from: &[Contour], taken: &[Contour]) -> Shapes {
    let mut overlay = Overlay::new_custom(from.len() + 64, IntOverlayOptions::default(), Solver::FRAG);
    overlay.add_source(from, ShapeType::Subject);
    overlay.add_source(taken, ShapeType::Clip);
    overlay.overlay(OverlayRule::Difference, FillRule::NonZero)
}

/// Moves outlines out by `distance_m` (in where negative), round at the corners.
pub(crate) fn grow(shapes: &Shapes, distance_m: f64) -> Shapes {
    // 20 degrees round small corners, 12 round others: polygons within 1 cm of their arcs.
    let max_step = Angle::from_bits((1_u32 << 31) / if distance_m.abs() < 0.6 { 9 } else { 15 });
    let join = IntLineJoin::Round(ArcOptions { max_step, ..ArcOptions::default() });
    let style = IntOutlineStyle::new((distance_m * UNITS_PER_M).round() as i32).line_join(join);
    let mut grown = shapes.outline(&style).unwrap_or_default();
    grown.iter_mut().flatten().for_each(|c| *c = thin_out(c, STRAIGHT_BETWEEN_M));
    grown
}

/// Closes cracks narrower than twice `crack_m`, takes off what strips are too wide, and fills holes below `hole_m2`.
pub(crate) fn clean(shapes: Shapes, crack_m: f64, hole_m2: f64) -> Shapes {
    let mut closed = grow(&grow(&shapes, crack_m), -crack_m - WIDEN_M);
    for shape in &mut closed {
        let mut index = 0;
        shape.retain(|contour| {
            index += 1;
            index == 1 || area_m2(contour).abs() >= hole_m2
        });
    }
    closed.retain(|shape| shape.first().is_some_and(|outer| area_m2(outer).abs() > 1.0));
    closed
}

pub(crate) fn area_m2(contour: &[IntPoint<i32>]) -> f64 {
    let cross = |[a, b]: [IntPoint<i32>; 2]| f64::from(a.x) * f64::from(b.y) - f64::from(a.y) * f64::from(b.x);
    edges(contour).map(cross).sum::<f64>() / (2.0 * UNITS_PER_M * UNITS_PER_M)
}

/// Drops the points of a ring that lie within `tolerance_m` of the line without them (Douglas and Peucker).
fn thin_out(ring: &[IntPoint<i32>], tolerance_m: f64) -> Contour {
    let n = ring.len();
    if n < 4 {
        return ring.to_vec();
    }
    let point = |p: &IntPoint<i32>| DVec2::new(p.x.into(), p.y.into());
    let at = |i: usize| point(&ring[if i < n { i } else { i - n }]);
    let reach = |i: &usize| (at(*i) - at(0)).length_squared();
    let far = (1..n).max_by(|a, b| reach(a).total_cmp(&reach(b))).unwrap_or(1);
    let mut keep = vec![false; n + 1];
    (keep[0], keep[far]) = (true, true);
    let mut todo = vec![(0, far), (far, n)];
    while let Some((a, b)) = todo.pop() {
        let (p, along) = (at(a), (at(b) - at(a)).normalize_or_zero());
        let off = |i: usize| (at(i) - p).perp_dot(along).abs();
        let (mut worst, mut worst_off) = (a, 0.0);
        for i in a + 1..b {
            let off = off(i);
            if off >= worst_off {
                (worst, worst_off) = (i, off);
            }
        }
        if worst_off > tolerance_m * UNITS_PER_M {
            keep[worst] = true;
            todo.push((a, worst));
            todo.push((worst, b));
        }
    }
    (0..n).filter(|i| keep[*i]).map(|i| ring[i]).collect()
}

/// The ring with points at most `step_m` apart.
pub(crate) fn with_steps(ring: &[DVec2], step_m: f64) -> Ring {
    let mut out = Vec::with_capacity(ring.len());
    for [a, b] in edges(ring) {
        let pieces = ((b - a).length() / step_m).ceil().max(1.0) as usize;
        out.extend((0..pieces).map(|k| a + (b - a) * (k as f64 / pieces as f64)));
    }
    out
}

/// The ring with corners where others cross it.
pub(crate) fn with_crossings(ring: &[DVec2], others: &mut dyn Iterator<Item = &Ring>) -> Ring {
    let reach = bounds(ring.iter().copied());
    let is_near = |(min, max): (DVec2, DVec2)| min.cmple(reach.1).all() && max.cmpge(reach.0).all();
    let near: Vec<&Ring> = others.filter(|other| is_near(bounds(other.iter().copied()))).collect();
    let mut out = Vec::with_capacity(ring.len());
    for [a, b] in edges(ring) {
        let along = b - a;
        let mut at: Vec<f64> = Vec::new();
        for [c, d] in near.iter().flat_map(|other| edges(other)) {
            let (from, across) = (c - a, d - c);
            let area = along.perp_dot(across);
            let (t, u) = (from.perp_dot(across) / area, from.perp_dot(along) / area);
            if t > 0.0 && t < 1.0 && (0.0..=1.0).contains(&u) {
                at.push(t);
            }
        }
        at.sort_by(f64::total_cmp);
        out.push(a);
        out.extend(at.into_iter().map(|t| a + along * t));
    }
    out
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn thinning_keeps_corners_and_drops_what_is_straight() {
        let ring: Contour =
            [(0, 0), (500, 2), (1000, 0), (1000, 900), (0, 1000)].map(|(x, y)| IntPoint::new(x, y)).into();
        assert_eq!(thin_out(&ring, 0.003).len(), 4);
        assert_eq!(thin_out(&ring, 0.001).len(), 5);
    }
}
