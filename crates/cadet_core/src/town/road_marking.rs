//! Paint on the carriageway: the lines of the map, stop lines and give-way lines, as thin quadrilaterals.

use super::network::{Lane, LaneKind, PaintColor, PaintedQuad, RoadNetwork};
use crate::math::{DVec2, DVec3};

const LIFT_M: f64 = 0.0045;
/// Streets at most this fast have no priority at junctions.
const ZONE_30_MPS: f64 = 8.5;
/// Paint is laid in pieces at most this long, so that it hugs the triangles below.
const PIECE_M: f64 = 0.75;
/// What is shorter is no paint.
const LEAST_M: f64 = 0.01;
const STOP_LINE_M: f64 = 0.5;
/// A give-way line: dash and gap across the lane, depth along it.
const GIVE_WAY_M: (f64, f64, f64) = (0.5, 0.25, 0.35);
/// Lines across a lane lie this far before its end.
const BEFORE_JUNCTION_M: f64 = 0.8;

/// The quadrilaterals, counter-clockwise from above, laid on a ground that is so high at (x, y).
pub(super) fn draw(network: &RoadNetwork, ground_height: &dyn Fn(f64, f64) -> Option<f64>) -> Vec<PaintedQuad> {
    let mut paint = Paint { ground_height, quads: Vec::new() };
    network.lane_marks.iter().for_each(|mark| paint.along(mark));
    let streets: Vec<&Lane> = network.driving().filter(|l| l.junction.is_none()).collect();
    let is_fast = |l: &Lane| l.speed_limit_mps > ZONE_30_MPS;
    for lane in &streets {
        let Some(junction) = lane.successors.iter().find_map(|n| network.lane(*n).junction) else { continue };
        let arriving = streets.iter().filter(|o| {
            o.kind == LaneKind::Driving && o.successors.iter().any(|n| network.lane(*n).junction == Some(junction))
        });
        let fast = arriving.clone().filter(|o| is_fast(o)).count();
        let (at, side) = edge(lane, lane.length_m() - BEFORE_JUNCTION_M);
        let half = lane.width_at(lane.length_m()) / 2.0;
        if fast == arriving.count() {
            paint.across(at, side, (-half + 0.1, half - 0.1), STOP_LINE_M);
        } else if fast > 1 && !is_fast(lane) {
            // A fast street goes through; where one only ends, nobody has to give way to it.
            let mut t = -half + 0.1;
            while t + GIVE_WAY_M.0 < half {
                paint.across(at, side, (t, t + GIVE_WAY_M.0), GIVE_WAY_M.2);
                t += GIVE_WAY_M.0 + GIVE_WAY_M.1;
            }
        }
    }
    paint.quads
}

/// The middle of a lane at distance `s_m`, and the unit vector to its left.
fn edge(lane: &Lane, s_m: f64) -> (DVec2, DVec2) {
    let pose = lane.pose_at(s_m);
    ((pose.translation).truncate(), (pose.rotation * DVec3::Y).truncate().normalize_or_zero())
}

struct Paint<'a> {
    ground_height: &'a dyn Fn(f64, f64) -> Option<f64>,
    quads: Vec<PaintedQuad>,
}

impl Paint<'_> {
    /// A line's piece, cut into shorter ones; only its place in the plane counts.
    fn along(&mut self, mark: &PaintedQuad) {
        let [a, b, c, d] = mark.corners.map(|p| p.truncate());
        // The longer sides are along the line.
        let ([a, b], [d, c]) = if (b - a).length() > (c - b).length() { ([a, b], [d, c]) } else { ([b, c], [a, d]) };
        let length_m = (b - a).length().max((c - d).length());
        if length_m < LEAST_M {
            return;
        }
        let pieces = (length_m / PIECE_M).ceil();
        let at = |k: usize| (a.lerp(b, k as f64 / pieces), d.lerp(c, k as f64 / pieces));
        for k in 0..pieces as usize {
            let ((a, d), (b, c)) = (at(k), at(k + 1));
            self.quad([a, b, c, d], mark.color);
        }
    }

    /// A bar across a lane from `from` to `to` left of its middle, `depth_m` long.
    fn across(&mut self, at: DVec2, left: DVec2, (from, to): (f64, f64), depth_m: f64) {
        let (a, b, back) = (at + left * from, at + left * to, left.perp() * depth_m);
        let corners = [a, b, b + back, a + back].map(|p| p.extend(0.0));
        self.along(&PaintedQuad { corners, color: PaintColor::White });
    }

    fn quad(&mut self, corners: [DVec2; 4], color: PaintColor) {
        let lifted = corners.map(|p| (self.ground_height)(p.x, p.y).map(|z| p.extend(z + LIFT_M)));
        if let [Some(a), Some(b), Some(c), Some(d)] = lifted {
            // A corner on a sidewalk would tilt the paint up the curb.
            let (lo, hi) = [b, c, d].iter().fold((a.z, a.z), |(l, h), p| (l.min(p.z), h.max(p.z)));
            if hi - lo < 0.09 {
                self.quads.push(PaintedQuad { corners: [a, b, c, d], color });
            }
        }
    }
}
