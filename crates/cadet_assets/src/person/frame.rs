//! Where the trunk of a person is: positions by height above the hip joints.

use super::gait::Posture;
use super::proportions::Proportions;
use super::tube::Ring;
use cadet_base::math::{Vec3, cosf, sinf};

/// Corners a ring at each level of detail: trunk, legs, arms, head.
pub(crate) const SIDES: [[usize; 4]; 3] = [[24, 20, 16, 20], [12, 10, 8, 10], [6, 4, 4, 5]];

/// Positions on the trunk by height above the hip joints.
pub(crate) struct Frame<'a> {
    p: &'a Proportions,
    pub posture: &'a Posture,
    /// Scale of girths.
    pub girth_scale: f32,
}

impl<'a> Frame<'a> {
    pub fn new(p: &'a Proportions, posture: &'a Posture) -> Self {
        Self { p, posture, girth_scale: p.girth_factor * p.stature_m / 1.75 }
    }

    pub fn up(&self) -> Vec3 {
        let lean = self.posture.lean_rad;
        Vec3::new(sinf(lean), 0.0, cosf(lean))
    }

    pub fn spine(&self, z: f32) -> Vec3 {
        // The sway fades toward the head.
        let sway = self.posture.sway_m * (1.0 - 0.5 * (z / self.p.trunk_m).clamp(0.0, 1.0));
        Vec3::new(0.0, sway, 0.0) + self.up() * z
    }

    pub fn forward(&self, z: f32) -> Vec3 {
        let t = (z / self.p.trunk_m).clamp(0.0, 1.0);
        let yaw = self.posture.pelvis_yaw_rad + (self.posture.shoulder_yaw_rad - self.posture.pelvis_yaw_rad) * t;
        Vec3::new(cosf(yaw), sinf(yaw), 0.0)
    }

    pub fn left(&self, z: f32) -> Vec3 {
        let f = self.forward(z);
        Vec3::new(-f.y, f.x, 0.0)
    }

    pub fn ring(&self, z: f32, forward_m: f32, half: [f32; 2], slot: u8, level: usize) -> Ring {
        let forward = self.forward(z);
        Ring::new(self.spine(z) + forward * forward_m, [self.up(), forward], half, slot, level)
    }
}

/// Along a limb that hangs, swung forward by an angle.
pub(crate) fn down(angle_rad: f32) -> Vec3 {
    Vec3::new(sinf(angle_rad), 0.0, -cosf(angle_rad))
}
