//! Paint on the carriageway: the lines of the map, stop lines and give-way lines, as thin quadrilaterals.

use std::collections::BTreeMap;

use super::network::{Lane, PaintColor, PaintedQuad, RoadNetwork};
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
        // By street: of two lanes that arrive side by side, neither goes through because of the other.
        let arriving: BTreeMap<u32, bool> = streets
            .iter()
            .filter(|o| o.successors.iter().any(|n| network.lane(*n).junction == Some(junction)))
            .map(|o| (o.road, is_fast(o)))
            .collect();
        let fast = arriving.values().filter(|fast| **fast).count();
        let (at, side) = edge(lane, lane.length_m() - BEFORE_JUNCTION_M);
        let half = lane.width_at(lane.length_m()) / 2.0;
        if fast == arriving.len() {
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

#[cfg(test)]
mod tests {
    use super::*;
    use crate::math;
    use crate::town::{LaneId, LaneKind};

    /// Lanes that end at the origin, one beside the other if they are of one road, and a lane that leads on.
    fn junction_of(arriving: &[(u32, f64)]) -> RoadNetwork {
        let lane = |id: usize, road: u32, center: Vec<DVec3>, speed_limit_mps: f64| Lane {
            id: LaneId(id),
            kind: LaneKind::Driving,
            s_m: vec![0.0, 10.0],
            width_m: vec![3.0; 2],
            center,
            successors: Vec::new(),
            predecessors: Vec::new(),
            junction: None,
            road,
            speed_limit_mps,
        };
        let beyond = arriving.len();
        let mut lanes: Vec<Lane> = arriving
            .iter()
            .enumerate()
            .map(|(i, (road, speed))| {
                let along = DVec3::new(math::cos(f64::from(*road)), math::sin(f64::from(*road)), 0.0);
                let beside = DVec3::new(-along.y, along.x, 0.0) * (3.0 * i as f64);
                let mut lane = lane(i, *road, vec![beside - along * 14.0, beside - along * 4.0], *speed);
                lane.successors = vec![LaneId(beyond)];
                lane
            })
            .collect();
        let mut across = lane(beyond, 99, vec![DVec3::ZERO, DVec3::X * 10.0], 8.0);
        across.junction = Some(1);
        lanes.push(across);
        RoadNetwork { lanes, lane_marks: Vec::new() }
    }

    fn bars(arriving: &[(u32, f64)]) -> usize {
        draw(&junction_of(arriving), &|_, _| Some(0.0)).len()
    }

    #[test]
    fn side_streets_give_way_to_a_fast_street_that_goes_through_not_to_one_that_ends() {
        let (fast, slow) = (13.9, 8.3);
        assert!(bars(&[(1, fast), (2, fast), (3, slow)]) > 0, "both arms of a fast street arrive");
        assert_eq!(bars(&[(1, fast), (2, slow), (3, slow)]), 0, "a fast street ends");
        assert_eq!(bars(&[(1, fast), (1, fast), (2, slow), (3, slow)]), 0, "one of two lanes ends");
        assert!(bars(&[(1, fast), (2, fast)]) > 0, "stop lines where all are fast");
    }
}
