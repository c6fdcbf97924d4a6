//! What moves of a cyclist: wheels, cranks, the foot that is put down, and the lean in bends.

use super::turn_signal::TurnSignal;
use crate::physics::{DT_S, GRAVITY_MPS2};
use cadet_assets::cyclist::CyclistModel;
use cadet_base::math::{self, DPose3, DQuat, DVec3, TAU};

/// Speeds below which a cyclist puts a foot down, and above which the foot is taken up.
const FOOT_DOWN_MPS: f64 = 0.15;
const FOOT_UP_MPS: f64 = 0.5;
/// The most that one leans over, and how fast.
const MAX_LEAN_RAD: f64 = 0.30;
const LEAN_RADPS: f64 = 0.6;
/// How fast an arm is stretched out, whole ways a second.
const ARM_HZ: f64 = 2.0;

/// The state of a cyclist's parts.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Ride {
    /// How far the wheels have turned.
    pub roll_rad: f64,
    /// Phase of the crank in [0, 1).
    pub crank_phase: f64,
    /// Into the bend, to the left if positive.
    pub lean_rad: f64,
    /// Whether a foot is on the ground.
    pub stands: bool,
    /// How far an arm is stretched out: 1 is the left one, -1 the right one.
    pub arm_share: f64,
}

impl Ride {
    /// With wheels and cranks somewhere in their turns.
    pub fn new(turn_phase: f64, speed_mps: f64) -> Self {
        let crank_phase = (turn_phase * 7.0).fract();
        Self {
            roll_rad: turn_phase * TAU,
            crank_phase,
            lean_rad: 0.0,
            arm_share: 0.0,
            stands: speed_mps < FOOT_DOWN_MPS,
        }
    }

    /// One physics step of `moved_m` and a turn; the legs rest when they need not drive.
    pub fn advance(&mut self, model: &CyclistModel, moved_m: f64, turn_rad: f64, pedals: bool) {
        let speed_mps = moved_m / DT_S;
        self.stands = speed_mps < if self.stands { FOOT_UP_MPS } else { FOOT_DOWN_MPS };
        self.roll_rad = math::wrap_angle(self.roll_rad + moved_m / model.wheel_radius_m);
        if pedals && !self.stands {
            self.crank_phase = (self.crank_phase + moved_m / model.development_m).fract();
        }
        let wanted = math::atan(speed_mps * turn_rad / DT_S / GRAVITY_MPS2).clamp(-MAX_LEAN_RAD, MAX_LEAN_RAD);
        let most = LEAN_RADPS * DT_S;
        self.lean_rad += (wanted - self.lean_rad).clamp(-most, most);
    }

    /// One physics step of an arm on its way out or back; the other one waits until it is back.
    pub fn point(&mut self, wanted: TurnSignal) {
        let wanted = match wanted {
            TurnSignal::Left => 1.0,
            TurnSignal::Right => -1.0,
            TurnSignal::Off | TurnSignal::Hazard => 0.0,
        };
        let wanted: f64 = if self.stands { 0.0 } else { wanted };
        self.arm_share += (wanted - self.arm_share).clamp(-ARM_HZ * DT_S, ARM_HZ * DT_S);
    }

    /// The leaning frame in the upright box frame: it tips about the line on which the wheels stand.
    pub fn box_from_leaning(&self) -> DPose3 {
        DPose3 { rotation: DQuat::from_rotation_x(-self.lean_rad), translation: DVec3::ZERO }
    }

    /// A wheel in the leaning frame.
    pub fn leaning_from_wheel(&self, axle: DVec3) -> DPose3 {
        DPose3 { rotation: DQuat::from_rotation_y(self.roll_rad), translation: axle }
    }
}
