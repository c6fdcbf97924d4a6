//! A tram: a train of cars on its track, driven in the first of them.

use std::sync::Arc;

use super::actor::{Actor, ActorView};
use super::behavior::Behavior;
use crate::body::{Body, Guided, Step};
use crate::driving::{Cause, IdmParameters, OnRoute, leave_junctions, perceive};
use crate::look::VehicleLook;
use crate::outlook::Outlook;
use crate::params::{STANDS_MPS, TRAM};
use crate::physics::{DT_S, Physics};
use crate::slot::Slot;
use crate::streets::{LanePosition, Route, Streets, Track};
use crate::traffic_state::TrafficState;
use cadet_base::math::{self, DVec2};
use cadet_base::plane::heading_rad;
use cadet_base::rng::Stream;

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

    /// Where on the lanes the middle of a car is.
    fn position_of(&self, car: &Coupled) -> LanePosition {
        self.track.position(self.front_m - car.middle_m)
    }
}

/// A car of a train.
pub(crate) struct TramCar {
    pub own: Actor<Guided, VehicleLook>,
    pub coupled: Coupled,
}

impl TramCar {
    /// Leads the body to its place.
    fn follow(&mut self, train: &Train, physics: &mut Physics) {
        let Actor { body, look } = &mut self.own;
        look.accelerate(train.accel_mps2);
        let (at, heading) = train.place(&self.coupled);
        let turn_rad = math::wrap_angle(heading_rad(heading) - body.yaw_rad());
        let (velocity, moved_m) = (heading * train.speed_mps, train.speed_mps * DT_S);
        body.guide(physics, &Step { at, velocity, moved_m, turn_rad });
    }
}

/// A train of cars, and who drives it in the first of them.
pub(crate) struct Tram {
    /// The first car first.
    pub cars: Vec<TramCar>,
    pub train: Train,
    route: Route,
    idm: IdmParameters,
    desired_mps: f64,
    interaction_mps2: f64,
    pub standing_steps: u64,
    cause: Cause,
}

impl Tram {
    /// Of a train that is on its way.
    pub fn new(cars: Vec<TramCar>, train: Train, habits: &mut Stream) -> Self {
        let middle_m = train.front_m - cars[0].coupled.middle_m;
        let route = Route::along(train.track.lanes_from(middle_m), train.track.position(middle_m).s_m);
        let (idm, desired_mps) = (IdmParameters::draw(&TRAM, habits), train.speed_mps);
        Self { cars, train, route, idm, desired_mps, interaction_mps2: 0.0, standing_steps: 0, cause: Cause::Nothing }
    }
}

impl Behavior for Tram {
    fn actor(&self, k: usize) -> Option<ActorView<'_>> {
        self.cars.get(k).map(|car| car.own.view())
    }

    fn look(&mut self, slot: Slot, around: &TrafficState, streets: &Streets, step: u64) -> Outlook {
        let Some(footprint) = around.vehicle(slot) else { return Outlook::default() };
        let (graph, train) = (&streets.graph, &self.train);
        let end_m = train.track.length_m() - train.front_m - BEFORE_END_M;
        let for_end_mps = (2.0 * self.idm.comfortable_mps2 * end_m.max(0.0)).sqrt();
        self.desired_mps = (self.idm.desired_speed_factor
            * self.route.speed_for_bends(train.speed_mps, self.idm.comfortable_mps2, graph))
        .min(for_end_mps);
        let rider = OnRoute {
            slot,
            footprint,
            route: &self.route,
            idm: &self.idm,
            axles: None,
            train_m: Some(train.length_m),
            reduced_clearance: false,
            around,
            graph,
            step,
        };
        let ahead = rider.in_sight();
        let perceived = perceive(&rider, &ahead);
        (self.interaction_mps2, self.cause) = rider.tightest(&perceived.constraints);
        if end_m < 1.0 {
            // The end of the line: nothing but the brakes.
            self.interaction_mps2 = -self.idm.hardest_mps2;
            self.cause = Cause::RoadEnd;
        }
        Outlook { way_ahead: ahead, request: perceived.request, ..Outlook::default() }
    }

    fn act(&mut self, physics: &mut Physics, _streets: &Streets) {
        let train = &mut self.train;
        train.accel_mps2 =
            self.idm.pedals(self.idm.free_road(train.speed_mps, self.desired_mps), self.interaction_mps2);
        train.speed_mps = (train.speed_mps + train.accel_mps2 * DT_S).max(0.0);
        let end_m = train.track.length_m() - 0.5;
        train.front_m = (train.front_m + train.speed_mps * DT_S).min(end_m.max(train.front_m));
        for car in &mut self.cars {
            car.follow(train, physics);
        }
    }

    fn track(&mut self, slot: Slot, physics: &Physics, around: &mut TrafficState, streets: &Streets) {
        // The train's tail, behind the middle of its first car.
        let tail_m = self.train.length_m - self.cars[0].coupled.middle_m + 0.5;
        let position = self.cars[0].own.body.world_from_box(physics).translation;
        leave_junctions(slot, &mut self.route, position, tail_m, &mut around.junctions, &streets.graph);
        self.standing_steps = if self.train.speed_mps < STANDS_MPS { self.standing_steps + 1 } else { 0 };
    }

    fn cause(&self) -> Cause {
        self.cause
    }

    fn on_lane(&self, k: usize) -> Option<LanePosition> {
        let car = self.cars.get(k)?;
        Some(if k == 0 { self.route.position() } else { self.train.position_of(&car.coupled) })
    }
}
