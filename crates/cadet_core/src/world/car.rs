//! A car in traffic: chassis, driver and route together. The ego is one of them.

use std::sync::Arc;

use super::EGO;
use super::chassis::Chassis;
use super::driver::{COMFORTABLE_MPS2, Habits, Obstacle, gap_along, pedals, pursue};
use super::junctions::{Junctions, Refusal};
use super::physics::{DT_S, Physics};
use super::route::{Ahead, Roads, Route};
use crate::assets::vehicle::VehicleModel;
use crate::math::{DPose3, DVec2, DVec3};
use crate::town::LaneId;

/// Steps between two looks at the traffic; a driver needs no more than 20 a second.
pub(super) const LOOK_EVERY: u64 = 3;
/// How far a driver looks.
const SIGHT_M: f64 = 60.0;
const SAMPLE_M: f64 = 1.25;
/// Room kept beside what stands, and beside what moves.
const SIDE_STANDING_M: f64 = 0.12;
const SIDE_MOVING_M: f64 = 0.25;
/// Where the front bumper stops before a junction's first point: out of the sweep of those who turn in.
const STOP_LINE_M: f64 = 3.3;
/// The ego asks for its way across a junction this much earlier than others do.
const EGO_ASKS_EARLIER_M: f64 = 20.0;

/// What a driver brakes for most: named for the tests.
#[cfg_attr(not(test), allow(dead_code))]
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Cause {
    /// Nothing: the road is free, or nobody drives.
    Nothing,
    /// A parked vehicle in the lane.
    Parked,
    /// Another car, by its index.
    Car(usize),
    /// A person on the road.
    Person,
    /// The end of the road.
    RoadEnd,
    /// A junction that others cross or queue behind.
    Junction(Refusal),
}

/// A driven car.
pub(super) struct Car {
    /// 0 for the ego.
    pub id: i32,
    pub chassis: Chassis,
    pub route: Option<Route>,
    /// Whether the driver drives; otherwise the brakes hold.
    pub drives: bool,
    pub standing_steps: u64,
    habits: Habits,
    ahead: Vec<Ahead>,
    interaction_mps2: f64,
    desired_mps: f64,
    #[cfg_attr(not(test), allow(dead_code))]
    cause: Cause,
}

impl Car {
    pub fn new(id: i32, chassis: Chassis, route: Option<Route>, habits: Habits) -> Self {
        Self {
            id,
            chassis,
            drives: route.is_some(),
            route,
            standing_steps: 0,
            habits,
            ahead: Vec::new(),
            interaction_mps2: 0.0,
            desired_mps: 0.0,
            cause: Cause::Nothing,
        }
    }

    /// What the driver brakes for.
    #[cfg(test)]
    #[cfg_attr(not(test), allow(dead_code))]
    pub fn cause(&self) -> Cause {
        self.cause
    }

    pub fn model(&self) -> &Arc<VehicleModel> {
        &self.chassis.model
    }

    pub fn half_length_m(&self) -> f64 {
        self.chassis.model.size_lwh.x / 2.0
    }

    /// The way ahead as last looked at.
    pub fn way_ahead(&self) -> &[Ahead] {
        &self.ahead
    }

    /// The rectangle that the car covers.
    pub fn footprint(&self, physics: &Physics) -> Obstacle {
        footprint(
            &self.chassis.world_from_box(physics),
            self.chassis.model.size_lwh,
            self.chassis.velocity_world(physics).truncate(),
        )
    }

    /// Looks at bends, traffic and junctions; what it finds holds until the next look.
    pub fn look(
        &mut self,
        index: usize,
        own: &Obstacle,
        obstacles: &[&[Obstacle]],
        junctions: &mut Junctions,
        exits: &Exits,
        roads: &Roads,
        step: u64,
    ) {
        self.ahead.clear();
        self.cause = Cause::Nothing;
        let Some(route) = self.route.as_ref().filter(|_| self.drives) else { return };
        let speed = own.velocity.dot(own.heading);
        let half_length = self.chassis.model.size_lwh.x / 2.0;
        self.desired_mps = self.habits.eagerness * route.speed_for_bends(speed, 1.5, roads);
        let sight_m = (speed * speed / (2.0 * COMFORTABLE_MPS2) + 2.0 * speed + 12.0).min(SIGHT_M);
        let count = (sight_m / SAMPLE_M) as usize;
        self.ahead.extend((0..count).map(|k| route.ahead(k as f64 * SAMPLE_M, roads)));
        let (low, high) =
            self.ahead.iter().fold((DVec2::INFINITY, DVec2::NEG_INFINITY), |(lo, hi), a| (lo.min(a.at), hi.max(a.at)));
        let mut worst = (0.0_f64, Cause::Nothing);
        let mut brake_for = |interaction: f64, cause: Cause| {
            if interaction < worst.0 {
                worst = (interaction, cause);
            }
        };
        let cause_of = |kind: usize, i: usize| [Cause::Parked, Cause::Car(i), Cause::Person][kind];
        for (kind, group) in obstacles.iter().enumerate() {
            let side = if kind == 0 { SIDE_STANDING_M } else { SIDE_MOVING_M };
            for (i, obstacle) in group.iter().enumerate().filter(|(_, o)| {
                let reach_m = o.half_length_m + o.half_width_m + own.half_width_m + side;
                o.center != own.center && (o.center - o.center.clamp(low, high)).length() < reach_m
            }) {
                if let Some((gap, leader)) =
                    gap_along(&self.ahead, SAMPLE_M, half_length, own.half_width_m + side, obstacle)
                {
                    brake_for(self.habits.interaction(speed, gap, leader), cause_of(kind, i));
                }
            }
        }
        // In a bend a car sweeps more than its corridor: would its rectangle meet another's a little farther on?
        for reach_m in [0.8, 1.6, 2.6] {
            let there = route.ahead(reach_m, roads);
            let swept = Obstacle { center: there.at, heading: there.tangent, ..*own }.grown(0.1);
            let meets = |o: &&Obstacle| {
                (o.center - own.center).length() < 14.0
                    && o.center != own.center
                    && (o.center - own.center).dot(own.heading) > 0.0
                    && swept.overlaps(o)
            };
            let met = obstacles
                .iter()
                .take(2)
                .enumerate()
                .find_map(|(kind, group)| group.iter().position(|o| meets(&o)).map(|i| cause_of(kind, i)));
            if let Some(cause) = met {
                brake_for(self.habits.interaction(speed, reach_m - 0.6, 0.0), cause);
                break;
            }
        }
        // The end of the road.
        let end_m = route.remaining_m(roads) - half_length;
        if end_m < SIGHT_M {
            brake_for(self.habits.interaction(speed, end_m + 1.0, 0.0), Cause::RoadEnd);
        }
        if let Some((gap_m, refusal)) = self.stop_line(index, speed, junctions, exits, roads, step) {
            brake_for(self.habits.interaction(speed, gap_m, 0.0), Cause::Junction(refusal));
        }
        (self.interaction_mps2, self.cause) = worst;
    }

    /// The gap to a stop line where the next junction is not ours to cross, and why it is not.
    fn stop_line(
        &self,
        index: usize,
        speed_mps: f64,
        junctions: &mut Junctions,
        exits: &Exits,
        roads: &Roads,
        step: u64,
    ) -> Option<(f64, Refusal)> {
        let route = self.route.as_ref()?;
        let mut start_m = -route.s_m;
        let mut k = 0;
        for (i, id) in route.lanes.iter().enumerate() {
            if i > 0 && roads.lane(*id).junction.is_some() && !junctions.holds(index, *id) {
                k = i;
                break;
            }
            start_m += roads.lane(*id).length_m();
        }
        let front_m = start_m - self.half_length_m() - STOP_LINE_M;
        let early_m = if index == EGO { EGO_ASKS_EARLIER_M } else { 0.0 };
        let zone_m = speed_mps * speed_mps / (2.0 * COMFORTABLE_MPS2) + 0.5 * speed_mps.max(0.0) + 6.0 + early_m;
        // Over the line there is no stopping any more.
        if k == 0 || front_m > zone_m || front_m < -STOP_LINE_M - 0.5 {
            return None;
        }
        // Not before those ahead of us.
        let before_us = |lane: LaneId, first: bool| {
            exits.places.iter().any(|(l, car, s)| {
                *l == lane && *car != index && (!first || *s > route.s_m) && !junctions.holds_any(*car)
            })
        };
        if route.lanes.iter().take(k).enumerate().any(|(i, l)| before_us(*l, i == 0)) {
            return Some((front_m + 1.5, Refusal::NotFirst));
        }
        let chain: Vec<LaneId> =
            route.lanes.iter().skip(k).copied().take_while(|l| roads.lane(*l).junction.is_some()).collect();
        let exit = route.lanes.get(k + chain.len()).copied().unwrap_or(chain[chain.len() - 1]);
        let room_m = 2.0 * self.half_length_m() + 2.5;
        let exit_free = exits.room_m(exit, index) - junctions.promised_m(index, exit) >= room_m;
        junctions.request(index, &chain, exit, room_m, exit_free, step).err().map(|refusal| (front_m + 1.5, refusal))
    }

    /// Gives the chassis its commands for this step.
    pub fn drive(&mut self, physics: &Physics, roads: &Roads) {
        let speed = self.chassis.speed_mps(physics);
        let Some(route) = self.route.as_ref().filter(|_| self.drives) else {
            self.chassis.command(-3.0 * speed.clamp(-1.0, 1.0), 0.0, true, physics);
            return;
        };
        let pose = self.chassis.world_from_box(physics);
        let heading = (pose.rotation * DVec3::X).truncate().normalize();
        let rear_axle = pose.translation.truncate() - heading * self.chassis.rear_axle_m();
        let steer =
            pursue(rear_axle, heading, self.chassis.wheelbase_m(), self.chassis.rear_axle_m(), speed, route, roads);
        let mut accel = pedals(self.habits.free_road(speed, self.desired_mps), self.interaction_mps2);
        let stand = accel < 0.05 && speed < 0.4;
        // Brakes stop a car, they don't push it backwards.
        if accel < 0.0 {
            accel = accel.max(-speed / (2.0 * DT_S)).min(0.0);
        }
        self.chassis.command(accel, steer, stand, physics);
    }

    /// After the physics: where are we on the route?
    pub fn track(&mut self, index: usize, physics: &Physics, junctions: &mut Junctions, roads: &Roads) {
        let tail_m = self.half_length_m() + 0.5;
        if let Some(route) = &mut self.route {
            let position = self.chassis.world_from_box(physics).translation;
            route.track(position, roads, |lane, end_m| junctions.leaving(index, lane, end_m + tail_m));
            junctions.advance(index, route.lanes[0], route.s_m - tail_m);
            junctions.release_cleared(index, route.odometer_m());
        }
        let standing = self.chassis.speed_mps(physics).abs() < 0.1;
        self.standing_steps = if standing { self.standing_steps + 1 } else { 0 };
    }
}

/// The rectangle that a box covers in the plane.
pub(super) fn footprint(world_from_box: &DPose3, size_lwh: DVec3, velocity: DVec2) -> Obstacle {
    Obstacle {
        center: world_from_box.translation.truncate(),
        heading: (world_from_box.rotation * DVec3::X).truncate().normalize(),
        half_length_m: size_lwh.x / 2.0,
        half_width_m: size_lwh.y / 2.0,
        velocity,
    }
}

/// Who stands or crawls at the start of which lane, so that nobody enters a junction without a way out.
pub(super) struct Exits {
    /// (lane, car, distance of its tail from the lane's start).
    slow: Vec<(LaneId, usize, f64)>,
    /// (lane, car, distance of its middle along the lane).
    places: Vec<(LaneId, usize, f64)>,
}

impl Exits {
    pub fn of(cars: &[Car], physics: &Physics) -> Self {
        let slow = cars
            .iter()
            .enumerate()
            .filter(|(_, c)| c.chassis.speed_mps(physics) < 2.5)
            .filter_map(|(i, c)| c.route.as_ref().map(|r| (r.lanes[0], i, r.s_m - c.half_length_m())))
            .collect();
        let places =
            cars.iter().enumerate().filter_map(|(i, c)| c.route.as_ref().map(|r| (r.lanes[0], i, r.s_m))).collect();
        Self { slow, places }
    }

    fn room_m(&self, lane: LaneId, car: usize) -> f64 {
        self.slow.iter().filter(|s| s.0 == lane && s.1 != car).map(|s| s.2).fold(f64::INFINITY, f64::min)
    }
}
