//! How a rigid thing moves during the tenth of a second that a LIDAR takes to turn, or between two images.

use cadet_base::math::{DPose3, DQuat, DVec3};

/// A steady motion: the pivot moves along a line while the body turns about it. Exact for constant velocities; over
/// 0.05 s a car that brakes at 8 m/s^2 strays from it by 1 cm.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct RigidMotion {
    /// A point of the body at the instant 0.
    pub pivot_world: DVec3,
    /// That point's velocity, m/s.
    pub velocity_world: DVec3,
    /// Angular velocity of the body, rad/s.
    pub angular_velocity_world: DVec3,
}

impl RigidMotion {
    /// True for a body that rests.
    #[must_use]
    pub fn is_rest(&self) -> bool {
        self.velocity_world == DVec3::ZERO && self.angular_velocity_world == DVec3::ZERO
    }

    /// Takes a point of the body from where it is at the instant 0 to where it is `time_s` later.
    #[must_use]
    pub fn displacement(&self, time_s: f64) -> DPose3 {
        let turn = self.angular_velocity_world * time_s;
        let angle_rad = turn.length();
        let rotation = if angle_rad > 0.0 { axis_angle(turn / angle_rad, angle_rad) } else { DQuat::IDENTITY };
        let pivot_then = self.pivot_world + self.velocity_world * time_s;
        DPose3 { rotation, translation: pivot_then - rotation * self.pivot_world }
    }

    /// This motion, with its instant 0 `time_s` later.
    #[must_use]
    pub fn after(&self, time_s: f64) -> Self {
        Self { pivot_world: self.pivot_world + self.velocity_world * time_s, ..*self }
    }

    /// How far a point at `radius_m` from the pivot gets in `time_s` at most.
    #[must_use]
    pub fn reach_m(&self, radius_m: f64, time_s: f64) -> f64 {
        (self.velocity_world.length() + self.angular_velocity_world.length() * radius_m) * time_s.abs()
    }
}

fn axis_angle(axis: DVec3, angle_rad: f64) -> DQuat {
    let (sin, cos) = (cadet_base::math::sin(0.5 * angle_rad), cadet_base::math::cos(0.5 * angle_rad));
    DQuat::from_xyzw(axis.x * sin, axis.y * sin, axis.z * sin, cos)
}

#[cfg(test)]
mod tests {
    use super::*;
    use cadet_base::math::PI;

    #[test]
    fn a_body_circles_its_pivot_while_that_moves_on() {
        let motion = RigidMotion {
            pivot_world: DVec3::new(10.0, 0.0, 0.0),
            velocity_world: DVec3::new(0.0, 4.0, 0.0),
            angular_velocity_world: DVec3::new(0.0, 0.0, PI),
        };
        let then = motion.displacement(0.5).transform_point(DVec3::new(11.0, 0.0, 0.3));
        assert!((then - DVec3::new(10.0, 3.0, 0.3)).length() < 1e-12, "{then}");
        let back = motion.displacement(0.5).inverse().transform_point(then);
        assert!((back - DVec3::new(11.0, 0.0, 0.3)).length() < 1e-12, "{back}");
        assert!((then - DVec3::new(11.0, 0.0, 0.3)).length() <= motion.reach_m(1.0, 0.5));
        assert!(RigidMotion::default().is_rest() && RigidMotion::default().displacement(3.0) == DPose3::IDENTITY);
    }
}
