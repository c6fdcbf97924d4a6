//! Where there is room for what is wider or longer than a van.

use super::footprint::Footprint;
use crate::math::DVec3;
use crate::town::{Lane, LaneId};

/// How much wider than a truck its lane is, and what it keeps beside what stands.
const ROOM_IN_LANE_M: f64 = 0.22;
const ROOM_BESIDE_M: f64 = 0.25;
/// Aisles of car parks and lanes of a campus, which are no faster, are closed to what needs room.
const CLOSED_TO_TRUCKS_MPS: f64 = 6.0;
/// Vans shorter than this take every bend of a street; longer ones only bends of so much of their length.
const LONG_VAN_M: f64 = 5.6;
const VAN_RADIUS_OF_LENGTH: f64 = 1.2;
/// Nothing farther from a lane than this matters.
const FARTHEST_M: f64 = 3.0;

/// What a wide or long vehicle needs of the lanes that it takes; cars need nothing.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub(super) struct Needs {
    pub width_m: f64,
    pub length_m: f64,
    pub radius_m: f64,
}

impl Needs {
    /// Of a truck: what is long sweeps over curbs in tight bends.
    pub fn of_truck(size_lwh: DVec3) -> Self {
        let radius_m = 13.0 + 1.2 * (size_lwh.x - 7.2).max(0.0);
        Self { width_m: size_lwh.y, length_m: size_lwh.x, radius_m }
    }

    /// Of what is no truck: a long van swings into the oncoming lane in tight bends.
    pub fn of_van(size_lwh: DVec3) -> Self {
        let radius_m = if size_lwh.x > LONG_VAN_M { VAN_RADIUS_OF_LENGTH * size_lwh.x } else { 0.0 };
        Self { radius_m, ..Self::default() }
    }

    pub fn is_some(&self) -> bool {
        *self != Self::default()
    }
}

/// The room that each lane offers.
#[derive(Debug, Default)]
pub(super) struct Room {
    /// Radius of its tightest bend.
    tightest_m: Vec<f64>,
    /// From its middle to the nearest that stands beside it for good.
    clear_m: Vec<f64>,
}

impl Room {
    /// Of lanes of these curvatures, while nothing stands beside them.
    pub fn beside(curvatures: &[Vec<f64>]) -> Self {
        let tightest_m = curvatures.iter().map(|c| 1.0 / c.iter().copied().fold(1e-6, f64::max)).collect();
        Self { tightest_m, clear_m: vec![f64::INFINITY; curvatures.len()] }
    }

    /// How far from its middle something that stands takes room from a lane.
    pub fn reach_m(o: &Footprint) -> f64 {
        o.half_length_m + o.half_width_m + FARTHEST_M
    }

    /// Takes note of what stands for good beside lanes.
    pub fn note<'a>(&mut self, o: &Footprint, lanes: impl Iterator<Item = &'a Lane>) {
        for lane in lanes {
            let points = lane.center.iter().map(|p| p.truncate());
            let near = points.filter(|p| (*p - o.center).length() < Self::reach_m(o) + 2.0);
            let apart_m = near.map(|p| (o.closest_point(p) - p).length()).fold(f64::INFINITY, f64::min);
            let LaneId(number) = lane.id;
            self.clear_m[number] = self.clear_m[number].min(apart_m);
        }
    }

    /// Whether a lane has what a vehicle needs.
    pub fn fits(&self, lane: &Lane, needs: Needs) -> bool {
        let LaneId(number) = lane.id;
        // How far its corners swing out of a bend, or its flank into it.
        let tightest_m = self.tightest_m[number];
        let swing_m = needs.length_m * needs.length_m / (8.0 * tightest_m.max(needs.length_m));
        let width_m = needs.width_m + swing_m;
        let is_wide = lane.junction.is_some() || lane.width_m.iter().all(|w| *w >= width_m + ROOM_IN_LANE_M);
        let is_open = lane.speed_limit_mps > CLOSED_TO_TRUCKS_MPS;
        is_open && is_wide && tightest_m >= needs.radius_m && self.clear_m[number] >= width_m / 2.0 + ROOM_BESIDE_M
    }
}
