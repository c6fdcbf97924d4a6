//! Paint that is laid on a ground: thin quadrilaterals that hug it.

pub(crate) mod cycle_markings;
mod junctions;
pub(crate) mod rails;
pub(crate) mod repairs;
pub(crate) mod road_marking;
mod wear;

pub(crate) use wear::{LEFT, Wear};

use crate::network::{PaintColor, PaintedQuad};
use cadet_base::math::{DVec2, DVec3};

pub(crate) const PAINT_LIFT_M: f64 = 0.0055;
/// Paint is laid in pieces at most this long, so that it hugs the triangles below.
const PIECE_M: f64 = 0.75;
/// Lines shorter than this are not painted.
const LEAST_M: f64 = 0.01;

/// Depth of stop lines.
pub(crate) const STOP_LINE_DEPTH_M: f64 = 0.5;

/// Paint that has been laid, and the ground below it.
pub(crate) struct Paint<'a> {
    /// Height of the surface nearest to a place, and whether a road is there.
    pub surface_near: &'a dyn Fn(DVec3) -> Option<(f64, bool)>,
    /// Whether what lies beside roads, as on medians, is left out.
    pub is_on_roads: bool,
    /// Height over the ground.
    pub lift_m: f64,
    pub quads: Vec<PaintedQuad>,
}

impl<'a> Paint<'a> {
    /// Nothing yet, at the height of paint.
    pub fn new(surface_near: &'a dyn Fn(DVec3) -> Option<(f64, bool)>, is_on_roads: bool) -> Self {
        Self { surface_near, is_on_roads, lift_m: PAINT_LIFT_M, quads: Vec::new() }
    }

    /// A line's piece, cut into shorter ones, which are laid on the surface nearest to it.
    pub fn along(&mut self, mark: &PaintedQuad) {
        let [a, b, c, d] = mark.corners;
        // The longer sides are along the line.
        let is_along = length_m(a, b) > length_m(b, c);
        let ([a, b], [d, c]) = if is_along { ([a, b], [d, c]) } else { ([b, c], [a, d]) };
        let longest_m = length_m(a, b).max(length_m(d, c));
        if longest_m < LEAST_M {
            return;
        }
        let pieces = (longest_m / PIECE_M).ceil();
        let at = |k: usize| (a.lerp(b, k as f64 / pieces), d.lerp(c, k as f64 / pieces));
        for k in 0..pieces as usize {
            let ((a, d), (b, c)) = (at(k), at(k + 1));
            self.quad([a, b, c, d], mark);
        }
    }

    /// An area, cut into pieces both ways; its corners are counter-clockwise from above.
    pub fn area(&mut self, mark: &PaintedQuad) {
        let [a, b, c, d] = mark.corners;
        let count = |a: DVec3, b: DVec3, c: DVec3, d: DVec3| {
            let pieces = (length_m(a, b).max(length_m(d, c)) / PIECE_M).ceil().max(1.0);
            (pieces as usize, pieces)
        };
        let ((columns, across), (rows, along)) = (count(a, b, c, d), count(b, c, d, a));
        let at = |i: usize, k: usize| {
            let (u, v) = (i as f64 / across, k as f64 / along);
            a.lerp(b, u).lerp(d.lerp(c, u), v)
        };
        for i in 0..columns {
            for k in 0..rows {
                self.quad([at(i, k), at(i + 1, k), at(i + 1, k + 1), at(i, k + 1)], mark);
            }
        }
    }

    /// A bar across a lane from `from` to `to` left of its middle, `depth_m` long.
    pub fn across(&mut self, at: DVec3, left: DVec2, (from, to): (f64, f64), depth_m: f64, line: u32) {
        let (a, b, back) = (at.truncate() + left * from, at.truncate() + left * to, left.perp() * depth_m);
        let corners = [a, b, b + back, a + back].map(|p| p.extend(at.z));
        self.along(&PaintedQuad { corners, color: PaintColor::White, line });
    }

    /// A broken line across a lane, as [`Self::across`]: dashes and gaps of a length, as many as have room.
    pub fn dashes(
        &mut self,
        at: DVec3,
        left: DVec2,
        (from, to): (f64, f64),
        (dash_m, gap_m): (f64, f64),
        depth_m: f64,
        line: u32,
    ) {
        let mut t = from;
        while t + dash_m < to {
            self.across(at, left, (t, t + dash_m), depth_m, line);
            t += dash_m + gap_m;
        }
    }

    fn quad(&mut self, corners: [DVec3; 4], mark: &PaintedQuad) {
        let lifted = corners.map(|p| {
            let (z, is_road) = (self.surface_near)(p)?;
            (is_road || !self.is_on_roads).then_some(p.with_z(z + self.lift_m))
        });
        if let [Some(a), Some(b), Some(c), Some(d)] = lifted {
            // A corner on a sidewalk would tilt the paint up the curb.
            let (lo, hi) = [b, c, d].iter().fold((a.z, a.z), |(l, h), p| (l.min(p.z), h.max(p.z)));
            if hi - lo < 0.09 {
                self.quads.push(PaintedQuad { corners: [a, b, c, d], ..*mark });
            }
        }
    }
}

/// The distance between two points in plan.
fn length_m(a: DVec3, b: DVec3) -> f64 {
    (b - a).truncate().length()
}
