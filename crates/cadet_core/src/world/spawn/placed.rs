//! What the user puts into a scene.

use std::sync::Arc;

use super::newcomers::{Person, parked_vehicle};
use crate::assets::person::PersonModel;
use crate::assets::vehicle::VehicleModel;
use crate::error::Result;
use crate::world::arena::{Arena, Newcomer};

/// Adds a vehicle that stands, settled on the ground; returns its id.
///
/// # Errors
/// [`crate::Error::Scene`] beyond the ground's edge, [`crate::Error::NotFinite`].
pub(crate) fn add_vehicle(
    arena: &mut Arena,
    model: Arc<VehicleModel>,
    x_m: f64,
    y_m: f64,
    yaw_rad: f64,
) -> Result<i32> {
    let newcomer = parked_vehicle(arena, model, x_m, y_m, yaw_rad)?;
    Ok(put(arena, newcomer))
}

/// Adds a person who stands, mid-stride if the model walks; returns its id.
///
/// # Errors
/// As [`add_vehicle`].
pub(crate) fn add_person(arena: &mut Arena, x_m: f64, y_m: f64, yaw_rad: f64, model_seed: u64) -> Result<i32> {
    let model = Arc::new(PersonModel::generate(model_seed));
    let person = Person::standing(arena, model, x_m, y_m, yaw_rad, model_seed)?;
    Ok(put(arena, person.into_newcomer()))
}

fn put(arena: &mut Arena, newcomer: Newcomer) -> i32 {
    let slot = arena.put(Newcomer { is_placed: true, ..newcomer });
    arena.agents[slot].id
}
