//! What people lean on: walking sticks, and forearm crutches.

use super::paint::slot;
use super::shapes::{pipe, pod};
use crate::person::arms::two_links;
use crate::person::hold::{Hold, Pole};
use crate::person::proportions::Proportions;
use crate::person::tube::Tubes;
use cadet_base::math::{Vec3, cosf, sinf};
use cadet_base::rng::Stream;

/// Half the thickness of a shaft at each level of detail, and of its foot.
const SHAFT_M: [f32; 3] = [0.010, 0.011, 0.013];
const FOOT_M: f32 = 0.016;
/// From the grip of a crutch up the forearm to the cuff round it.
const CUFF_M: f32 = 0.21;

/// One stick or crutch on each side that has one.
#[derive(Debug, Clone)]
pub(super) struct Sticks {
    /// Left and right.
    poles: [Option<Pole>; 2],
    has_cuff: bool,
    /// A knob instead of a handle that lies across.
    has_knob: bool,
    /// The left shoulder over the ground, and the lengths of upper arm and forearm to the grip.
    shoulder: Vec3,
    arm: [f32; 2],
}

impl Sticks {
    /// Sticks or crutches for the hands of these sides: +1 is the left.
    pub fn draw(p: &Proportions, sides: &[f32], has_cuff: bool, s: &mut Stream) -> Self {
        let k = p.stature_m / 1.75;
        let length_m = p.stature_m * s.range(0.450, 0.470) as f32;
        let has_knob = !has_cuff && s.chance(0.25);
        let pole = |side: f32| Pole {
            length_m,
            grip_xy: [0.09 * k, side * 0.27 * k],
            tip_xy: [0.12 * k, side * 0.33 * k],
            // With the foot of the other side: the left heel strikes at 0.
            strikes_at_phase: if side > 0.0 { 0.5 } else { 0.0 },
            cycle_m: if p.speed_mps > 0.0 { p.cycle_length_m } else { 0.0 },
        };
        let of = |side: f32| sides.contains(&side).then(|| pole(side));
        let (leg, trunk) = (p.thigh_m + p.shank_m + p.ankle_height_m, 0.94 * p.trunk_m);
        let shoulder = Vec3::new(sinf(p.lean_rad) * trunk, p.shoulder_half_m, leg + cosf(p.lean_rad) * trunk);
        let arm = [p.upper_arm_m, p.forearm_m + 0.5 * p.hand_m];
        Self { poles: [of(1.0), of(-1.0)], has_cuff, has_knob, shoulder, arm }
    }

    pub fn hands(&self) -> [Option<Hold>; 2] {
        self.poles.map(|pole| pole.map(Hold::Pole))
    }

    pub fn add(&self, tubes: &mut Tubes, phase: f32, level: usize) {
        for (pole, side) in self.poles.iter().zip([1.0_f32, -1.0]).filter_map(|(p, side)| Some((p.as_ref()?, side))) {
            let (grip, tip) = (pole.grip(phase), pole.tip(phase));
            let up = (grip - tip).normalize();
            // The shaft stands a little behind the palm that rests on the handle.
            let behind = grip - Vec3::X * 0.03;
            let shaft = if self.has_cuff { slot::METAL } else { slot::PLASTIC };
            let foot = tip + up * 0.035;
            pipe(tubes, &[tip + up * (0.45 * FOOT_M), foot], FOOT_M, slot::TIRE, level);
            pipe(tubes, &[foot, behind - Vec3::Z * 0.03, behind], SHAFT_M[level], shaft, level);
            if self.has_knob {
                pipe(tubes, &[grip - Vec3::X * 0.035, grip, grip + Vec3::X * 0.035], 0.021, slot::PLASTIC, level);
            } else {
                pipe(tubes, &[grip - Vec3::X * 0.045, grip, grip + Vec3::X * 0.075], 0.014, slot::PLASTIC, level);
            }
            if self.has_cuff {
                let shoulder = self.shoulder * Vec3::new(1.0, side, 1.0);
                let [upper, fore] = self.arm;
                let (_, along) = two_links(shoulder, grip, upper, fore, Hold::Pole(*pole).elbow_to(side));
                let middle = grip - along * CUFF_M;
                // The bar runs up below the forearm.
                let below = (Vec3::NEG_X - along * -along.x).normalize_or(Vec3::NEG_X);
                pipe(tubes, &[behind, middle + below * 0.045], SHAFT_M[level], shaft, level);
                let band = [(-0.022, 0.047, 2), (-0.012, 0.052, 1), (0.012, 0.050, 1), (0.022, 0.045, 2)];
                pod(tubes, along, &band.map(|(t, r, keeps)| (middle + along * t, [r; 2], keeps)), slot::TIRE, level);
            }
        }
    }
}
