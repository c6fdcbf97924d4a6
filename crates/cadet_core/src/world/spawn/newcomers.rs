//! The kinds of agents: which body, controller and appearance go together.

use std::sync::Arc;

use crate::actor::ObjectClass;
use crate::assets::cyclist::CyclistModel;
use crate::assets::person::PersonModel;
use crate::assets::vehicle::VehicleModel;
use crate::error::{Error, Result, finite};
use crate::math::{self, DPose3, DVec2, DVec3};
use crate::rng::Stream;
use crate::world::agents::{Controller, Driver, Parked, Pedestrian, Scripted};
use crate::world::arena::{AgentSpec, Arena};
use crate::world::body::{Body, Chassis, Cycle, Fixed, Guided, Upright, settle};
use crate::world::driving::IdmParameters;
use crate::world::look::Appearance;
use crate::world::look::Ride;
use crate::world::streets::Route;

/// A vehicle with somebody at the wheel.
pub(super) fn driven_vehicle(chassis: Chassis, route: Option<Route>, idm: IdmParameters) -> AgentSpec {
    let model = Arc::clone(&chassis.model);
    AgentSpec {
        class: model.class,
        body: Body::Sprung(Box::new(chassis)),
        controller: Box::new(Driver::new(route, idm)),
        appearance: Appearance::vehicle(model, true),
        is_placed: false,
    }
}

/// A vehicle that stands for good, settled on the ground.
///
/// # Errors
/// As [`settle`].
pub(super) fn parked_vehicle(
    arena: &mut Arena,
    model: Arc<VehicleModel>,
    x_m: f64,
    y_m: f64,
    yaw_rad: f64,
) -> Result<AgentSpec> {
    let settled = settle(&arena.physics, &model, x_m, y_m, yaw_rad)?;
    let id = arena.next_id();
    Ok(AgentSpec {
        class: model.class,
        body: Body::Fixed(Box::new(Fixed::new(&mut arena.physics, &model, &settled, id))),
        controller: Box::new(Parked),
        appearance: Appearance::vehicle(model, false),
        is_placed: false,
    })
}

/// A vehicle that follows a script, with somebody at the wheel.
///
/// # Errors
/// As [`settle`].
pub(super) fn guided_vehicle(arena: &mut Arena, model: Arc<VehicleModel>, script: Scripted) -> Result<AgentSpec> {
    let (at, yaw_rad, velocity) = script.start();
    let settled = settle(&arena.physics, &model, at.x, at.y, yaw_rad)?;
    let body = Guided::new(&mut arena.physics, Arc::clone(&model), settled, yaw_rad, velocity);
    Ok(AgentSpec {
        class: model.class,
        body: Body::Guided(Box::new(body)),
        controller: Box::new(script),
        appearance: Appearance::vehicle(model, true),
        is_placed: false,
    })
}

/// A car of a tram at a place of its track, heading along it.
///
/// # Errors
/// As [`settle`].
pub(super) fn tram_car(
    arena: &mut Arena,
    model: Arc<VehicleModel>,
    (at, heading): (DVec2, DVec2),
    speed_mps: f64,
    controller: Box<dyn Controller>,
) -> Result<AgentSpec> {
    let yaw_rad = math::atan2(heading.y, heading.x);
    let settled = settle(&arena.physics, &model, at.x, at.y, yaw_rad)?;
    let velocity = heading * speed_mps;
    let body = Guided::new(&mut arena.physics, Arc::clone(&model), settled, yaw_rad, velocity);
    Ok(AgentSpec {
        class: model.class,
        body: Body::Guided(Box::new(body)),
        controller,
        appearance: Appearance::vehicle(model, true),
        is_placed: false,
    })
}

/// A bicycle with its rider, at a pose with a yaw; `turn` in [0, 1) is how far wheels and cranks have turned.
pub(super) fn ridden_bicycle(
    arena: &mut Arena,
    model: Arc<CyclistModel>,
    (world_from_box, yaw_rad): (DPose3, f64),
    velocity: DVec2,
    controller: Box<dyn Controller>,
    turn: f64,
) -> AgentSpec {
    let body = Cycle::new(&mut arena.physics, &model, world_from_box, yaw_rad, velocity);
    AgentSpec {
        class: ObjectClass::Cyclist,
        body: Body::Cycle(Box::new(body)),
        controller,
        appearance: Appearance::Cyclist { model, ride: Ride::new(turn, velocity.length()) },
        is_placed: false,
    }
}

/// A person before anybody has told them where to go.
pub(super) struct Person {
    pub model: Arc<PersonModel>,
    pub body: Upright,
    /// Mid-stride if the model walks.
    pub phase: f64,
    pub pedestrian: Pedestrian,
}

impl Person {
    /// Somebody who stands on the ground.
    ///
    /// # Errors
    /// [`Error::NotFinite`], [`Error::Scene`] beyond the ground's edge.
    pub fn standing(
        arena: &Arena,
        model: Arc<PersonModel>,
        x_m: f64,
        y_m: f64,
        yaw_rad: f64,
        seed: u64,
    ) -> Result<Self> {
        finite("x", x_m)?;
        finite("y", y_m)?;
        finite("yaw", yaw_rad)?;
        let ground = arena.physics.ground_at(x_m, y_m).ok_or_else(|| Error::Scene {
            reason: format!("a person at ({x_m}, {y_m}) would stand beyond the ground's edge"),
        })?;
        let mut choices = Stream::from_seed("walker", seed);
        let phase = choices.unit();
        let body = Upright::standing(DVec3::new(x_m, y_m, ground.z_m), yaw_rad);
        Ok(Self { model, body, phase, pedestrian: Pedestrian::standing(choices) })
    }

    /// Somebody who follows a script.
    pub fn led_by(self, script: Scripted) -> AgentSpec {
        let velocity_world = script.start().2.extend(0.0);
        let body = Body::Upright(Upright { velocity_world, ..self.body });
        let appearance = Appearance::Person { model: self.model, phase: self.phase };
        AgentSpec { class: ObjectClass::Pedestrian, body, controller: Box::new(script), appearance, is_placed: false }
    }

    /// Somebody who decides for themselves.
    pub fn into_newcomer(self) -> AgentSpec {
        let Self { model, body, phase, pedestrian } = self;
        AgentSpec {
            class: ObjectClass::Pedestrian,
            body: Body::Upright(body),
            controller: Box::new(pedestrian),
            appearance: Appearance::Person { model, phase },
            is_placed: false,
        }
    }
}
