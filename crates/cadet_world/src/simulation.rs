//! The world: a town and its agents, stepped.

use std::collections::BTreeMap;
use std::sync::Arc;

use super::arena::Arena;
use super::body::{Body, settle};
use super::course::{Course, ModelChoice, Overlap};
use super::ego_command::EgoCommand;
use super::footprint::Footprint;
use super::params::LOOK_STEPS;
use super::physics::DT_S;
use super::retouch::Retouch;
use super::slot::{EGO, Slot};
use super::snapshot::{EgoState, Snapshot, brakes_for};
use super::spawn::{
    EgoStarts, RENEW_EVERY, Respawns, Shortfall, Spawner, TrafficConfig, add_cyclist, add_figure, add_person,
    add_seated, add_vehicle, box_at, check_free, fill, leave, place_ego, renew, too_short,
};
use crate::agents::Agent;
use crate::look::Look;
use crate::streets::{EGO_STRAIGHT_WEIGHT, LanePosition, Route};
use cadet_assets::imported::{FigureModel, UserModel, UserModels};
use cadet_assets::vehicle::VehicleModel;
use cadet_base::actor::{BrakesFor, ObjectClass};
use cadet_base::error::{Error, Result};
use cadet_base::frames;
use cadet_base::instance::Instance;
use cadet_base::math::{DVec2, DVec3};
use cadet_base::rng::StreamKey;
use cadet_town::{LaneId, Town};

/// An ego whose front is nearer to the end of its road can't go on.
const END_ROOM_M: f64 = 4.0;
/// Steps between two looks at an ego that may come in anew, tries to find it a place, and the room that it needs there.
const RETURNS_EVERY: u64 = 60;
const RETURN_TRIES: usize = 40;
const RETURN_ROOM_M: f64 = 25.0;
/// The longest that one call drives.
const LONGEST_DRIVE_S: f64 = 120.0;

/// A town with what moves in it, stepped at 1/60 s.
///
/// # Determinism
/// A function of the town, the key and the calls made: the same calls give the same bits.
pub struct World {
    town: Arc<Town>,
    key: StreamKey,
    pub(super) arena: Arena,
    /// Models by class and the seed that somebody named.
    models: BTreeMap<(ObjectClass, u64), Arc<VehicleModel>>,
    user_models: UserModels,
    traffic: Option<TrafficConfig>,
    needs_lamps: bool,
    /// The scenery as it is at night, if it is.
    night_scenery: Option<Vec<Instance>>,
    rains: bool,
    steps: u64,
    respawns: Respawns,
}

impl World {
    /// A town without traffic: the ego stands settled on a driving lane with a long way ahead of it, or in the middle
    /// of the ground where there is no lane.
    ///
    /// # Errors
    /// [`Error::Scene`] for a ground without triangles, or one on which the ego finds no place.
    pub fn new(town: Arc<Town>, key: StreamKey) -> Result<Self> {
        let mut arena = Arena::new(&town)?;
        let ego = place_ego(&mut arena, &town, key)?;
        arena.put(ego);
        Ok(Self {
            town,
            key,
            arena,
            models: BTreeMap::new(),
            user_models: UserModels::default(),
            traffic: None,
            needs_lamps: false,
            night_scenery: None,
            rains: false,
            steps: 0,
            respawns: Respawns::default(),
        })
    }

    /// Adds a user's models to those that are spawned or added from now on.
    #[must_use]
    pub fn with_user_models(mut self, user_models: UserModels) -> Self {
        self.user_models = user_models;
        self
    }

    /// Sets whether the lamps of driven vehicles are lit.
    #[must_use]
    pub fn with_lamps(mut self, needs_lamps: bool) -> Self {
        self.needs_lamps = needs_lamps;
        self
    }

    /// Sets whether it is night: street lamps and windows are lit then, and low beams shine.
    #[must_use]
    pub fn with_night(mut self, is_night: bool) -> Self {
        self.night_scenery = is_night.then(|| self.town.scenery.iter().map(Instance::at_night).collect());
        self
    }

    /// Sets whether it rains: people have umbrellas then.
    #[must_use]
    pub fn with_rain(mut self, rains: bool) -> Self {
        self.rains = rains;
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
        self.arena.physics.ground_at(DVec3::new(x_m, y_m, f64::INFINITY)).map(|g| g.z_m)
    }

    /// Adds an agent that stands or follows a script; returns its id.
    ///
    /// # Errors
    /// [`Error::Scene`] for a place beyond the ground's edge or where somebody stands, a path that makes no sense, or a
    /// model of another class; [`Error::Unknown`] for a name that no model has;
    /// [`Error::OutOfRange`] for a speed; [`Error::NotFinite`].
    pub fn add(
        &mut self,
        class: ObjectClass,
        model: ModelChoice<'_>,
        course: &Course,
        overlap: Overlap,
    ) -> Result<i32> {
        let model = match (class, model) {
            (_, ModelChoice::Named(name)) => {
                let annotator_seed = self.key.indexed("annotated box", self.arena.next_id() as u64).next_u64();
                match self.user_models.by_name(class, name)? {
                    UserModel::Vehicle(model) => Arc::new(VehicleModel::clone(model).annotated_by(annotator_seed)),
                    UserModel::Figure(model) => {
                        let model = Arc::new(FigureModel::clone(model).annotated_by(annotator_seed));
                        return add_figure(&mut self.arena, model, course, overlap);
                    }
                }
            }
            (
                ObjectClass::Car | ObjectClass::Van | ObjectClass::Truck | ObjectClass::Tram | ObjectClass::Misc,
                ModelChoice::Seed(seed),
            ) => self.vehicle_model(class, seed)?,
            (ObjectClass::Pedestrian, ModelChoice::Seed(seed)) => {
                return add_person(&mut self.arena, seed, course, overlap);
            }
            (ObjectClass::Cyclist, ModelChoice::Seed(seed)) => {
                return add_cyclist(&mut self.arena, seed, course, overlap);
            }
            (ObjectClass::PersonSitting, ModelChoice::Seed(seed)) => {
                return add_seated(&mut self.arena, seed, course, overlap);
            }
        };
        add_vehicle(&mut self.arena, model, course, overlap)
    }

    /// Fills the world: parked cars, then driven ones, then people, then cyclists. To be called once, before the first step.
    /// Returns what found no room.
    ///
    /// # Errors
    /// [`Error::OutOfRange`] for a configuration that makes no sense, [`Error::Map`] for roads that are too short to drive.
    pub fn spawn_traffic(&mut self, config: &TrafficConfig) -> Result<Vec<Shortfall>> {
        if self.arena.ego_car().route.is_none() && self.town.network.driving().next().is_some() {
            return Err(too_short(&self.town, &self.arena.streets.graph));
        }
        let Self { arena, key, user_models, rains, .. } = self;
        let shortfalls = fill(&mut Spawner { arena, key: *key, config, user_models, rains: *rains }, &self.town)?;
        self.traffic = Some(config.clone());
        self.set_ego_driving(true);
        Ok(shortfalls)
    }

    /// Sets the ego down at (x, y), settled and standing; it stays there until [`World::drive`].
    ///
    /// # Errors
    /// [`Error::Scene`] beyond the ground's edge or where somebody stands, [`Error::NotFinite`].
    pub fn move_ego(&mut self, x_m: f64, y_m: f64, yaw_rad: f64, overlap: Overlap) -> Result<()> {
        self.put_ego(self.arena.physics.uppermost(DVec2::new(x_m, y_m)), yaw_rad, overlap)
    }

    fn put_ego(&mut self, at: DVec3, yaw_rad: f64, overlap: Overlap) -> Result<()> {
        let model = Arc::clone(&self.arena.ego_car().own.body.model);
        let settled = settle(&self.arena.physics, &model, at, yaw_rad)?;
        let cover = box_at(model.size_lwh, at, yaw_rad);
        check_free(&self.arena, Some(EGO), model.class, &cover, overlap)?;
        let choices = self.key.indexed("ego route", self.steps);
        let graph = &self.arena.streets.graph;
        let nearest = graph.nearest(settled.world_from_box.translation, Some(yaw_rad), 3.0);
        let route =
            nearest.map(|at| Route::new(LanePosition { left_m: 0.0, ..at }, EGO_STRAIGHT_WEIGHT, choices, graph));
        self.arena.around.junctions.forget(EGO);
        let (ego, physics) = self.arena.ego_car_mut();
        ego.own.body.place(physics, &settled.world_from_box);
        ego.wait_on(route);
        Ok(())
    }

    /// Drives the ego by command from now on; `None` lets its driver drive.
    ///
    /// # Errors
    /// [`Error::Scene`] for a command where the ego stands on no lane.
    pub fn command_ego(&mut self, command: Option<EgoCommand>) -> Result<()> {
        if command.is_some() && self.arena.ego_car().route.is_none() {
            return Err(Error::Scene { reason: "the ego is on no lane to drive along".to_owned() });
        }
        self.arena.ego_car_mut().0.obey(command);
        Ok(())
    }

    /// Advances by a number of steps of 1/60 s.
    pub fn step(&mut self, num_steps: u32) {
        for _ in 0..num_steps {
            self.step_once();
        }
    }

    /// Advances as [`World::step`] does; an ego that has driven to the end of its road comes in at another place, as others do.
    pub fn step_on(&mut self, num_steps: u32) {
        for _ in 0..num_steps {
            self.step_once();
            if self.steps.is_multiple_of(RETURNS_EVERY)
                && self.ego_is_at_road_end()
                && self.arena.ego_car().has_stopped()
            {
                self.bring_ego_in();
            }
        }
    }

    /// Puts the ego on another way, where nobody is near.
    fn bring_ego_in(&mut self) {
        let starts = EgoStarts::of(&self.arena.streets.graph);
        let mut stream = self.key.indexed("ego comes in", self.steps);
        for _ in 0..RETURN_TRIES {
            let graph = &self.arena.streets.graph;
            let Some((lane, s_m)) = starts.draw(&mut stream, graph) else { return };
            let pose = graph.lane(lane).pose_at(s_m);
            let at = pose.translation.truncate();
            let is_near = |(slot, f): (Slot, Footprint)| slot != EGO && (f.center - at).length() < RETURN_ROOM_M;
            if self.arena.vehicles().any(is_near) {
                continue;
            }
            if self.put_ego(pose.translation, frames::yaw_of(&pose), Overlap::Refuse).is_ok() {
                self.set_ego_driving(true);
                return;
            }
        }
    }

    /// Drives until the ego has gone `distance_m` along its route, has stood for `blocked_s` seconds, or has come to the end
    /// of its road, at most 120 s; returns the distance gone.
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
        self.set_ego_driving(true);
        let odometer = |world: &Self| world.arena.ego_car().route.as_ref().map_or(0.0, Route::odometer_m);
        let start_m = odometer(self);
        let mut standing = 0;
        for _ in 0..(LONGEST_DRIVE_S / DT_S) as u32 {
            let is_blocked = f64::from(standing) * DT_S >= blocked_s || self.ego_is_at_road_end();
            if odometer(self) - start_m >= distance_m || is_blocked {
                break;
            }
            self.step_once();
            standing = if self.arena.ego_car().standing_steps > 0 { standing + 1 } else { 0 };
        }
        Ok(odometer(self) - start_m)
    }

    /// The ego: pose of its box frame on the ground, and velocity.
    #[must_use]
    pub fn ego(&self) -> EgoState {
        let (body, physics) = (&self.arena.ego_car().own.body, &self.arena.physics);
        EgoState {
            world_from_ego: body.world_from_box(physics),
            velocity_world: body.velocity_world(physics),
            angular_velocity_world: body.angular_velocity_world(physics),
        }
    }

    /// What the ego's driver brakes or waits for.
    #[must_use]
    pub fn ego_brakes_for(&self) -> Option<BrakesFor> {
        brakes_for(&self.arena, self.arena.ego())
    }

    /// Whether the ego has come to where its road ends, so that it can't go on.
    #[must_use]
    pub fn ego_is_at_road_end(&self) -> bool {
        let half_m = self.arena.ego_car().own.look.size_lwh().x / 2.0;
        let end_m = self.arena.ego_car().route.as_ref().and_then(|route| route.ends_in_m(&self.arena.streets.graph));
        end_m.is_some_and(|m| m - half_m < END_ROOM_M)
    }

    /// The lane that the ego drives on.
    #[must_use]
    pub fn ego_lane(&self) -> Option<LaneId> {
        self.arena.ego_car().route.as_ref().map(|r| r.lanes[0])
    }

    /// The world as it is now: the town's scenery, then the actors within 250 m of the ego by rising id.
    #[must_use]
    pub fn snapshot(&self) -> Snapshot {
        Snapshot::of(
            &self.arena,
            &self.town,
            self.key,
            self.ego(),
            self.time_s(),
            self.needs_lamps,
            self.night_scenery.as_deref(),
        )
    }

    /// Shows an actor otherwise in all snapshots from now on.
    ///
    /// # Errors
    /// [`Error::Scene`] for the ego, or an id that nobody in the world has.
    pub fn retouch(&mut self, actor_id: i32, retouch: Retouch) -> Result<()> {
        let others = self.arena.present().filter(|(slot, _)| *slot != EGO).flat_map(|(_, agent)| agent.actors());
        let is_there = others.map(|(id, _)| id).any(|id| id == actor_id);
        if !is_there {
            return Err(Error::Scene { reason: format!("no actor but the ego has the id {actor_id}") });
        }
        self.arena.retouched.insert(actor_id, retouch);
        Ok(())
    }

    /// Takes note that actors were labeled: from now on their annotated boxes stay as they are.
    pub fn note_labeled(&mut self, actor_ids: &[i32]) {
        let eye_world = self.ego().world_from_ego.translation;
        let Arena { agents, physics, labeled_ends, .. } = &mut self.arena;
        for (id, actor) in agents.iter().flat_map(Agent::actors).filter(|(id, _)| actor_ids.contains(id)) {
            labeled_ends.entry(id).or_insert_with(|| actor.near_end(physics, eye_world));
        }
    }

    pub(super) fn set_ego_driving(&mut self, drives: bool) {
        let (ego, _) = self.arena.ego_car_mut();
        ego.drives = drives && ego.route.is_some();
    }

    fn step_once(&mut self) {
        // Newcomers come before a look around, so that nobody is said to wait for who has another's slot.
        if self.steps > 0
            && self.steps.is_multiple_of(RENEW_EVERY)
            && let Self { arena, key, user_models, traffic: Some(config), rains, .. } = self
        {
            renew(
                &mut Spawner { arena, key: *key, config, user_models, rains: *rains },
                &mut self.respawns,
                self.steps,
            );
        }
        if self.steps.is_multiple_of(LOOK_STEPS) {
            leave(&mut self.arena);
            self.arena.look(self.steps);
        }
        self.arena.step();
        self.steps += 1;
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
