//! Paint on the carriageway: dashed center lines, stop lines and give-way lines, as thin quadrilaterals.

use super::network::{Lane, LaneKind, RoadNetwork};
use crate::math::{DVec2, DVec3};

const LIFT_M: f64 = 0.0045;
const LINE_WIDTH_M: f64 = 0.12;
/// A dash and the gap after it.
const DASH_M: (f64, f64) = (3.0, 6.0);
/// Streets at most this fast have no center line, and no priority at junctions.
const ZONE_30_MPS: f64 = 8.5;
const MIN_CARRIAGEWAY_M: f64 = 5.5;
/// Paint is laid in pieces this long, so that it hugs the triangles below.
const PIECE_M: f64 = 0.75;
const STOP_LINE_M: f64 = 0.5;
/// A give-way line: dash and gap across the lane, depth along it.
const GIVE_WAY_M: (f64, f64, f64) = (0.5, 0.25, 0.35);
/// Lines across a lane lie this far before its end.
const BEFORE_JUNCTION_M: f64 = 0.8;

/// The quadrilaterals, counter-clockwise from above, laid on a ground that is so high at (x, y).
pub(super) fn draw(network: &RoadNetwork, ground_height: &dyn Fn(f64, f64) -> Option<f64>) -> Vec<[DVec3; 4]> {
    let mut paint = Paint { ground_height, quads: Vec::new() };
    let streets: Vec<&Lane> = network.driving().filter(|l| l.junction.is_none()).collect();
    let is_fast = |l: &Lane| l.speed_limit_mps > ZONE_30_MPS;
    for lane in streets.iter().filter(|l| is_fast(l)) {
        if has_opposite(lane, &streets) {
            paint.center_line(lane);
        }
    }
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

/// True for the first of two lanes of a road that share their left edge and run against each other.
fn has_opposite(lane: &Lane, streets: &[&Lane]) -> bool {
    let middle = lane.length_m() / 2.0;
    let width = lane.width_at(middle);
    let (at, left) = edge(lane, middle);
    let shared = at + left * (width / 2.0);
    2.0 * width > MIN_CARRIAGEWAY_M
        && streets.iter().filter(|o| o.road == lane.road && o.id > lane.id).any(|o| {
            let (s, _) = o.project(shared.extend(0.0));
            let (other, other_left) = edge(o, s);
            other_left.dot(left) < -0.9 && (other + other_left * (o.width_at(s) / 2.0) - shared).length() < 0.3
        })
}

struct Paint<'a> {
    ground_height: &'a dyn Fn(f64, f64) -> Option<f64>,
    quads: Vec<[DVec3; 4]>,
}

impl Paint<'_> {
    fn center_line(&mut self, lane: &Lane) {
        let length = lane.length_m();
        let mut s = 1.0;
        while s + DASH_M.0 < length {
            let pieces = (DASH_M.0 / PIECE_M) as usize;
            let at = |k: usize| {
                let s = s + PIECE_M * k as f64;
                let (p, left) = edge(lane, s);
                (p + left * (lane.width_at(s) / 2.0), left * (LINE_WIDTH_M / 2.0))
            };
            for k in 0..pieces {
                let ((a, u), (b, v)) = (at(k), at(k + 1));
                self.quad([a - u, b - v, b + v, a + u]);
            }
            s += DASH_M.0 + DASH_M.1;
        }
    }

    /// A bar across a lane from `from` to `to` left of its middle, `depth_m` long.
    fn across(&mut self, at: DVec2, left: DVec2, (from, to): (f64, f64), depth_m: f64) {
        let back = left.perp() * depth_m;
        let pieces = ((to - from) / PIECE_M).ceil().max(1.0) as usize;
        let t = |k: usize| from + (to - from) * k as f64 / pieces as f64;
        for k in 0..pieces {
            let (a, b) = (at + left * t(k), at + left * t(k + 1));
            self.quad([a, b, b + back, a + back]);
        }
    }

    fn quad(&mut self, corners: [DVec2; 4]) {
        let lifted = corners.map(|p| (self.ground_height)(p.x, p.y).map(|z| p.extend(z + LIFT_M)));
        if let [Some(a), Some(b), Some(c), Some(d)] = lifted {
            // A corner on a sidewalk would tilt the paint up the curb.
            let (lo, hi) = [b, c, d].iter().fold((a.z, a.z), |(l, h), p| (l.min(p.z), h.max(p.z)));
            if hi - lo < 0.09 {
                self.quads.push([a, b, c, d]);
            }
        }
    }
}
