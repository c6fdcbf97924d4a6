//! How a person sits: on a chair, a bench, a step.

use super::gait::{Arm, Leg, Posture};
use super::proportions::Proportions;
use cadet_base::math::acosf;
use cadet_base::rng::Stream;

/// The hip joints before the middle of the seat.
pub(super) const HIP_BEFORE_MIDDLE_M: f32 = -0.04;

/// What differs between people who sit.
#[derive(Debug, Clone, Copy)]
pub(super) struct Sitting {
    /// Height of the seat.
    pub seat_m: f32,
    /// The hip joints over the seat: what a person sits on is so thick.
    pub hip_over_seat_m: f32,
    /// By how much the thighs go down toward the knees, as a share of their length: left, right.
    slopes: [f32; 2],
    /// Whether the feet are before the knees rather than below the seat.
    is_stretched: bool,
    /// The trunk's forward lean.
    lean: f32,
    arms: [Arm; 2],
}

/// Hands on the thighs.
const ON_THIGHS: Arm = Arm { swing_rad: 0.30, lift_rad: 0.16, elbow_rad: 0.95, inward_rad: 0.35 };
/// Something is held or read, or the arms lie on a table.
const BEFORE_CHEST: Arm = Arm { swing_rad: 0.55, lift_rad: 0.14, elbow_rad: 1.25, inward_rad: 0.45 };
/// A telephone or a cup is at the head.
const AT_HEAD: Arm = Arm { swing_rad: 0.70, lift_rad: 0.20, elbow_rad: 2.1, inward_rad: 0.25 };
/// Hanging beside the seat.
const ASIDE: Arm = Arm { swing_rad: -0.05, lift_rad: 0.28, elbow_rad: 0.4, inward_rad: 0.1 };

impl Sitting {
    /// Draws how somebody sits whose annotated box is so long: the feet reach forward in long ones.
    pub fn draw(seat_m: f32, length_m: f64, s: &mut Stream) -> Self {
        let slopes = [0, 1].map(|_| s.range(-0.02, 0.10) as f32);
        let is_stretched = s.chance(((length_m - 0.55) * 2.5).clamp(0.1, 1.0));
        // Most lean back a little, some over a table or what they read.
        let lean = if s.chance(0.7) { s.range(-0.24, 0.02) } else { s.range(0.05, 0.32) } as f32;
        let arms = [0, 1].map(|_| [ON_THIGHS, BEFORE_CHEST, AT_HEAD, ASIDE][s.weighted(&[0.45, 0.35, 0.08, 0.12])]);
        Self { seat_m, hip_over_seat_m: 0.1, slopes, is_stretched, lean, arms }
    }

    /// Height of the hip joints.
    pub fn hip_m(&self) -> f32 {
        self.seat_m + self.hip_over_seat_m
    }

    /// The posture in which the soles are on the ground; short legs hang from a high seat.
    pub fn posture(&self, p: &Proportions) -> Posture {
        let from_hip_m = self.hip_m() - p.ankle_height_m;
        let leg = |slope: f32| {
            // Long shanks lean; short ones stand upright, and the thighs slope down to them.
            let slope = slope.max((from_hip_m - p.shank_m) / p.thigh_m).min(0.35);
            let drop = ((from_hip_m - slope * p.thigh_m) / p.shank_m).clamp(0.8, 1.0);
            let shank_rad = acosf(drop) * if self.is_stretched { 1.0 } else { -1.0 };
            Leg { thigh_rad: acosf(slope), shank_rad, sole_rad: 0.0 }
        };
        Posture { legs: self.slopes.map(leg), arms: self.arms, lean_rad: self.lean, ..Posture::default() }
    }
}
