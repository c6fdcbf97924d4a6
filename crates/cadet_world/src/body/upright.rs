//! Somebody on foot or on a seat, not in rapier's world.

use rapier3d::prelude::RigidBodyHandle;

use super::Body;
use crate::physics::Physics;
use cadet_base::frames;
use cadet_base::math::{DPose3, DVec2, DVec3};
use cadet_base::plane::unit;

/// A place on the ground and a heading.
#[derive(Debug, Clone)]
pub(crate) struct Upright {
    pub position: DVec3,
    pub yaw_rad: f64,
    pub velocity_world: DVec3,
}

impl Upright {
    pub fn standing(position: DVec3, yaw_rad: f64) -> Self {
        Self { position, yaw_rad, velocity_world: DVec3::ZERO }
    }

    /// The place in the plane.
    pub fn at(&self) -> DVec2 {
        self.position.truncate()
    }

    /// Unit vector in the plane.
    pub fn heading(&self) -> DVec2 {
        unit(self.yaw_rad)
    }
}

impl Body for Upright {
    fn world_from_box(&self, _physics: &Physics) -> DPose3 {
        frames::upright(self.position, self.yaw_rad)
    }

    fn velocity_world(&self, _physics: &Physics) -> DVec3 {
        self.velocity_world
    }

    fn handle(&self) -> Option<RigidBodyHandle> {
        None
    }

    fn person(&self) -> Option<&Upright> {
        Some(self)
    }
}
