//! How a rider sits: hips over the saddle, hands on the grips, feet on the pedals or one of them on the ground.

use super::bicycle::Bicycle;
use crate::person::arms::{add_arm, add_load, arm_to, shoulder, two_links};
use crate::person::body::{LegLine, add_leg, add_trunk, foot_axes};
use crate::person::frame::Frame;
use crate::person::gait::Posture;
use crate::person::head::add_head;
use crate::person::hold::Hold;
use crate::person::proportions::Proportions;
use crate::person::tube::Tubes;
use cadet_base::math::{Vec3, cosf};

/// Share of the leg's length at the lowest pedal.
const LEG_EXTENSION: f32 = 0.955;
/// Share of the arm's length to the grips.
const ARM_EXTENSION: f32 = 0.93;
/// Half the height of a pedal: the sole is this much over its middle.
pub(super) const PEDAL_HALF_M: f32 = 0.012;
/// The saddle's top lies this much below the hip joints.
pub(super) const SADDLE_BELOW_HIP_M: f32 = 0.085;
/// Least and greatest lean of the trunk.
const LEAN_RAD: [f32; 2] = [0.05, 0.90];
/// How far forward from the saddle one slides who stands.
const SLIDE_M: f32 = 0.20;
/// The foot on the ground stands this far beside the middle.
const FOOT_Y_M: f32 = 0.19;
/// Phase of the crank of who stands with the right foot on the ground: the left pedal is up and forward.
const START_PHASE: f32 = 0.14;

/// From the shoulder to the hand of an arm that is stretched out to the left, as a share of the arm's length.
const POINTING: Vec3 = Vec3::new(0.10, 0.97, -0.06);

/// Where hips and trunk are.
#[derive(Debug, Clone, Copy)]
pub(super) struct Seat {
    pub hip: Vec3,
    /// Forward lean of the trunk, radians.
    pub lean_rad: f32,
}

/// What the legs do.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) enum Legs {
    /// Both feet on the pedals, the crank at a phase.
    Pedal(f32),
    /// One foot on the ground: on the left if +1.
    Stand(f32),
}

impl Seat {
    /// On the saddle, at the height at which the leg is nearly straight on the lowest pedal.
    pub fn riding(p: &Proportions, bicycle: &Bicycle) -> Self {
        let ankle = ankle_on(p, bicycle.pedal(1.0, 0.47), 1.0, sole_pitch(0.47));
        let reach = LEG_EXTENSION * (p.thigh_m + p.shank_m);
        let hip_at = |z: f32| bicycle.seat_tube(z) + Vec3::Z * SADDLE_BELOW_HIP_M;
        let z = bisect(0.3, 1.3, |z| (hip_at(z) + Vec3::Y * p.hip_half_m - ankle).length() < reach);
        Self::leaning(p, bicycle, hip_at(z))
    }

    /// Before the saddle, with a leg straight down to the ground.
    pub fn standing(&self, p: &Proportions, bicycle: &Bicycle) -> Self {
        let reach = 0.985 * (p.thigh_m + p.shank_m);
        let aside = FOOT_Y_M - p.hip_half_m;
        let z = (reach * reach - aside * aside).sqrt() + p.ankle_height_m;
        Self::leaning(p, bicycle, Vec3::new(self.hip.x + SLIDE_M, 0.0, z.min(self.hip.z)))
    }

    /// As upright as the arms' reach asks for.
    fn leaning(p: &Proportions, bicycle: &Bicycle, hip: Vec3) -> Self {
        let arm = ARM_EXTENSION * arm_length(p);
        let is_too_far = |lean: f32| {
            let posture = Posture { lean_rad: lean, ..Posture::default() };
            (hip + shoulder(p, &Frame::new(p, &posture), 1.0) - bicycle.grip).length() > arm
        };
        Self { hip, lean_rad: bisect(LEAN_RAD[0], LEAN_RAD[1], is_too_far) }
    }

    /// Trunk, head, arms, and what is on the back. `pointing` stretches the arm of a side out by a share of the way.
    pub fn upper_body(&self, p: &Proportions, bicycle: &Bicycle, pointing: Option<(f32, f32)>, level: usize) -> Tubes {
        let mut tubes = Tubes::default();
        let posture = Posture { lean_rad: self.lean_rad, ..Posture::default() };
        let frame = Frame::new(p, &posture);
        add_trunk(&mut tubes, p, &frame, level);
        let mut hands = [Vec3::ZERO; 2];
        for (hand, side) in hands.iter_mut().zip([1.0, -1.0]) {
            let grip = bicycle.grip * Vec3::new(1.0, side, 1.0) - self.hip;
            let from = shoulder(p, &frame, side);
            let share = pointing.filter(|(of, _)| *of == side).map_or(0.0, |(_, share)| share);
            let out = from + POINTING * Vec3::new(1.0, side, 1.0) * arm_length(p);
            let grip = grip.lerp(out, share);
            *hand =
                add_arm(&mut tubes, p, &frame, &arm_to(p, &frame, side, grip, Hold::Still(grip).elbow_to(side)), level);
        }
        add_head(&mut tubes, p, &frame, level);
        add_load(&mut tubes, p, &frame, hands, level);
        self.place(tubes)
    }

    /// The legs. Feet are on the pedals as far as the legs reach.
    pub fn legs(&self, p: &Proportions, bicycle: &Bicycle, legs: Legs, level: usize) -> Tubes {
        let mut tubes = Tubes::default();
        for side in [1.0, -1.0] {
            let (ankle, sole_rad) = match legs {
                Legs::Stand(down) if down == side => (Vec3::new(self.hip.x, side * FOOT_Y_M, p.ankle_height_m), 0.0),
                _ => {
                    let phase = legs.crank_phase();
                    let own = if side > 0.0 { phase } else { phase + 0.5 };
                    let sole_rad = sole_pitch(own);
                    (ankle_on(p, bicycle.pedal(side, phase), side, sole_rad), sole_rad)
                }
            };
            let hip = Vec3::Y * (side * p.hip_half_m);
            let knee_to = Vec3::new(1.0, 0.10 * side, 0.3);
            let (thigh, shank) = two_links(hip, ankle - self.hip, p.thigh_m, p.shank_m, knee_to);
            let leg = (thigh + shank).normalize_or(Vec3::NEG_Z);
            let forward = (knee_to - leg * knee_to.dot(leg)).normalize();
            add_leg(&mut tubes, p, &LegLine { hip, thigh, shank, forward, sole_rad, side }, level);
        }
        self.place(tubes)
    }

    fn place(&self, mut tubes: Tubes) -> Tubes {
        for v in &mut tubes.vertices {
            *v += self.hip;
        }
        tubes
    }
}

impl Legs {
    /// Where the crank is.
    pub fn crank_phase(self) -> f32 {
        match self {
            Self::Pedal(phase) => phase,
            Self::Stand(down) => START_PHASE + if down < 0.0 { 0.0 } else { 0.5 },
        }
    }
}

fn arm_length(p: &Proportions) -> f32 {
    p.upper_arm_m + p.forearm_m + 0.5 * p.hand_m
}

/// Toes down at the bottom and behind, level at the top; `phase` is the foot's own, 0 on top.
fn sole_pitch(phase: f32) -> f32 {
    -0.17 + 0.13 * cosf((phase + 0.12) * std::f32::consts::TAU)
}

/// The ankle of a foot whose ball is on a pedal.
fn ankle_on(p: &Proportions, pedal: Vec3, side: f32, sole: f32) -> Vec3 {
    let (along, up) = foot_axes(sole, side);
    pedal + Vec3::Z * PEDAL_HALF_M - along * p.ball_before_ankle_m + up * p.ankle_height_m
}

/// The greatest value for which `holds` is true, if it is for all smaller ones.
fn bisect(mut low: f32, mut high: f32, holds: impl Fn(f32) -> bool) -> f32 {
    for _ in 0..24 {
        let middle = 0.5 * (low + high);
        if holds(middle) {
            low = middle;
        } else {
            high = middle;
        }
    }
    low
}
