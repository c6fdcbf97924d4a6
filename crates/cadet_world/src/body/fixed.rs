//! A vehicle that stands where it was left.

use rapier3d::prelude::{RigidBodyBuilder, RigidBodyHandle};

use super::Body;
use super::settle::Settled;
use super::wheels::CLEARANCE_M;
use crate::physics::{Physics, pose_f32};
use cadet_assets::vehicle::VehicleModel;
use cadet_base::math::DPose3;

/// A body at rest for good.
pub(crate) struct Fixed {
    body: RigidBodyHandle,
    world_from_box: DPose3,
    box_from_wheels: [DPose3; 4],
}

impl Fixed {
    /// Sets a vehicle down; its wheels have rolled to a turn that depends a little on `id`.
    pub fn new(physics: &mut Physics, model: &VehicleModel, settled: &Settled, id: i32) -> Self {
        let world_from_box = settled.world_from_box;
        let builder = RigidBodyBuilder::fixed().pose(pose_f32(&world_from_box));
        let body = physics.insert_vehicle(builder, model.size_lwh, CLEARANCE_M);
        let box_from_wheels = settled.box_from_wheels(model, 0.0, |i| f64::from(id % 97) + i as f64);
        Self { body, world_from_box, box_from_wheels }
    }
}

impl Body for Fixed {
    fn world_from_box(&self, _physics: &Physics) -> DPose3 {
        self.world_from_box
    }

    fn box_from_wheels(&self) -> Option<[DPose3; 4]> {
        Some(self.box_from_wheels)
    }

    fn handle(&self) -> Option<RigidBodyHandle> {
        Some(self.body)
    }
}
