//! Sets a vehicle on the ground: height, pitch and roll from the ground under its four wheels.

use super::wheels::wheel_pose;
use crate::physics::Physics;
use cadet_assets::vehicle::VehicleModel;
use cadet_base::error::{Error, Result, finite};
use cadet_base::frames;
use cadet_base::math::{self, DPose3, DVec3};

/// A vehicle at rest on the ground.
#[derive(Debug, Clone)]
pub(crate) struct Settled {
    /// Pose of the box frame.
    pub world_from_box: DPose3,
    /// How far each wheel sits above (+) or below its design height, so that it touches the ground.
    pub wheel_lift_m: [f64; 4],
}

impl Settled {
    /// The four wheels on the ground, the front ones steered, each rolled by so much.
    pub fn box_from_wheels(
        &self,
        model: &VehicleModel,
        steer_rad: f64,
        roll_rad: impl Fn(usize) -> f64,
    ) -> [DPose3; 4] {
        std::array::from_fn(|i| {
            let center = model.wheel_centers[i].as_dvec3() + DVec3::Z * self.wheel_lift_m[i];
            wheel_pose(center, i, if i < 2 { steer_rad } else { 0.0 }, roll_rad(i))
        })
    }
}

/// The most that a wheel moves against the body to reach the ground.
const TRAVEL_M: f64 = 0.12;

/// Sets a vehicle down with the middle of its box at (x, y), on the ground under `at`.
///
/// # Errors
/// [`Error::NotFinite`], or [`Error::Scene`] where a wheel would stand beyond the ground's edge.
pub(crate) fn settle(physics: &Physics, model: &VehicleModel, at: DVec3, yaw_rad: f64) -> Result<Settled> {
    let (x_m, y_m) = (finite("x", at.x)?, finite("y", at.y)?);
    finite("yaw", yaw_rad)?;
    let outside =
        || Error::Scene { reason: format!("a vehicle at ({x_m}, {y_m}) would stand beyond the ground's edge") };
    let middle = physics.ground_at(at).ok_or_else(outside)?;
    let mut pose = frames::upright(DVec3::new(x_m, y_m, middle.z_m), yaw_rad);
    let heading = pose.rotation * DVec3::X;
    let contacts = model.wheel_centers.map(|c| DVec3::new(f64::from(c.x), f64::from(c.y), 0.0));
    // Where the wheels stand depends a little on the tilt, and the tilt on where they stand: twice is enough.
    for _ in 0..3 {
        let mut feet = [DVec3::ZERO; 4];
        for (foot, contact) in feet.iter_mut().zip(&contacts) {
            let p = pose.transform_point(*contact);
            *foot = p.with_z(physics.ground_at(p).ok_or_else(outside)?.z_m);
        }
        let [fl, fr, rl, rr] = feet;
        // The plane of best fit through four corners of a parallelogram: through their mean, along the mean edges.
        let mean = (fl + fr + rl + rr) / 4.0;
        let forward = (fl + fr - rl - rr) / 4.0;
        let left = (fl + rl - fr - rr) / 4.0;
        let up = forward.cross(left).normalize();
        let x_axis = heading - up * heading.dot(up);
        let mut next = frames::facing(mean, x_axis, up);
        let contact_mean = contacts.iter().fold(DVec3::ZERO, |a, c| a + *c) / 4.0;
        next.translation = mean - next.rotation * contact_mean;
        // Keep the middle of the box over (x, y), on the fitted plane.
        let (dx, dy) = (x_m - next.translation.x, y_m - next.translation.y);
        next.translation = DVec3::new(x_m, y_m, next.translation.z - (up.x * dx + up.y * dy) / up.z);
        pose = next;
    }
    let mut wheel_lift_m = [0.0; 4];
    for (lift, contact) in wheel_lift_m.iter_mut().zip(&contacts) {
        let p = pose.transform_point(*contact);
        let ground = physics.ground_at(p).ok_or_else(outside)?;
        *lift = (ground.z_m - p.z).clamp(-TRAVEL_M, TRAVEL_M);
    }
    debug_assert!(math::hypot(pose.translation.x - x_m, pose.translation.y - y_m) < 1e-9);
    Ok(Settled { world_from_box: pose, wheel_lift_m })
}
