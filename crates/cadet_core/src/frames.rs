//! Poses, and the conversions between the world's, the LIDAR's and the camera's axes.

use crate::math::{DMat3, DPose3, DQuat, DVec3};

/// The pose of a thing that stands upright at a place, turned by `yaw_rad` about z.
#[must_use]
pub fn upright(position: DVec3, yaw_rad: f64) -> DPose3 {
    DPose3 { rotation: DQuat::from_rotation_z(yaw_rad), translation: position }
}

/// The pose at `position` whose x axis follows `forward` and whose z axis is as near to `up` as that allows.
///
/// `forward` and `up` must not be parallel.
#[must_use]
pub fn facing(position: DVec3, forward: DVec3, up: DVec3) -> DPose3 {
    let x = forward.normalize();
    let y = up.cross(x).normalize();
    let rotation = DQuat::from_mat3(&DMat3::from_cols(x, y, x.cross(y)));
    DPose3 { rotation, translation: position }
}

/// The heading of a pose's x axis about the world's z, in radians.
#[must_use]
pub fn yaw_of(pose: &DPose3) -> f64 {
    let x = pose.rotation * DVec3::X;
    crate::math::atan2(x.y, x.x)
}

/// Turns the LIDAR's axes (x forward, y left, z up) into the camera's (x right, y down, z forward).
#[must_use]
pub fn cam_axes_from_velo_axes() -> DMat3 {
    DMat3::from_cols(DVec3::new(0.0, 0.0, 1.0), DVec3::new(-1.0, 0.0, 0.0), DVec3::new(0.0, -1.0, 0.0))
}
