//! What moves: rapier bodies, drivers, walkers, and the immutable picture of an instant that the sensors read.

mod car;
#[cfg(test)]
mod census_tests;
mod chassis;
mod driver;
#[cfg(test)]
mod flow_tests;
mod footing;
mod ground_shape;
mod junctions;
mod parked;
mod pavement;
mod pedestrian;
mod physics;
mod route;
mod settle;
mod snapshot;
mod spawn;
mod spawn_people;
#[cfg(test)]
mod testing;
#[cfg(test)]
mod tests;

use std::collections::BTreeMap;
use std::sync::Arc;

pub use physics::DT_S;
pub use snapshot::{EgoState, Snapshot};
pub use spawn::TrafficConfig;

use car::{Car, Exits, LOOK_EVERY};
use driver::Obstacle;
use junctions::Junctions;
use parked::Parked;
use pavement::Pavements;
use pedestrian::Walker;
use physics::Physics;
use route::{Roads, Route};
use settle::settle;

use crate::actor::ObjectClass;
use crate::assets::person::PersonModel;
use crate::assets::vehicle::{UserVehicles, VehicleModel};
use crate::error::{Error, Result};
use crate::math::DVec2;
use crate::rng::StreamKey;
use crate::town::{LaneId, LaneKind, Town};

/// Index of the ego in [`World::cars`].
const EGO: usize = 0;
/// Actors farther than this from the ego are left out of snapshots.
const SNAPSHOT_RADIUS_M: f64 = 250.0;

/// A town with what moves in it, stepped at 1/60 s.
///
/// # Determinism
/// A function of the town, the key and the calls made: the same calls give the same bits.
pub struct World {
    town: Arc<Town>,
    key: StreamKey,
    physics: Physics,
    roads: Roads,
    pavements: Pavements,
    junctions: Junctions,
    /// The ego first.
    cars: Vec<Car>,
    parked: Vec<Parked>,
    walkers: Vec<Walker>,
    /// Models by class and the seed that somebody named.
    models: BTreeMap<(ObjectClass, u64), Arc<VehicleModel>>,
    user_vehicles: UserVehicles,
    traffic: Option<TrafficConfig>,
    steps: u64,
    next_id: i32,
    respawns: u64,
}

impl World {
    /// A town without traffic: the ego stands settled on a driving lane with a long way ahead of it, or in the middle
    /// of the ground where there is no lane.
    ///
    /// # Errors
    /// [`Error::Scene`] for a ground without triangles, or one on which the ego finds no place.
    pub fn new(town: Arc<Town>, key: StreamKey) -> Result<Self> {
        let mut physics = Physics::new(Arc::clone(&town))?;
        let roads = Roads::new(Arc::clone(&town));
        let junctions = Junctions::new(&roads);
        let pavements = Pavements::new(Arc::clone(&town));
        let model = Arc::new(spawn::ego_model());
        let ego = spawn::place_ego(&mut physics, &roads, &town, model, key)?;
        Ok(Self {
            town,
            key,
            physics,
            roads,
            pavements,
            junctions,
            cars: vec![ego],
            parked: Vec::new(),
            walkers: Vec::new(),
            models: BTreeMap::new(),
            user_vehicles: UserVehicles::default(),
            traffic: None,
            steps: 0,
            next_id: 1,
            respawns: 0,
        })
    }

    /// The same world with a user's vehicles among those that are spawned or added from now on.
    #[must_use]
    pub fn with_user_vehicles(mut self, user_vehicles: UserVehicles) -> Self {
        self.user_vehicles = user_vehicles;
        self
    }

    /// The town around.
    #[must_use]
    pub fn town(&self) -> &Arc<Town> {
        &self.town
    }

    /// Seconds since the start.
    #[must_use]
    pub fn time_s(&self) -> f64 {
        self.steps as f64 * DT_S
    }

    /// Height of the uppermost ground at a place; `None` beyond its edge.
    #[must_use]
    pub fn ground_height(&self, x_m: f64, y_m: f64) -> Option<f64> {
        self.physics.ground_at(x_m, y_m).map(|g| g.z_m)
    }

    /// Adds a vehicle that stands, settled on the ground, or a person; returns the actor's id.
    ///
    /// # Errors
    /// [`Error::Scene`] for a place beyond the ground's edge or a class without a model, [`Error::NotFinite`].
    pub fn add(&mut self, class: ObjectClass, x_m: f64, y_m: f64, yaw_rad: f64, model_seed: u64) -> Result<i32> {
        let id = self.next_id;
        match class {
            ObjectClass::Car | ObjectClass::Van => {
                let model = self.vehicle_model(class, model_seed)?;
                self.parked.push(Parked::new(&mut self.physics, &self.roads, id, model, x_m, y_m, yaw_rad)?);
            }
            ObjectClass::Pedestrian => {
                let model = Arc::new(PersonModel::generate(model_seed));
                self.walkers.push(Walker::posed(&self.physics, id, model, x_m, y_m, yaw_rad, model_seed)?);
            }
            _ => {
                let name = class.kitti_name();
                return Err(Error::Scene { reason: format!("no model of class {name}: Car, Van or Pedestrian") });
            }
        }
        self.next_id += 1;
        Ok(id)
    }

    /// Adds a user's vehicle by its name, standing settled on the ground; returns the actor's id.
    ///
    /// # Errors
    /// [`Error::Unknown`] for a name that none has, [`Error::Scene`] for one of another class or a place beyond the
    /// ground's edge, [`Error::NotFinite`].
    pub fn add_user_vehicle(
        &mut self,
        class: ObjectClass,
        name: &str,
        x_m: f64,
        y_m: f64,
        yaw_rad: f64,
    ) -> Result<i32> {
        let model = Arc::clone(self.user_vehicles.by_name(name)?);
        if model.class != class {
            let (found, wanted) = (model.class.kitti_name(), class.kitti_name());
            return Err(Error::Scene { reason: format!("model {name:?} is a {found}, not a {wanted}") });
        }
        let id = self.next_id;
        let annotator_seed = self.key.indexed("annotated box", id as u64).next_u64();
        let model = Arc::new(VehicleModel::clone(&model).annotated_by(annotator_seed));
        self.parked.push(Parked::new(&mut self.physics, &self.roads, id, model, x_m, y_m, yaw_rad)?);
        self.next_id += 1;
        Ok(id)
    }

    /// Sets the ego down at (x, y), settled and standing; it stays there until [`World::drive`].
    ///
    /// # Errors
    /// [`Error::Scene`] beyond the ground's edge, [`Error::NotFinite`].
    pub fn move_ego(&mut self, x_m: f64, y_m: f64, yaw_rad: f64) -> Result<()> {
        let ego = &mut self.cars[EGO];
        let settled = settle(&self.physics, ego.model(), x_m, y_m, yaw_rad)?;
        ego.chassis.place(&mut self.physics, &settled.world_from_box);
        self.junctions.forget(EGO);
        ego.drives = false;
        ego.standing_steps = 0;
        let choices = self.key.indexed("ego route", self.steps);
        ego.route = self
            .roads
            .nearest(settled.world_from_box.translation, Some(yaw_rad), 3.0)
            .map(|(lane, s_m, _)| Route::new(lane, s_m, 0.0, route::EGO_STRAIGHT, choices, &self.roads));
        Ok(())
    }

    /// Advances by a number of steps of 1/60 s.
    pub fn step(&mut self, num_steps: u32) {
        for _ in 0..num_steps {
            self.step_once();
        }
    }

    /// Drives until the ego has gone `distance_m` along its route or has stood for `blocked_s` seconds, at most
    /// 120 s; returns the distance gone.
    ///
    /// # Errors
    /// [`Error::OutOfRange`] for a distance or a time that is negative or not finite.
    pub fn drive(&mut self, distance_m: f64, blocked_s: f64) -> Result<f64> {
        for (what, value) in [("distance", distance_m), ("blocked time", blocked_s)] {
            if !(value.is_finite() && value >= 0.0) {
                let expected = "a finite number, at least 0".to_owned();
                return Err(Error::OutOfRange { what, value: value.to_string(), expected });
            }
        }
        self.cars[EGO].drives = self.cars[EGO].route.is_some();
        let odometer = |world: &Self| world.cars[EGO].route.as_ref().map_or(0.0, Route::odometer_m);
        let start_m = odometer(self);
        let mut standing = 0;
        for _ in 0..(120.0 / DT_S) as u32 {
            if odometer(self) - start_m >= distance_m || f64::from(standing) * DT_S >= blocked_s {
                break;
            }
            self.step_once();
            standing = if self.cars[EGO].standing_steps > 0 { standing + 1 } else { 0 };
        }
        Ok(odometer(self) - start_m)
    }

    /// The ego: pose of its box frame on the ground, and velocity.
    #[must_use]
    pub fn ego(&self) -> EgoState {
        let chassis = &self.cars[EGO].chassis;
        EgoState {
            world_from_ego: chassis.world_from_box(&self.physics),
            velocity_world: chassis.velocity_world(&self.physics),
            angular_velocity_world: chassis.angular_velocity_world(&self.physics),
        }
    }

    /// The lane that the ego drives on.
    #[must_use]
    pub fn ego_lane(&self) -> Option<LaneId> {
        self.cars[EGO].route.as_ref().map(|r| r.lanes[0])
    }

    fn step_once(&mut self) {
        if self.steps.is_multiple_of(LOOK_EVERY) {
            self.look();
        }
        for car in &mut self.cars {
            car.drive(&self.physics, &self.roads);
            car.chassis.apply(&mut self.physics);
        }
        self.physics.step();
        for (i, car) in self.cars.iter_mut().enumerate() {
            car.track(i, &self.physics, &mut self.junctions, &self.roads);
        }
        self.walk();
        self.steps += 1;
        if self.steps.is_multiple_of(spawn::RENEW_EVERY) {
            self.renew_traffic();
        }
    }

    /// Everybody on foot sets a step, one after the other, so that two never take the same place.
    fn walk(&mut self) {
        let cars: Vec<Obstacle> = self.cars.iter().map(|c| c.footprint(&self.physics)).collect();
        let mut places: Vec<DVec2> = self.walkers.iter().map(Walker::at).collect();
        for (i, walker) in self.walkers.iter_mut().enumerate() {
            walker.walk(&self.physics, &self.pavements, &places, &cars);
            places[i] = walker.at();
        }
    }

    /// Everybody looks around.
    fn look(&mut self) {
        let footprints: Vec<Obstacle> = self.cars.iter().map(|c| c.footprint(&self.physics)).collect();
        let standing: Vec<Obstacle> = self.parked.iter().map(|p| p.footprint).collect();
        let in_lanes: Vec<Obstacle> = self.parked.iter().filter(|p| p.is_in_the_way).map(|p| p.footprint).collect();
        let on_road: Vec<Obstacle> = self.walkers.iter().filter_map(|w| w.in_the_way(&self.roads)).collect();
        let exits = Exits::of(&self.cars, &self.physics);
        for (i, car) in self.cars.iter_mut().enumerate() {
            let groups: [&[Obstacle]; 3] = [&in_lanes, &footprints, &on_road];
            car.look(i, &footprints[i], &groups, &mut self.junctions, &exits, &self.roads, self.steps);
        }
        pedestrian::look(&mut self.walkers, &self.pavements, &self.roads, &standing, &footprints, &self.cars);
    }

    fn vehicle_model(&mut self, class: ObjectClass, model_seed: u64) -> Result<Arc<VehicleModel>> {
        if let Some(model) = self.models.get(&(class, model_seed)) {
            return Ok(Arc::clone(model));
        }
        let model = Arc::new(VehicleModel::generate(class, model_seed)?);
        self.models.insert((class, model_seed), Arc::clone(&model));
        Ok(model)
    }
}

/// The lanes on which a car may be put: for driving, outside junctions.
fn open_lanes(roads: &Roads) -> impl Iterator<Item = &crate::town::Lane> {
    roads.lanes().iter().filter(|l| l.kind == LaneKind::Driving && l.junction.is_none())
}
