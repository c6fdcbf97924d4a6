//! A lane as a driver sees it: who is ahead in it, who follows, and who is beside.

use crate::footprint::Footprint;
use crate::slot::Slot;
use crate::streets::LaneGraph;
use crate::traffic_state::TrafficState;
use cadet_base::math::{DVec2, DVec3};
use cadet_town::{Lane, LaneId};

/// How far a driver looks along a lane, ahead and behind.
const AHEAD_M: f64 = 280.0;
const BEHIND_M: f64 = 220.0;
const SAMPLE_M: f64 = 4.0;
/// Distance from a lane's middle beyond which nothing is in the lane.
const NEAR_M: f64 = 20.0;
/// Points of a lane that are passed over together where they are far away, and how far they reach from their middle one.
const CHUNK: usize = 8;
const CHUNK_REACH_M: f64 = 1.01 * SAMPLE_M * (CHUNK / 2) as f64;
/// Distance over a lane's edge from which on a vehicle is in the lane.
const OVER_M: f64 = 0.3;

/// Somebody in a lane.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Neighbor {
    /// Bumper to bumper.
    pub gap_m: f64,
    pub speed_mps: f64,
}

/// The neighbors of a place in a lane.
#[derive(Debug, Clone, Copy, Default)]
pub(crate) struct LaneView {
    pub leader: Option<Neighbor>,
    pub follower: Option<Neighbor>,
    /// Whether somebody is beside the place.
    pub is_taken: bool,
}

impl LaneView {
    /// The lane about a place of it, for somebody of that length and speed who is left out.
    pub fn of(
        lane: LaneId,
        s_m: f64,
        half_length_m: f64,
        own: Option<Slot>,
        around: &TrafficState,
        graph: &LaneGraph,
    ) -> Self {
        let path = Path::about(graph.lane(lane), s_m, graph);
        let half_width_m = graph.lane(lane).width_at(s_m) / 2.0;
        let mut view = Self::default();
        let vehicles = around.vehicles.iter().map(|v| (Some(v.agent), &v.footprint));
        let standing = around.standing_in_lanes.iter().map(|o| (None, o));
        let claims = around.claims().map(|(slot, claim)| (Some(slot), claim));
        for (slot, o) in vehicles.chain(standing).chain(claims) {
            if own.is_some() && slot == own {
                continue;
            }
            let Some((distance_m, left_m, tangent)) = path.place_of(o) else { continue };
            if left_m.abs() > half_width_m + o.half_width_m - OVER_M {
                continue;
            }
            let gap_m = distance_m.abs() - half_length_m - o.half_length_m;
            let neighbor = Neighbor { gap_m, speed_mps: o.velocity.dot(tangent) };
            view.is_taken |= gap_m <= 0.0;
            let place = if distance_m > 0.0 { &mut view.leader } else { &mut view.follower };
            if place.is_none_or(|n| gap_m < n.gap_m) {
                *place = Some(neighbor);
            }
        }
        view
    }
}

/// Points of a lane and of those before and after it, with how far ahead each is.
struct Path {
    points: Vec<DVec3>,
    behind_m: f64,
}

impl Path {
    fn about(lane: &Lane, s_m: f64, graph: &LaneGraph) -> Self {
        // Back to where the view begins, then forward in steps. Where ways part, the first one is looked at.
        let (mut first, mut from_m) = (lane, s_m - BEHIND_M);
        while from_m < 0.0
            && let Some(before) = first.predecessors.first().map(|id| graph.lane(*id))
        {
            from_m += before.length_m();
            first = before;
        }
        let start_m = from_m.max(0.0);
        let behind_m = BEHIND_M - (start_m - from_m);
        let count = ((behind_m + AHEAD_M) / SAMPLE_M) as usize;
        let (mut on, mut at_m) = (first, start_m);
        let mut points = Vec::with_capacity(count);
        for _ in 0..count {
            while at_m > on.length_m() {
                let Some(next) = on.successors.first().map(|id| graph.lane(*id)) else {
                    return Self { points, behind_m };
                };
                at_m -= on.length_m();
                on = next;
            }
            points.push(on.point_at(at_m));
            at_m += SAMPLE_M;
        }
        Self { points, behind_m }
    }

    /// The point nearest to a place, the first of equal ones; None if it is farther away than `most_m`.
    fn nearest_within(&self, p: DVec2, most_m: f64) -> Option<usize> {
        let square_m2 = |a: &DVec3| (a.truncate() - p).length_squared();
        let (mut nearest, mut least_m2) = (None, most_m * most_m);
        for (points, first) in self.points.chunks(CHUNK).zip((0..).step_by(CHUNK)) {
            // No point of a chunk is farther from its middle one than the lane is long between them.
            let reach_m = least_m2.sqrt() + CHUNK_REACH_M;
            if square_m2(&points[points.len() / 2]) > reach_m * reach_m {
                continue;
            }
            for (point, number) in points.iter().zip(first..) {
                let m2 = square_m2(point);
                if m2 < least_m2 || (m2 == least_m2 && nearest.is_none()) {
                    (nearest, least_m2) = (Some(number), m2);
                }
            }
        }
        nearest
    }

    /// How far ahead a place is and how far to the left, and the direction there; `None` for what is nowhere near.
    fn place_of(&self, o: &Footprint) -> Option<(f64, f64, DVec2)> {
        let p = o.center;
        let nearest = self.nearest_within(p, NEAR_M)?;
        let at = self.points[nearest];
        if !o.is_level_with(at.truncate(), at.z) {
            return None;
        }
        let (before, after) = (nearest.saturating_sub(1), (nearest + 1).min(self.points.len() - 1));
        let tangent = (self.points[after] - self.points[before]).truncate().normalize_or_zero();
        let to = p - at.truncate();
        let along_m = tangent.dot(to);
        let is_near = along_m.abs() < 1.5 * SAMPLE_M;
        is_near.then(|| (nearest as f64 * SAMPLE_M - self.behind_m + along_m, tangent.perp_dot(to), tangent))
    }
}
