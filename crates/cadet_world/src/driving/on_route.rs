//! A vehicle that follows a route, and what it keeps a gap to.

use super::idm::{IdmParameters, gap_along};
use super::pursuit::Axles;
use crate::footprint::Footprint;
use crate::junctions::Refusal;
use crate::slot::Slot;
use crate::streets::{Ahead, LaneGraph, Route};
use crate::traffic_state::TrafficState;

/// How far a driver looks.
const SIGHT_M: f64 = 60.0;
const SAMPLE_M: f64 = 1.25;
/// How far one looks when standing, and at least before the front bumper.
const NEAR_M: f64 = 12.0;
const BEFORE_FRONT_M: f64 = 8.0;
/// How far one looks on a motorway.
const FAST_SIGHT_M: f64 = 260.0;

/// What a driver brakes for most.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum Cause {
    /// Nothing: the road is free, or nobody drives.
    Nothing,
    /// A vehicle that stands for good in the lane.
    Parked,
    /// A vehicle that moves.
    Vehicle(Slot),
    /// A person on the road.
    Person,
    /// The end of the road.
    RoadEnd,
    /// A junction that others cross or queue behind.
    Junction(Refusal),
}

/// Something to keep a gap to.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Constraint {
    /// From the front bumper.
    pub gap_m: f64,
    /// Speed along the route of what the gap is kept to.
    pub speed_mps: f64,
    pub cause: Cause,
}

/// A vehicle that goes along a route.
pub(crate) struct OnRoute<'a> {
    pub slot: Slot,
    pub footprint: &'a Footprint,
    pub route: &'a Route,
    pub idm: &'a IdmParameters,
    /// Of who steers.
    pub axles: Option<Axles>,
    /// All of a train whose first car this is.
    pub train_m: Option<f64>,
    /// Whether it makes do with little room beside others, having waited.
    pub reduced_clearance: bool,
    pub around: &'a TrafficState,
    pub graph: &'a LaneGraph,
    pub step: u64,
}

impl OnRoute<'_> {
    /// The vehicle's speed ahead.
    pub fn speed_mps(&self) -> f64 {
        self.footprint.velocity.dot(self.footprint.heading)
    }

    pub fn length_m(&self) -> f64 {
        self.train_m.unwrap_or(2.0 * self.footprint.half_length_m)
    }

    /// The places ahead on its route, from its middle on, that matter at its speed.
    pub fn in_sight(&self) -> Vec<Ahead> {
        let most_m = if self.graph.is_fast(self.route.lanes[0]) { FAST_SIGHT_M } else { SIGHT_M };
        let count = (self.sight_m().min(most_m) / SAMPLE_M) as usize;
        (0..count).map(|k| self.route.ahead(k as f64 * SAMPLE_M, self.graph)).collect()
    }

    /// How far ahead of its middle it matters what stands: where it stops comfortably, and two seconds more.
    pub fn sight_m(&self) -> f64 {
        let speed_mps = self.speed_mps().max(0.0);
        let near_m = NEAR_M.max(self.footprint.half_length_m + BEFORE_FRONT_M);
        speed_mps * speed_mps / (2.0 * self.idm.comfortable_mps2) + 2.0 * speed_mps + near_m
    }

    /// The constraint by which its front comes to a stand after so much.
    pub fn stop_in(&self, front_m: f64, cause: Cause) -> Constraint {
        Constraint { gap_m: front_m + self.idm.minimum_gap_m, speed_mps: 0.0, cause }
    }

    /// The gap to what is in the way along the places ahead, if it comes nearer than `side_m` to the vehicle's sides.
    pub fn gap_to(&self, o: &Footprint, side_m: f64, ahead: &[Ahead], cause: Cause) -> Option<Constraint> {
        let Footprint { half_length_m, half_width_m, .. } = *self.footprint;
        let (gap_m, speed_mps) = gap_along(ahead, SAMPLE_M, half_length_m, half_width_m + side_m, o)?;
        Some(Constraint { gap_m, speed_mps, cause })
    }

    /// The constraint that takes most off the acceleration, and how much that is.
    pub fn tightest(&self, constraints: &[Constraint]) -> (f64, Cause) {
        let speed_mps = self.speed_mps();
        constraints
            .iter()
            .map(|c| (self.idm.interaction_accel(speed_mps, c.gap_m, c.speed_mps), c.cause))
            .fold((0.0, Cause::Nothing), |worst, one| if one.0 < worst.0 { one } else { worst })
    }
}
