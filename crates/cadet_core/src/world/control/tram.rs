//! Who drives a tram, and the cars that follow the first on the track.

use std::sync::{Arc, Mutex, MutexGuard, PoisonError};

use super::constraints::{Cause, OnRoute, perceive};
use super::controller::{AgentParts, Controller, Outlook};
use super::idm::IdmParameters;
use super::junction_ahead::leave_junctions;
use crate::math::{self, DVec2};
use crate::rng::Stream;
use crate::town::LaneId;
use crate::world::body::{Body, Step};
use crate::world::params::{STANDS_MPS, TRAM};
use crate::world::physics::{DT_S, Physics};
use crate::world::route::Route;
use crate::world::streets::Streets;
use crate::world::track::Track;
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

/// What the cars of a train share.
#[derive(Debug)]
pub(crate) struct Train {
    pub track: Track,
    /// Distance of the train's front along the track.
    pub front_m: f64,
    pub length_m: f64,
    pub speed_mps: f64,
    pub accel_mps2: f64,
    /// What its driver brakes for.
    pub cause: Cause,
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
}

/// Leads a [`Body::Guided`] along a track.
pub(crate) struct TramCar {
    train: Arc<Mutex<Train>>,
    car: Coupled,
    /// Of the first car: who drives.
    driver: Option<TramDriver>,
}

/// Who drives.
pub(crate) struct TramDriver {
    route: Route,
    idm: IdmParameters,
    desired_mps: f64,
    interaction_mps2: f64,
    standing_steps: u64,
}

impl TramCar {
    /// The cars of a train that is on its way, the first ahead.
    pub fn train(train: Train, cars: &[Coupled], habits: &mut Stream) -> Vec<Self> {
        let middle_m = train.front_m - cars.first().map_or(0.0, |c| c.middle_m);
        let (_, s_m) = train.track.lane_at(middle_m);
        let route = Route::along(train.track.lanes_from(middle_m), s_m);
        let idm = TRAM.draw(habits);
        let mut driver =
            Some(TramDriver { route, idm, desired_mps: train.speed_mps, interaction_mps2: 0.0, standing_steps: 0 });
        let train = Arc::new(Mutex::new(train));
        cars.iter().map(|car| Self { train: Arc::clone(&train), car: *car, driver: driver.take() }).collect()
    }

    /// Whether it is the first of its train.
    pub fn leads(&self) -> bool {
        self.driver.is_some()
    }

    pub fn is_of_train_of(&self, other: &Self) -> bool {
        Arc::ptr_eq(&self.train, &other.train)
    }

    /// What the cars of the train share.
    pub fn shared(&self) -> MutexGuard<'_, Train> {
        self.train.lock().unwrap_or_else(PoisonError::into_inner)
    }

    /// How long the train has stood; 0 of those that don't lead.
    #[cfg(test)]
    pub fn standing_steps(&self) -> u64 {
        self.driver.as_ref().map_or(0, |d| d.standing_steps)
    }
}

impl TramDriver {
    /// Moves the train by a step.
    fn drive(&self, train: &mut Train) {
        train.accel_mps2 =
            self.idm.pedals(self.idm.free_road(train.speed_mps, self.desired_mps), self.interaction_mps2);
        train.speed_mps = (train.speed_mps + train.accel_mps2 * DT_S).max(0.0);
        let end_m = train.track.length_m() - 0.5;
        train.front_m = (train.front_m + train.speed_mps * DT_S).min(end_m.max(train.front_m));
    }
}

impl Controller for TramCar {
    fn look(&mut self, own: AgentParts<'_>, around: &TrafficState, streets: &Streets, step: u64) -> Outlook {
        let mut train = self.train.lock().unwrap_or_else(PoisonError::into_inner);
        let Some(driver) = &mut self.driver else { return Outlook::default() };
        let Some(footprint) = around.vehicle(own.slot) else { return Outlook::default() };
        let roads = &streets.roads;
        let end_m = train.track.length_m() - train.front_m - BEFORE_END_M;
        let for_end_mps = (2.0 * driver.idm.comfortable_mps2 * end_m.max(0.0)).sqrt();
        driver.desired_mps = (driver.idm.desired_speed_factor
            * driver.route.speed_for_bends(train.speed_mps, driver.idm.comfortable_mps2, roads))
        .min(for_end_mps);
        let rider = OnRoute {
            slot: own.slot,
            footprint,
            route: &driver.route,
            idm: &driver.idm,
            axles: None,
            train_m: Some(train.length_m),
            reduced_clearance: false,
        };
        let ahead = rider.in_sight(roads);
        let perceived = perceive(&rider, &ahead, around, roads, step);
        (driver.interaction_mps2, train.cause) = rider.tightest(&perceived.constraints);
        if end_m < 1.0 {
            // The end of the line: nothing but the brakes.
            driver.interaction_mps2 = -driver.idm.hardest_mps2;
            train.cause = Cause::RoadEnd;
        }
        Outlook { way_ahead: ahead, request: perceived.request, ..Outlook::default() }
    }

    fn act(&mut self, own: AgentParts<'_>, physics: &mut Physics, _streets: &Streets) {
        let Body::Guided(body) = own.body else { return };
        let mut train = self.train.lock().unwrap_or_else(PoisonError::into_inner);
        // The first car is called first: its slot is the lowest.
        if let Some(driver) = &self.driver {
            driver.drive(&mut train);
        }
        own.appearance.accelerate(train.accel_mps2);
        let (at, heading) = train.place(&self.car);
        let turn_rad = math::wrap_angle(math::atan2(heading.y, heading.x) - body.yaw_rad());
        let (velocity, moved_m) = (heading * train.speed_mps, train.speed_mps * DT_S);
        body.guide(physics, &Step { at, velocity, moved_m, turn_rad });
    }

    fn track(&mut self, own: AgentParts<'_>, _physics: &Physics, around: &mut TrafficState, streets: &Streets) {
        let Body::Guided(body) = own.body else { return };
        let train = self.train.lock().unwrap_or_else(PoisonError::into_inner);
        let Some(driver) = &mut self.driver else { return };
        // The train's tail, behind the middle of its first car.
        let tail_m = train.length_m - self.car.middle_m + 0.5;
        let position = body.world_from_box().translation;
        leave_junctions(own.slot, &mut driver.route, position, tail_m, &mut around.junctions, &streets.roads);
        driver.standing_steps = if train.speed_mps < STANDS_MPS { driver.standing_steps + 1 } else { 0 };
    }

    fn cause(&self) -> Cause {
        self.shared().cause
    }

    fn on_lane(&self) -> Option<(LaneId, f64)> {
        let train = self.shared();
        Some(match &self.driver {
            Some(driver) => (driver.route.lanes[0], driver.route.s_m),
            None => train.track.lane_at(train.front_m - self.car.middle_m),
        })
    }
}
