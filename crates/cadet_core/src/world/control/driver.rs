//! Who drives a car along a route: bends, traffic, junctions.

use super::controller::{Controller, Own};
use super::idm::{COMFORTABLE_MPS2, IdmParameters, gap_along, pedals};
use super::pursuit::pursue;
use super::stop_line::{Crossing, stop_line};
use crate::math::{DVec2, DVec3};
use crate::town::LaneId;
use crate::world::body::Body;
use crate::world::footprint::Footprint;
use crate::world::junctions::Refusal;
use crate::world::physics::{DT_S, Physics};
use crate::world::route::{Ahead, Roads, Route};
use crate::world::slot::Slot;
use crate::world::streets::Streets;
use crate::world::surroundings::Surroundings;

/// How far a driver looks.
const SIGHT_M: f64 = 60.0;
const SAMPLE_M: f64 = 1.25;
/// Room kept beside what stands, and beside what moves.
const SIDE_STANDING_M: f64 = 0.12;
const SIDE_MOVING_M: f64 = 0.25;
/// A car slower than this stands.
const STANDS_MPS: f64 = 0.1;

/// What a driver brakes for most: named for the tests.
#[cfg_attr(not(test), allow(dead_code))]
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

/// Drives a [`Body::Sprung`].
pub(crate) struct Driver {
    pub route: Option<Route>,
    /// Whether the driver drives; otherwise the brakes hold.
    pub drives: bool,
    pub standing_steps: u64,
    idm: IdmParameters,
    interaction_mps2: f64,
    desired_mps: f64,
    #[cfg_attr(not(test), allow(dead_code))]
    cause: Cause,
}

impl Driver {
    pub fn new(route: Option<Route>, idm: IdmParameters) -> Self {
        Self {
            drives: route.is_some(),
            route,
            standing_steps: 0,
            idm,
            interaction_mps2: 0.0,
            desired_mps: 0.0,
            cause: Cause::Nothing,
        }
    }

    /// Waits at a place of another route.
    pub fn wait_on(&mut self, route: Option<Route>) {
        (self.route, self.drives, self.standing_steps) = (route, false, 0);
    }

    /// What the driver brakes for.
    #[cfg(test)]
    pub fn cause(&self) -> Cause {
        self.cause
    }

    /// Looks at bends, traffic and junctions, given the places ahead on the route.
    fn reckon(
        &mut self,
        slot: Slot,
        own: &Footprint,
        ahead: &[Ahead],
        around: &mut Surroundings,
        roads: &Roads,
        step: u64,
    ) {
        let Some(route) = self.route.as_ref() else { return };
        let speed = own.velocity.dot(own.heading);
        let (low, high) =
            ahead.iter().fold((DVec2::INFINITY, DVec2::NEG_INFINITY), |(lo, hi), a| (lo.min(a.at), hi.max(a.at)));
        let mut worst = (0.0_f64, Cause::Nothing);
        let mut brake_for = |interaction: f64, cause: Cause| {
            if interaction < worst.0 {
                worst = (interaction, cause);
            }
        };
        let standing = || around.standing_in_lanes.iter().map(|o| (Cause::Parked, SIDE_STANDING_M, o));
        let others = || around.vehicles.iter().filter(|v| v.agent != slot);
        let moving = || others().map(|v| (Cause::Vehicle(v.agent), SIDE_MOVING_M, &v.footprint));
        let people = around.people_on_road.iter().map(|o| (Cause::Person, SIDE_MOVING_M, o));
        standing().chain(moving()).chain(people).for_each(|(cause, side_m, o)| {
            let reach_m = o.half_length_m + o.half_width_m + own.half_width_m + side_m;
            if (o.center - o.center.clamp(low, high)).length() < reach_m
                && let Some((gap_m, leader_mps)) =
                    gap_along(ahead, SAMPLE_M, own.half_length_m, own.half_width_m + side_m, o)
            {
                brake_for(self.idm.interaction(speed, gap_m, leader_mps), cause);
            }
        });
        // In a bend a car sweeps more than its corridor: would its rectangle meet another's a little farther on?
        for reach_m in [0.8, 1.6, 2.6] {
            let there = route.ahead(reach_m, roads);
            let swept = Footprint { center: there.at, heading: there.tangent, ..*own }.grown(0.1);
            let meets = |o: &Footprint| {
                (o.center - own.center).length() < 14.0
                    && (o.center - own.center).dot(own.heading) > 0.0
                    && swept.overlaps(o)
            };
            if let Some((cause, ..)) = standing().chain(moving()).find(|(_, _, o)| meets(o)) {
                brake_for(self.idm.interaction(speed, reach_m - 0.6, 0.0), cause);
                break;
            }
        }
        // The end of the road.
        let end_m = route.remaining_m(roads) - own.half_length_m;
        if end_m < SIGHT_M {
            brake_for(self.idm.interaction(speed, end_m + 1.0, 0.0), Cause::RoadEnd);
        }
        let crossing = Crossing { slot, route, speed_mps: speed, half_length_m: own.half_length_m };
        if let Some((gap_m, refusal)) = stop_line(&crossing, &mut around.junctions, &around.lane_use, roads, step) {
            brake_for(self.idm.interaction(speed, gap_m, 0.0), Cause::Junction(refusal));
        }
        (self.interaction_mps2, self.cause) = worst;
    }
}

impl Controller for Driver {
    fn look(&mut self, own: Own<'_>, around: &mut Surroundings, streets: &Streets, step: u64) {
        let roads = &streets.roads;
        // The list is taken off the blackboard and put back, so that what it holds is not allocated anew.
        let mut ahead = std::mem::take(around.way_ahead_mut(own.slot));
        ahead.clear();
        self.cause = Cause::Nothing;
        if let Some(route) = self.route.as_ref().filter(|_| self.drives)
            && let Some(footprint) = around.vehicle(own.slot).copied()
        {
            let speed = footprint.velocity.dot(footprint.heading);
            self.desired_mps = self.idm.desired_speed_factor * route.speed_for_bends(speed, 1.5, roads);
            let sight_m = (speed * speed / (2.0 * COMFORTABLE_MPS2) + 2.0 * speed + 12.0).min(SIGHT_M);
            let count = (sight_m / SAMPLE_M) as usize;
            ahead.extend((0..count).map(|k| route.ahead(k as f64 * SAMPLE_M, roads)));
            self.reckon(own.slot, &footprint, &ahead, around, roads, step);
        }
        *around.way_ahead_mut(own.slot) = ahead;
    }

    fn act(&mut self, own: Own<'_>, physics: &mut Physics, streets: &Streets) {
        let Body::Sprung(chassis) = own.body else { return };
        let speed = chassis.speed_mps(physics);
        match self.route.as_ref().filter(|_| self.drives) {
            None => chassis.command(-3.0 * speed.clamp(-1.0, 1.0), 0.0, true, physics),
            Some(route) => {
                let pose = chassis.world_from_box(physics);
                let heading = (pose.rotation * DVec3::X).truncate().normalize();
                let axle_m = chassis.rear_axle_m();
                let rear_axle = pose.translation.truncate() - heading * axle_m;
                let wheelbase_m = chassis.wheelbase_m();
                let steer = pursue(rear_axle, heading, wheelbase_m, axle_m, speed, route, &streets.roads);
                let mut accel = pedals(self.idm.free_road(speed, self.desired_mps), self.interaction_mps2);
                let stand = accel < 0.05 && speed < 0.4;
                // Brakes stop a car, they don't push it backwards.
                if accel < 0.0 {
                    accel = accel.max(-speed / (2.0 * DT_S)).min(0.0);
                }
                chassis.command(accel, steer, stand, physics);
            }
        }
        chassis.apply(physics);
    }

    fn track(&mut self, own: Own<'_>, physics: &Physics, around: &mut Surroundings, streets: &Streets) {
        let Body::Sprung(chassis) = own.body else { return };
        let tail_m = own.appearance.size_lwh().x / 2.0 + 0.5;
        if let Some(route) = &mut self.route {
            let (slot, junctions) = (own.slot, &mut around.junctions);
            let position = chassis.world_from_box(physics).translation;
            route.track(position, &streets.roads, |lane, end_m| junctions.leaving(slot, lane, end_m + tail_m));
            junctions.advance(slot, route.lanes[0], route.s_m - tail_m);
            junctions.release_cleared(slot, route.odometer_m());
        }
        let stands = chassis.speed_mps(physics).abs() < STANDS_MPS;
        self.standing_steps = if stands { self.standing_steps + 1 } else { 0 };
    }

    fn on_lane(&self) -> Option<(LaneId, f64)> {
        self.route.as_ref().map(|r| (r.lanes[0], r.s_m))
    }
}
