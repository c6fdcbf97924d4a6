//! A bicycle that its rider leads along the ground: two wheels one behind the other, upright.

use rapier3d::prelude::{RigidBodyBuilder, RigidBodyHandle};

use super::Body;
use super::guided::{Step, along_ground};
use super::wheels::CLEARANCE_M;
use crate::physics::{DT_S, Physics, pose_f32};
use cadet_base::error::{Error, Result, finite};
use cadet_base::frames;
use cadet_base::math::{self, DPose3, DVec2, DVec3};
use cadet_base::plane::unit;

/// A kinematic body.
pub(crate) struct Cycle {
    body: RigidBodyHandle,
    half_wheelbase_m: f64,
    world_from_box: DPose3,
    pub yaw_rad: f64,
    velocity_world: DVec3,
    angular_velocity_world: DVec3,
}

/// Pose of the box frame of a bicycle with both wheels on the ground under `at`; a crossfall does not tip it.
///
/// # Errors
/// [`Error::NotFinite`], or [`Error::Scene`] where a wheel would stand beyond the ground's edge.
pub(crate) fn stand_up(physics: &Physics, half_wheelbase_m: f64, at: DVec3, yaw_rad: f64) -> Result<DPose3> {
    let (x_m, y_m) = (finite("x", at.x)?, finite("y", at.y)?);
    finite("yaw", yaw_rad)?;
    let heading = unit(yaw_rad);
    let foot = |along_m: f64| {
        let p = DVec2::new(x_m, y_m) + heading * along_m;
        let ground = physics.ground_at(p.extend(at.z)).ok_or_else(|| Error::Scene {
            reason: format!("a bicycle at ({x_m}, {y_m}) would stand beyond the ground's edge"),
        })?;
        Ok(p.extend(ground.z_m))
    };
    let (rear, front) = (foot(-half_wheelbase_m)?, foot(half_wheelbase_m)?);
    let forward = front - rear;
    let left = heading.perp().extend(0.0);
    Ok(frames::facing((rear + front) / 2.0, forward, forward.cross(left)))
}

impl Cycle {
    /// A bicycle of a size on the ground that moves with a velocity in the plane.
    pub fn new(
        physics: &mut Physics,
        size_lwh: DVec3,
        half_wheelbase_m: f64,
        world_from_box: DPose3,
        yaw_rad: f64,
        velocity: DVec2,
    ) -> Self {
        let builder = RigidBodyBuilder::kinematic_position_based().pose(pose_f32(&world_from_box));
        let body = physics.insert_vehicle(builder, size_lwh, CLEARANCE_M);
        let velocity_world = along_ground(velocity, &world_from_box);
        Self { body, half_wheelbase_m, world_from_box, yaw_rad, velocity_world, angular_velocity_world: DVec3::ZERO }
    }

    /// The place in the plane.
    pub fn at(&self) -> DVec2 {
        self.world_from_box.translation.truncate()
    }

    /// Unit vector in the plane.
    pub fn heading(&self) -> DVec2 {
        unit(self.yaw_rad)
    }

    /// Leads the body to its place after the physics step to come.
    pub fn guide(&mut self, physics: &mut Physics, step: &Step) {
        self.yaw_rad = math::wrap_angle(self.yaw_rad + step.turn_rad);
        let at = step.at.extend(self.world_from_box.translation.z);
        self.world_from_box = stand_up(physics, self.half_wheelbase_m, at, self.yaw_rad)
            // A wheel has left the ground's edge: the body keeps its height.
            .unwrap_or_else(|_| frames::upright(at, self.yaw_rad));
        self.velocity_world = along_ground(step.velocity, &self.world_from_box);
        self.angular_velocity_world = DVec3::Z * (step.turn_rad / DT_S);
        let body = &mut physics.world.bodies[self.body];
        body.set_next_kinematic_position(pose_f32(&self.world_from_box));
    }
}

impl Body for Cycle {
    fn world_from_box(&self, _physics: &Physics) -> DPose3 {
        self.world_from_box
    }

    fn velocity_world(&self, _physics: &Physics) -> DVec3 {
        self.velocity_world
    }

    fn angular_velocity_world(&self, _physics: &Physics) -> DVec3 {
        self.angular_velocity_world
    }

    fn handle(&self) -> Option<RigidBodyHandle> {
        Some(self.body)
    }

    fn is_cycle(&self) -> bool {
        true
    }
}
