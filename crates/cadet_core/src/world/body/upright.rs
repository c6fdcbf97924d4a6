//! Somebody on foot.

use crate::frames;
use crate::math::{self, DPose3, DVec2, DVec3};

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

    pub fn world_from_box(&self) -> DPose3 {
        frames::upright(self.position, self.yaw_rad)
    }

    /// The place in the plane.
    pub fn at(&self) -> DVec2 {
        self.position.truncate()
    }

    /// Unit vector in the plane.
    pub fn heading(&self) -> DVec2 {
        DVec2::new(math::cos(self.yaw_rad), math::sin(self.yaw_rad))
    }
}
