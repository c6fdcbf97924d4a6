//! How a person holds legs and arms: the walking cycle over its phase, and ways to stand.

use std::f32::consts::TAU;

use super::proportions::{ArmPose, Proportions};
use cadet_base::math::{acosf, atan2f, cosf, sinf};

/// Sagittal angles of a leg over the cycle at every tenth, degrees: flexion and dorsiflexion positive, heel strike
/// first.
const HIP_DEG: [f32; 10] = [29.0, 25.0, 16.0, 6.0, -4.0, -10.0, -4.0, 13.0, 27.0, 32.0];
const KNEE_DEG: [f32; 10] = [5.0, 17.0, 15.0, 8.0, 5.0, 11.0, 37.0, 60.0, 51.0, 20.0];
const ANKLE_DEG: [f32; 10] = [0.0, -3.0, 4.0, 7.0, 9.0, 6.0, -16.0, -8.0, -1.0, 1.0];
/// Share of the cycle for which a foot is on the ground.
const STANCE: f32 = 0.6;

/// A leg in its sagittal plane, radians: angles from straight down, positive forward.
#[derive(Debug, Clone, Copy, Default)]
pub(crate) struct Leg {
    /// The thigh's direction.
    pub thigh_rad: f32,
    /// The shank's direction.
    pub shank_rad: f32,
    /// The sole's pitch, toes up positive.
    pub sole_rad: f32,
}

/// An arm, radians.
#[derive(Debug, Clone, Copy, Default)]
pub(crate) struct Arm {
    /// The upper arm's swing, forward positive.
    pub swing_rad: f32,
    /// The upper arm's lift to the side.
    pub lift_rad: f32,
    /// The elbow's flexion.
    pub elbow_rad: f32,
    /// How far the forearm points inward rather than forward.
    pub inward_rad: f32,
}

/// A whole posture; index 0 is the left side.
#[derive(Debug, Clone, Copy, Default)]
pub(crate) struct Posture {
    pub legs: [Leg; 2],
    pub arms: [Arm; 2],
    /// Of the walking cycle, in which what is held may move.
    pub phase: f32,
    /// Rotation of pelvis and of shoulders about z, radians.
    pub pelvis_yaw_rad: f32,
    pub shoulder_yaw_rad: f32,
    /// Sideways shift of the pelvis, meters to the left.
    pub sway_m: f32,
    /// Trunk's forward lean, radians.
    pub lean_rad: f32,
}

/// Periodic cubic (Catmull-Rom) interpolation of a table over the cycle.
fn periodic(table: &[f32; 10], phase: f32) -> f32 {
    let at = (phase - phase.floor()) * 10.0;
    let k = at.floor();
    let t = at - k;
    let p = |i: usize| table[(k as usize + 9 + i) % 10];
    let (a, b, c, d) = (p(0), p(1), p(2), p(3));
    b + 0.5 * t * (c - a + t * (2.0 * a - 5.0 * b + 4.0 * c - d + t * (3.0 * (b - c) + d - a)))
}

/// The leg that the table names, before the foot is held still.
fn table_leg(phase: f32, scale: f32) -> Leg {
    let angle = |table: &[f32; 10]| (periodic(table, phase) * scale).to_radians();
    let (hip, knee, ankle) = (angle(&HIP_DEG), angle(&KNEE_DEG), angle(&ANKLE_DEG));
    let pitch = hip - knee + ankle;
    // The table leaves the sole 5 degrees up while it is flat on the ground.
    let flat = (5.0 * scale).to_radians();
    let sole_rad = if pitch > flat { pitch - flat } else { pitch.min(0.0) };
    Leg { thigh_rad: hip, shank_rad: hip - knee, sole_rad }
}

/// Where the ankle is relative to where it is with the sole flat, when the foot rolls over heel and ball.
fn roll(p: &Proportions, sole: f32) -> f32 {
    let (c, s) = (cosf(sole), sinf(sole));
    let (heel, ball, height) = (p.heel_behind_ankle_m, p.ball_before_ankle_m, p.ankle_height_m);
    if sole > 0.0 { heel * (c - 1.0) - height * s } else { ball * (1.0 - c) - height * s }
}

/// Ankle relative to the hip: forward and up.
fn ankle(p: &Proportions, leg: Leg) -> (f32, f32) {
    (
        p.thigh_m * sinf(leg.thigh_rad) + p.shank_m * sinf(leg.shank_rad),
        -p.thigh_m * cosf(leg.thigh_rad) - p.shank_m * cosf(leg.shank_rad),
    )
}

/// By how much the table's ankle lies behind the place that keeps the standing foot still on the ground.
fn slip(p: &Proportions, phase: f32, scale: f32) -> f32 {
    let planted = |phase: f32| -> f32 {
        let leg = table_leg(phase, scale);
        roll(p, leg.sole_rad) - p.cycle_length_m * phase - ankle(p, leg).0
    };
    let middle = planted(0.25);
    if phase < STANCE {
        planted(phase) - middle
    } else {
        // The swinging foot eases from one footprint to the next.
        let t = (phase - STANCE) / (1.0 - STANCE);
        let smooth = t * t * (3.0 - 2.0 * t);
        let (from, to) = (planted(STANCE) - middle, planted(0.0) - middle);
        from + (to - from) * smooth
    }
}

fn walking_leg(p: &Proportions, phase: f32, scale: f32) -> Leg {
    let phase = phase - phase.floor();
    let leg = table_leg(phase, scale);
    let (x, z) = ankle(p, leg);
    let x = x + slip(p, phase, scale);
    // Two-link inverse kinematics with the knee forward.
    let (a, b) = (p.thigh_m, p.shank_m);
    let reach = (x * x + z * z).sqrt().clamp((a - b).abs() + 1e-3, 0.9985 * (a + b));
    let at_hip = acosf(((a * a + reach * reach - b * b) / (2.0 * a * reach)).clamp(-1.0, 1.0));
    let at_knee = acosf(((a * a + b * b - reach * reach) / (2.0 * a * b)).clamp(-1.0, 1.0));
    let thigh_rad = atan2f(x, -z) + at_hip;
    Leg { thigh_rad, shank_rad: thigh_rad - (std::f32::consts::PI - at_knee), sole_rad: leg.sole_rad }
}

/// The posture of a walker at a phase of the cycle; the left heel strikes at 0.
pub(crate) fn walking(p: &Proportions, phase: f32) -> Posture {
    // The tables are of steps of 41 % of the stature.
    let scale = (p.cycle_length_m / (2.0 * 0.41 * p.stature_m)).clamp(0.6, 1.3);
    let legs = [walking_leg(p, phase, scale), walking_leg(p, phase + 0.5, scale)];
    let turn = cosf(phase * TAU);
    let arm = |side: f32, pose: ArmPose| match pose {
        ArmPose::Swing => {
            let swing_rad = -22.0_f32.to_radians() * turn * side * scale + 0.05;
            let lift_rad = 0.10 + p.arms_out_rad;
            Arm { swing_rad, lift_rad, elbow_rad: p.elbow_rad + 0.20 * swing_rad.max(0.0), inward_rad: 0.25 }
        }
        held => held_arm(p, held, 0.3 * turn * side),
    };
    Posture {
        legs,
        arms: [arm(1.0, p.arms[0]), arm(-1.0, p.arms[1])],
        phase,
        pelvis_yaw_rad: -4.0_f32.to_radians() * turn * scale,
        shoulder_yaw_rad: 5.0_f32.to_radians() * turn * scale,
        sway_m: 0.018 * sinf(phase * TAU - 0.3),
        lean_rad: p.lean_rad,
    }
}

fn held_arm(p: &Proportions, pose: ArmPose, swing: f32) -> Arm {
    let arm = match pose {
        ArmPose::Swing | ArmPose::Hang => {
            Arm { swing_rad: 0.06 + 0.15 * swing, lift_rad: 0.14, elbow_rad: 0.6 * p.elbow_rad, inward_rad: 0.3 }
        }
        ArmPose::Phone => Arm { swing_rad: 0.35, lift_rad: 0.15, elbow_rad: 1.75, inward_rad: 0.35 },
        ArmPose::Pocket => Arm { swing_rad: -0.25, lift_rad: 0.30, elbow_rad: 0.75, inward_rad: 0.55 },
        ArmPose::Crossed => Arm { swing_rad: 0.30, lift_rad: 0.12, elbow_rad: 1.55, inward_rad: 1.15 },
        ArmPose::Carry => Arm { swing_rad: 0.05 + 0.2 * swing, lift_rad: 0.20, elbow_rad: 0.12, inward_rad: 0.0 },
        ArmPose::Strap => Arm { swing_rad: 0.20, lift_rad: 0.18, elbow_rad: 2.0, inward_rad: 0.3 },
    };
    Arm { lift_rad: arm.lift_rad + p.arms_out_rad, ..arm }
}

/// The posture of a person who stands with the weight on one leg.
pub(crate) fn standing(p: &Proportions) -> Posture {
    // Legs apart alike, so that both feet stay on the ground.
    let apart_rad = 0.5 * p.stance_m / (p.thigh_m + p.shank_m);
    let straight = Leg { thigh_rad: -apart_rad, shank_rad: -0.01 - apart_rad, sole_rad: 0.0 };
    let bent = Leg { thigh_rad: 0.16 + apart_rad, shank_rad: -0.10 + apart_rad, sole_rad: 0.0 };
    let is_left = p.weight_on_left;
    Posture {
        legs: if is_left { [straight, bent] } else { [bent, straight] },
        arms: p.arms.map(|a| held_arm(p, a, 0.0)),
        shoulder_yaw_rad: if is_left { 0.06 } else { -0.06 },
        sway_m: if is_left { 0.035 } else { -0.035 },
        lean_rad: p.lean_rad,
        ..Posture::default()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_table_is_hit_at_its_knots_and_wraps() {
        for k in 0..10 {
            assert!((periodic(&KNEE_DEG, k as f32 / 10.0) - KNEE_DEG[k]).abs() < 0.02);
        }
        assert!((periodic(&HIP_DEG, 0.9999) - periodic(&HIP_DEG, 0.0)).abs() < 0.1);
    }
}
