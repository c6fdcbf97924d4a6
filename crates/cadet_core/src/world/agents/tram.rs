//! Who drives a tram in its first car, and the cars that follow it on the track.

use std::any::Any;
use std::sync::Arc;

use super::controller::{AgentParts, Controller};
use crate::math::{self, DVec2};
use crate::rng::Stream;
use crate::town::LaneId;
use crate::world::body::{Body, Step};
use crate::world::driving::IdmParameters;
use crate::world::driving::leave_junctions;
use crate::world::driving::perceive;
use crate::world::driving::{Cause, OnRoute};
use crate::world::outlook::Outlook;
use crate::world::params::{STANDS_MPS, TRAM};
use crate::world::physics::{DT_S, Physics};
use crate::world::slot::Slot;
use crate::world::streets::Route;
use crate::world::streets::Streets;
use crate::world::streets::Track;
use crate::world::traffic_state::TrafficState;

/// Where the first car stops before the end of its track.
const BEFORE_END_M: f64 = 3.0;

/// Where a car is in its train, in meters behind the train's front.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Coupled {
    /// Of the two points of the car that are over the track: its joints, or its bogie below a cab.
    pub pivots_m: [f64; 2],
    pub middle_m: f64,
}

/// A train on its track.
#[derive(Debug, Clone)]
pub(crate) struct Train {
    pub track: Arc<Track>,
    /// Distance of the train's front along the track.
    pub front_m: f64,
    pub length_m: f64,
    pub speed_mps: f64,
    pub accel_mps2: f64,
}

impl Train {
    /// Whether it has reached the end of its line.
    pub fn is_at_end(&self) -> bool {
        self.track.length_m() - self.front_m < BEFORE_END_M + 2.0 && self.speed_mps < STANDS_MPS
    }

    /// The middle of a car, and the way it heads.
    pub fn place(&self, car: &Coupled) -> (DVec2, DVec2) {
        let [front, rear] = car.pivots_m.map(|m| self.track.at(self.front_m - m));
        let heading = (front - rear).normalize_or(DVec2::X);
        // Halfway between both pivots, so that the chord's shortness shows as little as it can at both.
        let between_m = (car.pivots_m[0] + car.pivots_m[1]) / 2.0;
        ((front + rear) / 2.0 - heading * (car.middle_m - between_m), heading)
    }

    /// The lane that the middle of a car is on, and how far along it.
    fn lane_of(&self, car: &Coupled) -> (LaneId, f64) {
        self.track.lane_at(self.front_m - car.middle_m)
    }

    /// Leads the body of a car to its place.
    fn lead(&self, car: &Coupled, own: AgentParts<'_>, physics: &mut Physics) {
        let Body::Guided(body) = own.body else { return };
        own.appearance.accelerate(self.accel_mps2);
        let (at, heading) = self.place(car);
        let turn_rad = math::wrap_angle(math::atan2(heading.y, heading.x) - body.yaw_rad());
        let (velocity, moved_m) = (heading * self.speed_mps, self.speed_mps * DT_S);
        body.guide(physics, &Step { at, velocity, moved_m, turn_rad });
    }
}

/// Who drives a train, in its first car: leads a [`Body::Guided`] along a track.
pub(crate) struct TramDriver {
    pub train: Train,
    car: Coupled,
    route: Route,
    idm: IdmParameters,
    desired_mps: f64,
    interaction_mps2: f64,
    pub standing_steps: u64,
    cause: Cause,
}

impl TramDriver {
    /// Of a train that is on its way.
    pub fn new(train: Train, car: Coupled, habits: &mut Stream) -> Self {
        let middle_m = train.front_m - car.middle_m;
        let (_, s_m) = train.track.lane_at(middle_m);
        let route = Route::along(train.track.lanes_from(middle_m), s_m);
        let (idm, desired_mps) = (IdmParameters::draw(&TRAM, habits), train.speed_mps);
        Self { train, car, route, idm, desired_mps, interaction_mps2: 0.0, standing_steps: 0, cause: Cause::Nothing }
    }
}

impl Controller for TramDriver {
    fn look(&mut self, own: AgentParts<'_>, around: &TrafficState, streets: &Streets, step: u64) -> Outlook {
        let Some(footprint) = around.vehicle(own.slot) else { return Outlook::default() };
        let (roads, train) = (&streets.roads, &self.train);
        let end_m = train.track.length_m() - train.front_m - BEFORE_END_M;
        let for_end_mps = (2.0 * self.idm.comfortable_mps2 * end_m.max(0.0)).sqrt();
        self.desired_mps = (self.idm.desired_speed_factor
            * self.route.speed_for_bends(train.speed_mps, self.idm.comfortable_mps2, roads))
        .min(for_end_mps);
        let rider = OnRoute {
            slot: own.slot,
            footprint,
            route: &self.route,
            idm: &self.idm,
            axles: None,
            train_m: Some(train.length_m),
            reduced_clearance: false,
        };
        let ahead = rider.in_sight(roads);
        let perceived = perceive(&rider, &ahead, around, roads, step);
        (self.interaction_mps2, self.cause) = rider.tightest(&perceived.constraints);
        if end_m < 1.0 {
            // The end of the line: nothing but the brakes.
            self.interaction_mps2 = -self.idm.hardest_mps2;
            self.cause = Cause::RoadEnd;
        }
        Outlook { way_ahead: ahead, request: perceived.request, ..Outlook::default() }
    }

    fn act(&mut self, own: AgentParts<'_>, physics: &mut Physics, _streets: &Streets) {
        let train = &mut self.train;
        train.accel_mps2 =
            self.idm.pedals(self.idm.free_road(train.speed_mps, self.desired_mps), self.interaction_mps2);
        train.speed_mps = (train.speed_mps + train.accel_mps2 * DT_S).max(0.0);
        let end_m = train.track.length_m() - 0.5;
        train.front_m = (train.front_m + train.speed_mps * DT_S).min(end_m.max(train.front_m));
        train.lead(&self.car, own, physics);
    }

    fn track(&mut self, own: AgentParts<'_>, _physics: &Physics, around: &mut TrafficState, streets: &Streets) {
        let Body::Guided(body) = own.body else { return };
        // The train's tail, behind the middle of its first car.
        let tail_m = self.train.length_m - self.car.middle_m + 0.5;
        let position = body.world_from_box().translation;
        leave_junctions(own.slot, &mut self.route, position, tail_m, &mut around.junctions, &streets.roads);
        self.standing_steps = if self.train.speed_mps < STANDS_MPS { self.standing_steps + 1 } else { 0 };
    }

    fn cause(&self) -> Cause {
        self.cause
    }

    fn on_lane(&self) -> Option<(LaneId, f64)> {
        Some((self.route.lanes[0], self.route.s_m))
    }
}

/// A car of a tram behind the first: follows it in a [`Body::Guided`].
pub(crate) struct Trailer {
    /// The slot of the first car.
    pub leader: Slot,
    car: Coupled,
    on_lane: (LaneId, f64),
    cause: Cause,
}

impl Trailer {
    pub fn new(leader: Slot, train: &Train, car: Coupled) -> Self {
        Self { leader, car, on_lane: train.lane_of(&car), cause: Cause::Nothing }
    }
}

impl Controller for Trailer {
    fn follows(&self) -> Option<Slot> {
        Some(self.leader)
    }

    fn follow(&mut self, own: AgentParts<'_>, leader: &dyn Controller, physics: &mut Physics) {
        let leader: &dyn Any = leader;
        let Some(driver) = leader.downcast_ref::<TramDriver>() else { return };
        driver.train.lead(&self.car, own, physics);
        (self.on_lane, self.cause) = (driver.train.lane_of(&self.car), driver.cause);
    }

    fn cause(&self) -> Cause {
        self.cause
    }

    fn on_lane(&self) -> Option<(LaneId, f64)> {
        Some(self.on_lane)
    }
}
