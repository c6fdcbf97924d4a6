//! Where hands hold what people have with them, over the gait.

use std::f32::consts::PI;

use cadet_base::math::{Vec3, cosf, sinf};

/// Share of the cycle for which the tip of a stick is on the ground.
const STANCE: f32 = 0.6;
/// How high the tip is lifted between.
const LIFT_M: f32 = 0.04;
/// How far the hand goes with the tip: the arm swings less than the stick.
const HAND_SHARE: f32 = 0.4;

/// A place that a hand holds, from the pelvis' vertical and the ground.
#[derive(Debug, Clone, Copy)]
pub(crate) enum Hold {
    /// A place that does not change over the gait.
    Still(Vec3),
    /// The grip of a stick.
    Pole(Pole),
}

/// A stick that is put on the ground once a cycle.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Pole {
    /// From the grip to the tip.
    pub length_m: f32,
    /// Where grip and tip are in the middle of the way that the tip is on the ground: forward, and to the left.
    pub grip_xy: [f32; 2],
    pub tip_xy: [f32; 2],
    /// Phase of the gait at which it is put down.
    pub strikes_at_phase: f32,
    /// Way of a cycle; 0 for somebody who stands.
    pub cycle_m: f32,
}

impl Hold {
    /// Where the hand is at a phase of the gait.
    pub fn at(&self, phase: f32) -> Vec3 {
        match self {
            Self::Still(hand) => *hand,
            Self::Pole(pole) => pole.grip(phase),
        }
    }

    /// Where the elbow of an arm on a side (+1 is the left) points: down and a little outward, or back over what it leans on.
    pub fn elbow_to(&self, side: f32) -> Vec3 {
        match self {
            Self::Still(_) => Vec3::new(-0.35, 0.45 * side, -1.0),
            Self::Pole(_) => Vec3::new(-1.0, 0.25 * side, -0.3),
        }
    }
}

impl Pole {
    /// How far forward of its middle the tip is at a phase, and how high.
    fn step(&self, phase: f32) -> (f32, f32) {
        if self.cycle_m <= 0.0 {
            return (0.0, 0.0);
        }
        let own = phase - self.strikes_at_phase;
        let own = own - own.floor();
        let reach = 0.5 * STANCE * self.cycle_m;
        if own < STANCE {
            (reach * (1.0 - 2.0 * own / STANCE), 0.0)
        } else {
            let t = (own - STANCE) / (1.0 - STANCE);
            (-reach * cosf(PI * t), LIFT_M * sinf(PI * t))
        }
    }

    /// Where the tip is at a phase of the gait: still on the ground while it is there.
    pub fn tip(&self, phase: f32) -> Vec3 {
        let (x, z) = self.step(phase);
        Vec3::new(self.tip_xy[0] + x, self.tip_xy[1], z)
    }

    /// Where the hand is.
    pub fn grip(&self, phase: f32) -> Vec3 {
        let tip = self.tip(phase);
        let x = self.grip_xy[0] + HAND_SHARE * self.step(phase).0;
        let aside = [x - tip.x, self.grip_xy[1] - tip.y];
        let up = (self.length_m * self.length_m - aside[0] * aside[0] - aside[1] * aside[1]).max(0.0).sqrt();
        Vec3::new(x, self.grip_xy[1], tip.z + up)
    }
}
