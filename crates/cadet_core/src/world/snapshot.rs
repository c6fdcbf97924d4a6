//! The world at one instant, as the sensors see it.

use crate::actor::ActorState;
use crate::instance::Instance;
use crate::math::{DPose3, DVec3};

/// The ego vehicle at one instant.
#[derive(Debug, Clone)]
pub struct EgoState {
    /// The ego's box frame: x forward, y left, z up, origin on the ground under the middle of the car.
    pub world_from_ego: DPose3,
    /// Velocity of that origin.
    pub velocity_world: DVec3,
}

/// Immutable poses and shapes. The ego's own shape is not among them.
#[derive(Debug, Clone)]
pub struct Snapshot {
    /// Seconds since the scene's start.
    pub time_s: f64,
    /// The ego vehicle.
    pub ego: EgoState,
    /// Every visible thing, static ones first.
    pub instances: Vec<Instance>,
    /// Every actor but the ego, by rising id.
    pub actors: Vec<ActorState>,
}
