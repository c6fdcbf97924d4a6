//! A vehicle that is led along the ground: others bump into it, nothing moves it but who leads it.

use std::sync::Arc;

use rapier3d::prelude::{RigidBodyBuilder, RigidBodyHandle};

use super::Body;
use super::chassis::{MAX_STEER_RAD, STEER_RATE_RADPS};
use super::settle::{Settled, settle};
use super::wheels::CLEARANCE_M;
use crate::physics::{DT_S, Physics, pose_f32};
use cadet_assets::vehicle::VehicleModel;
use cadet_base::frames;
use cadet_base::math::{self, DPose3, DVec2, DVec3};

/// A kinematic body.
pub(crate) struct Guided {
    body: RigidBodyHandle,
    model: Arc<VehicleModel>,
    settled: Settled,
    yaw_rad: f64,
    velocity_world: DVec3,
    angular_velocity_world: DVec3,
    /// How far the wheels have rolled.
    roll_rad: f64,
    steer_rad: f64,
}

/// What a physics step does to a guided body.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Step {
    /// The middle of the box at the end of the step.
    pub at: DVec2,
    pub velocity: DVec2,
    /// Way of the wheels during the step.
    pub moved_m: f64,
    pub turn_rad: f64,
}

impl Guided {
    /// A vehicle on the ground that moves with a velocity in the plane.
    pub fn new(
        physics: &mut Physics,
        model: Arc<VehicleModel>,
        settled: Settled,
        yaw_rad: f64,
        velocity: DVec2,
    ) -> Self {
        let builder = RigidBodyBuilder::kinematic_position_based().pose(pose_f32(&settled.world_from_box));
        let body = physics.insert_vehicle(builder, model.size_lwh, CLEARANCE_M);
        let velocity_world = along_ground(velocity, &settled.world_from_box);
        let (roll_rad, steer_rad) = (0.0, 0.0);
        Self { body, model, settled, yaw_rad, velocity_world, angular_velocity_world: DVec3::ZERO, roll_rad, steer_rad }
    }

    pub fn yaw_rad(&self) -> f64 {
        self.yaw_rad
    }

    /// Leads the body to its place after the physics step to come.
    pub fn guide(&mut self, physics: &mut Physics, step: &Step) {
        self.yaw_rad = math::wrap_angle(self.yaw_rad + step.turn_rad);
        let at = step.at.extend(self.settled.world_from_box.translation.z);
        match settle(physics, &self.model, at, self.yaw_rad) {
            Ok(settled) => self.settled = settled,
            // A wheel has left the ground's edge: the body keeps its height.
            Err(_) => self.settled.world_from_box = frames::upright(at, self.yaw_rad),
        }
        self.velocity_world = along_ground(step.velocity, &self.settled.world_from_box);
        self.angular_velocity_world = DVec3::Z * (step.turn_rad / DT_S);
        self.roll_rad = math::wrap_angle(self.roll_rad + step.moved_m / self.model.wheel_radius_m);
        if step.moved_m > 0.0 {
            let wanted = math::atan(self.model.wheelbase_m() * step.turn_rad / step.moved_m)
                .clamp(-MAX_STEER_RAD, MAX_STEER_RAD);
            let most = STEER_RATE_RADPS * DT_S;
            self.steer_rad += (wanted - self.steer_rad).clamp(-most, most);
        }
        let body = &mut physics.world.bodies[self.body];
        body.set_next_kinematic_position(pose_f32(&self.settled.world_from_box));
    }
}

impl Body for Guided {
    fn world_from_box(&self, _physics: &Physics) -> DPose3 {
        self.settled.world_from_box
    }

    fn velocity_world(&self, _physics: &Physics) -> DVec3 {
        self.velocity_world
    }

    fn angular_velocity_world(&self, _physics: &Physics) -> DVec3 {
        self.angular_velocity_world
    }

    /// On the ground, steered and rolled.
    fn box_from_wheels(&self) -> Option<[DPose3; 4]> {
        Some(self.settled.box_from_wheels(&self.model, self.steer_rad, |_| self.roll_rad))
    }

    fn handle(&self) -> Option<RigidBodyHandle> {
        Some(self.body)
    }
}

/// A velocity in the plane as one along the ground that a box stands on.
pub(super) fn along_ground(velocity: DVec2, world_from_box: &DPose3) -> DVec3 {
    let up = world_from_box.rotation * DVec3::Z;
    velocity.extend(-up.truncate().dot(velocity) / up.z)
}
