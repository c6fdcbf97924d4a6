//! The arms of a junction: where their lanes end, how wide they are, and where people cross them.

use crate::network::{Lane, LaneId, LaneKind, RoadNetwork};
use cadet_base::math::{self, DVec2, PI};

/// Where the ford begins and ends before the junction.
pub(crate) const FORD_M: (f64, f64) = (0.9, 4.3);
/// Where the stop line of lights begins and ends before the junction.
pub const STOP_LINE_M: (f64, f64) = (5.3, 5.8);
/// Beyond the painted ford people still count as on it.
const FORD_MARGIN_M: f64 = 0.4;
/// Nobody crosses beside a ford so near to it: before the junction, in the junction, and to the side.
const NO_CROSSING_M: (f64, f64) = (22.0, 10.0);
/// Beyond the curbs, where people wait.
const SIDEWALK_M: f64 = 5.0;
/// Arms whose directions differ from opposite ones by less than this may go at once.
const FACING_RAD: f64 = 0.8;
/// Streets faster than this count as main ones.
const MAIN_MPS: f64 = 12.0;
/// Lanes of a road that end so near to each other end at the same junction.
const ONE_END_M: f64 = 25.0;

/// How people get over a street.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum CrossingRule {
    /// There is no ford near by.
    Anywhere,
    /// On the ford of an arm.
    Ford(ArmId),
    /// On a zebra crossing.
    Zebra,
    /// Not here: there is a ford a few steps away.
    Nowhere,
}

/// An arm of a junction with lights, by its places in [`Signals::junctions`](super::Signals::junctions).
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct ArmId {
    /// The junction.
    pub junction: usize,
    /// Its arm.
    pub arm: usize,
}

/// A street where it meets a junction.
#[derive(Debug, Clone)]
pub struct JunctionArm {
    /// The lanes that lead into the junction, the rightmost first.
    pub lanes: Vec<LaneId>,
    /// The lanes for bicycles beside them.
    pub cycle_lanes: Vec<LaneId>,
    /// The stage of the plan in which they go.
    pub stage: usize,
    /// Where the first of the lanes ends.
    pub at: DVec2,
    /// The height of its end.
    pub z_m: f64,
    /// Unit vector into the junction.
    pub along: DVec2,
    /// From `at` to the curbs: to the left, and, negative, to the right.
    pub left_m: f64,
    /// See `left_m`.
    pub right_m: f64,
    /// When in the plan's cycle people may start over its ford.
    pub(super) walk_s: Option<(f64, f64)>,
    speed_limit_mps: f64,
}

impl JunctionArm {
    /// Whether it is a main road.
    #[must_use]
    pub fn is_main(&self) -> bool {
        self.speed_limit_mps > MAIN_MPS
    }

    /// Length of the way across it.
    #[must_use]
    pub fn ford_length_m(&self) -> f64 {
        self.left_m - self.right_m
    }

    /// Whether people get over it.
    #[must_use]
    pub fn has_ford(&self) -> bool {
        self.walk_s.is_some()
    }

    /// Whether two arms lie opposite each other.
    pub(super) fn faces(&self, other: &Self) -> bool {
        let apart = math::turn_rad(self.along, other.along).abs();
        PI - apart < FACING_RAD
    }

    /// The place so far before the junction and to the left of the end of the first lane.
    #[must_use]
    pub fn place(&self, before_m: f64, left_m: f64) -> DVec2 {
        self.at - self.along * before_m + self.along.perp() * left_m
    }

    /// How far a place is before the end of the first lane, and how far to its left.
    fn local(&self, p: DVec2) -> (f64, f64) {
        (-(p - self.at).dot(self.along), (p - self.at).dot(self.along.perp()))
    }

    /// Whether a way leads from curb to curb where the ford is.
    pub(super) fn is_over(&self, from: DVec2, to: DVec2) -> bool {
        let ((a, y_a), (b, y_b)) = (self.local(from), self.local(to));
        let ford = FORD_M.0 - FORD_MARGIN_M..FORD_M.1 + FORD_MARGIN_M;
        let is_between = y_a.min(y_b) < self.right_m && y_a.max(y_b) > self.left_m;
        is_between && self.is_across(y_a) && self.is_across(y_b) && ford.contains(&a) && ford.contains(&b)
    }

    /// Whether a place is on the ford.
    pub(super) fn is_on_ford(&self, place: DVec2) -> bool {
        let (before_m, left_m) = self.local(place);
        (FORD_M.0 - FORD_MARGIN_M..FORD_M.1 + FORD_MARGIN_M).contains(&before_m)
            && (self.right_m - 0.5..self.left_m + 0.5).contains(&left_m)
    }

    fn is_across(&self, left_m: f64) -> bool {
        left_m > self.right_m - SIDEWALK_M && left_m < self.left_m + SIDEWALK_M
    }

    /// How people get over this arm with lights, which has an id.
    pub(super) fn crossing_rule(&self, id: ArmId, from: DVec2, to: DVec2) -> CrossingRule {
        let (before_m, left_m) = self.local((from + to) / 2.0);
        if !(-NO_CROSSING_M.1..NO_CROSSING_M.0).contains(&before_m) || !self.is_across(left_m) {
            CrossingRule::Anywhere
        } else if self.has_ford() && self.is_over(from, to) {
            CrossingRule::Ford(id)
        } else {
            CrossingRule::Nowhere
        }
    }
}

/// The arms of a junction, by road.
pub(crate) fn arms_of(network: &RoadNetwork, junction: u32) -> Vec<JunctionArm> {
    let mut arms: Vec<(u32, JunctionArm)> = Vec::new();
    for lane in network.driving().filter(|l| network.leads_into(l, junction)) {
        let (at, along) = (lane.end().truncate(), lane.end_tangent());
        let is_same = |(road, arm): &&mut (u32, JunctionArm)| {
            *road == lane.road && (arm.at - at).length() < ONE_END_M && arm.along.dot(along) > 0.5
        };
        if let Some((_, arm)) = arms.iter_mut().find(is_same) {
            // The rightmost lane comes first.
            let is_to_the_right = (at - arm.at).dot(arm.along.perp()) < 0.0;
            let place = if is_to_the_right { 0 } else { arm.lanes.len() };
            arm.lanes.insert(place, lane.id);
            if is_to_the_right {
                (arm.at, arm.along) = (at, along);
            }
            continue;
        }
        let arm = JunctionArm {
            lanes: vec![lane.id],
            cycle_lanes: Vec::new(),
            stage: 0,
            at,
            z_m: lane.end().z,
            along,
            left_m: 0.0,
            right_m: 0.0,
            walk_s: None,
            speed_limit_mps: lane.speed_limit_mps,
        };
        arms.push((lane.road, arm));
    }
    arms.into_iter()
        .map(|(road, mut arm)| {
            (arm.right_m, arm.left_m) = extent(network, road, &arm);
            let is_beside = |l: &&Lane| l.road == road && (l.end().truncate() - arm.at).length() < ONE_END_M;
            let cycle_lanes =
                network.of_kind(LaneKind::Biking).filter(|l| network.leads_into(l, junction)).filter(is_beside);
            arm.cycle_lanes = cycle_lanes.map(|l| l.id).collect();
            arm
        })
        .collect()
}

/// The carriageway's edges, right and left of an arm's first lane: of all lanes of its road that end or begin there.
fn extent(network: &RoadNetwork, road: u32, arm: &JunctionArm) -> (f64, f64) {
    let is_paved = |l: &&Lane| {
        let is_carriageway = matches!(
            l.kind,
            LaneKind::Driving | LaneKind::Biking | LaneKind::Shoulder | LaneKind::Parking | LaneKind::Median
        );
        l.road == road && l.junction.is_none() && is_carriageway
    };
    let mut edges = (0.0_f64, 0.0_f64);
    for lane in network.lanes.iter().filter(is_paved) {
        let widths_m = [lane.width_m[0], lane.width_m[lane.width_m.len() - 1]];
        for (end, width_m) in [lane.center[0], lane.end()].into_iter().zip(widths_m) {
            let to = end.truncate() - arm.at;
            let (before, left) = (-to.dot(arm.along), to.dot(arm.along.perp()));
            if before.abs() < 3.0 && left.abs() < ONE_END_M {
                edges = (edges.0.min(left - width_m / 2.0), edges.1.max(left + width_m / 2.0));
            }
        }
    }
    edges
}
