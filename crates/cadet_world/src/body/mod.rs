//! How an agent stands in the world: a pose, and how it moves.

mod chassis;
mod cycle;
mod fixed;
mod guided;
mod settle;
mod upright;
mod wheels;

pub(super) use chassis::{Chassis, MAX_STEER_RAD, STEER_RATE_RADPS};
pub(super) use cycle::{Cycle, stand_up};
pub(super) use fixed::Fixed;
pub(super) use guided::{Guided, Step};
pub(super) use settle::{Settled, settle};
pub(super) use upright::Upright;

use rapier3d::prelude::RigidBodyHandle;

use super::physics::Physics;
use cadet_base::math::{DPose3, DVec3};

/// A body, in rapier's world or beside it.
pub(super) trait Body: Send + Sync {
    /// Pose of the box frame.
    fn world_from_box(&self, physics: &Physics) -> DPose3;

    /// Velocity of the box frame's origin.
    fn velocity_world(&self, _physics: &Physics) -> DVec3 {
        DVec3::ZERO
    }

    /// Angular velocity, rad/s; 0 for people, whose turns take longer than a scan.
    fn angular_velocity_world(&self, _physics: &Physics) -> DVec3 {
        DVec3::ZERO
    }

    /// Speed along the body's own x axis.
    fn forward_mps(&self, physics: &Physics) -> f64 {
        self.velocity_world(physics).dot(self.world_from_box(physics).rotation * DVec3::X)
    }

    /// The four wheels in the box frame; `None` for a body that has not as many.
    fn box_from_wheels(&self) -> Option<[DPose3; 4]> {
        None
    }

    /// The body's number in rapier's world, if it is there.
    fn handle(&self) -> Option<RigidBodyHandle>;

    /// Somebody on foot or on a seat: to others a person, not a vehicle.
    fn person(&self) -> Option<&Upright> {
        None
    }

    /// Whether it is a bicycle.
    fn is_cycle(&self) -> bool {
        false
    }
}
