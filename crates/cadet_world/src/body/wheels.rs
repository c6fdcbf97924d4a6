//! Where a vehicle's wheels are.

use cadet_base::math::{self, DPose3, DQuat, DVec3};

/// How high above the ground the body begins of what stands or is led.
pub(super) const CLEARANCE_M: f64 = 0.2;

/// The pose of wheel `index` in the box frame; right-hand wheels show their outer face to the right.
pub(super) fn wheel_pose(center: DVec3, index: usize, steer_rad: f64, roll_rad: f64) -> DPose3 {
    let side = if index % 2 == 1 { DQuat::from_rotation_z(math::PI) } else { DQuat::IDENTITY };
    let rotation = DQuat::from_rotation_z(steer_rad) * DQuat::from_rotation_y(roll_rad) * side;
    DPose3 { rotation, translation: center }
}
