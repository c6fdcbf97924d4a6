//! Agents that several placements make.

use std::sync::Arc;

use crate::agents::{Actor, Pedestrian};
use crate::arena::Arena;
use crate::body::{Cycle, Fixed, Guided, Upright, settle};
use crate::look::{CyclistLook, PersonLook, Ride, VehicleLook};
use cadet_assets::cyclist::CyclistModel;
use cadet_assets::person::PersonModel;
use cadet_assets::vehicle::VehicleModel;
use cadet_base::error::{Error, Result, finite};
use cadet_base::math::{DPose3, DVec2, DVec3};
use cadet_base::rng::Stream;

/// A vehicle that stands for good, settled on the ground.
///
/// # Errors
/// As [`settle`].
pub(super) fn parked_vehicle(
    arena: &mut Arena,
    model: Arc<VehicleModel>,
    at: DVec3,
    yaw_rad: f64,
) -> Result<Actor<Fixed, VehicleLook>> {
    let settled = settle(&arena.physics, &model, at, yaw_rad)?;
    let id = arena.next_id();
    let body = Fixed::new(&mut arena.physics, &model, &settled, id);
    Ok(Actor { body, look: VehicleLook::new(model, false) })
}

/// A vehicle that is led along the ground, with somebody at the wheel.
///
/// # Errors
/// As [`settle`].
pub(super) fn guided_vehicle(
    arena: &mut Arena,
    model: Arc<VehicleModel>,
    (at, yaw_rad, velocity): (DVec3, f64, DVec2),
) -> Result<Actor<Guided, VehicleLook>> {
    let settled = settle(&arena.physics, &model, at, yaw_rad)?;
    let body = Guided::new(&mut arena.physics, Arc::clone(&model), settled, yaw_rad, velocity);
    Ok(Actor { body, look: VehicleLook::new(model, true) })
}

/// A bicycle with its rider, at a pose with a yaw; `turn_phase` in [0, 1) is how far wheels and cranks have turned.
pub(super) fn ridden_bicycle(
    arena: &mut Arena,
    model: Arc<CyclistModel>,
    (world_from_box, yaw_rad): (DPose3, f64),
    velocity: DVec2,
    turn_phase: f64,
) -> Actor<Cycle, CyclistLook> {
    let body =
        Cycle::new(&mut arena.physics, model.size_lwh, model.wheelbase_m / 2.0, world_from_box, yaw_rad, velocity);
    Actor { body, look: CyclistLook { model, ride: Ride::new(turn_phase, velocity.length()) } }
}

/// Somebody who stands on the ground, mid-stride if the model walks, before anybody has told them where to go.
///
/// # Errors
/// [`Error::NotFinite`], [`Error::Scene`] beyond the ground's edge.
pub(super) fn standing_person(
    arena: &Arena,
    model: Arc<PersonModel>,
    at: DVec3,
    yaw_rad: f64,
    seed: u64,
) -> Result<Pedestrian> {
    let body = on_foot(arena, at, yaw_rad)?;
    let mut choices = Stream::from_seed("walker", seed);
    let phase = choices.unit();
    Ok(Pedestrian::standing(Actor { body, look: PersonLook { model, phase } }, choices))
}

/// Somebody's body on the ground.
///
/// # Errors
/// As [`standing_person`].
pub(super) fn on_foot(arena: &Arena, at: DVec3, yaw_rad: f64) -> Result<Upright> {
    let (x_m, y_m) = (finite("x", at.x)?, finite("y", at.y)?);
    finite("yaw", yaw_rad)?;
    let ground = arena.physics.ground_at(at).ok_or_else(|| Error::Scene {
        reason: format!("a person at ({x_m}, {y_m}) would stand beyond the ground's edge"),
    })?;
    Ok(Upright::standing(DVec3::new(x_m, y_m, ground.z_m), yaw_rad))
}
