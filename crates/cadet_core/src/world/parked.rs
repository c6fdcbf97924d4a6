//! Vehicles that stand where they were left.

use std::sync::Arc;

use rapier3d::prelude::RigidBodyBuilder;

use super::car::footprint;
use super::chassis::{WheelPose, wheel_pose};
use super::driver::Obstacle;
use super::physics::{Physics, pose_f32};
use super::route::Roads;
use super::settle::{Settled, settle};
use crate::assets::vehicle::VehicleModel;
use crate::error::Result;
use crate::math::{DVec2, DVec3};

/// A parked vehicle.
pub(super) struct Parked {
    pub id: i32,
    pub model: Arc<VehicleModel>,
    pub settled: Settled,
    pub footprint: Obstacle,
    /// Whether drivers have to reckon with it: it stands in a lane or near one.
    pub is_in_the_way: bool,
}

impl Parked {
    /// Sets a vehicle on the ground for good.
    ///
    /// # Errors
    /// As [`settle`].
    pub fn new(
        physics: &mut Physics,
        roads: &Roads,
        id: i32,
        model: Arc<VehicleModel>,
        x_m: f64,
        y_m: f64,
        yaw_rad: f64,
    ) -> Result<Self> {
        let settled = settle(physics, &model, x_m, y_m, yaw_rad)?;
        let pose = &settled.world_from_box;
        physics.insert_vehicle(RigidBodyBuilder::fixed().pose(pose_f32(pose)), model.size_lwh, 0.2);
        let footprint = footprint(pose, model.size_lwh, DVec2::ZERO);
        let is_in_the_way = !keeps_off_lanes(roads, &footprint, 1.7);
        Ok(Self { id, model, settled, footprint, is_in_the_way })
    }

    /// The wheels in the box frame, each touching the ground; turned by a little that depends on the id.
    pub fn wheels(&self) -> [WheelPose; 4] {
        let mut wheels = [WheelPose::default(); 4];
        let turn = f64::from(self.id % 97);
        for (i, wheel) in wheels.iter_mut().enumerate() {
            let lift = DVec3::Z * self.settled.wheel_lift_m[i];
            *wheel = wheel_pose(self.model.wheel_centers[i].as_dvec3() + lift, i, 0.0, turn + i as f64);
        }
        wheels
    }
}

/// Whether a rectangle is at least `room_m` away from the middle of every driving lane.
pub(super) fn keeps_off_lanes(roads: &Roads, rectangle: &Obstacle, room_m: f64) -> bool {
    let reach_m = rectangle.half_length_m + rectangle.half_width_m + room_m;
    roads.driving_near(rectangle.center, reach_m).all(|lane| {
        lane.center
            .iter()
            .map(|p| p.truncate())
            .filter(|p| (*p - rectangle.center).length() < reach_m)
            .all(|p| (rectangle.closest_point(p) - p).length() > room_m)
    })
}
