//! What rolls beside or before its owner: wheeled cases, and rollators.

use super::paint::slot;
use super::shapes::{pipe, pod, wheel};
use crate::person::tube::Tubes;
use cadet_base::math::{Vec3, cosf, sinf};
use cadet_base::rng::Stream;

/// A case on two wheels that is pulled behind.
#[derive(Debug, Clone)]
pub(super) struct Case {
    pub hand: Vec3,
    /// Up the back of the case, from the wheels.
    axis: Vec3,
    /// From the wheels to the handle.
    length_m: f32,
    /// Half the case's width and depth, and its height.
    half: [f32; 2],
    height_m: f32,
}

impl Case {
    pub fn draw(stature_m: f32, side: f32, s: &mut Stream) -> Self {
        let hand = Vec3::new(-0.17, side * 0.27, 0.755) * (stature_m / 1.75);
        let tilt = s.range(0.50, 0.80) as f32;
        let axis = Vec3::new(sinf(tilt), 0.0, cosf(tilt));
        let height_m = s.range(0.45, 0.62) as f32;
        let half = [s.range(0.16, 0.22) as f32, s.range(0.10, 0.14) as f32];
        Self { hand, axis, length_m: (hand.z - 0.05) / axis.z, half, height_m }
    }

    pub fn add(&self, tubes: &mut Tubes, level: usize) {
        let foot = self.hand - self.axis * self.length_m;
        // Away from the handle's bars: below and behind them.
        let out = Vec3::new(-self.axis.z, 0.0, self.axis.x);
        let [w, d] = self.half;
        let on = |along: f32, aside: f32| foot + self.axis * along + Vec3::Y * aside + out * 0.02;
        let body = [
            (0.02, 0.85, 2),
            (0.05, 1.0, 1),
            (0.10, 1.06, 2),
            (self.height_m - 0.06, 1.06, 2),
            (self.height_m, 0.85, 2),
        ];
        let middle = |t: f32| on(t, 0.0) + out * d;
        pod(tubes, self.axis, &body.map(|(t, k, keeps)| (middle(t), [d * k, w * k], keeps)), slot::CLOTH, level);
        for side in [1.0, -1.0] {
            let y = 0.6 * w * side;
            pipe(tubes, &[on(self.height_m - 0.05, y), on(self.length_m, y)], 0.007, slot::METAL, level);
            let hub = Vec3::new(foot.x, foot.y + 0.85 * w * side, 0.05);
            wheel(tubes, hub, 0.05, 0.03, [slot::TIRE, slot::PLASTIC], level);
        }
        pipe(tubes, &[on(self.length_m, 0.62 * w), on(self.length_m, -0.62 * w)], 0.013, slot::PLASTIC, level);
    }
}

/// A rollator: two frames with four wheels, grips, and a basket between them.
#[derive(Debug, Clone)]
pub(super) struct Rollator {
    grip: Vec3,
    has_basket: bool,
}

impl Rollator {
    pub fn draw(stature_m: f32, s: &mut Stream) -> Self {
        Self { grip: Vec3::new(0.17 * stature_m, 0.26, 0.52 * stature_m), has_basket: s.chance(0.8) }
    }

    pub fn hands(&self) -> [Vec3; 2] {
        [self.grip, Vec3::new(self.grip.x, -self.grip.y, self.grip.z)]
    }

    pub fn add(&self, tubes: &mut Tubes, level: usize) {
        let g = self.grip;
        let wheels = [slot::TIRE, slot::PLASTIC];
        for side in [1.0, -1.0] {
            let at = |x: f32, z: f32| Vec3::new(g.x + x, side * g.y, z);
            pipe(tubes, &[at(-0.07, g.z), at(0.06, g.z)], 0.017, slot::PLASTIC, level);
            pipe(tubes, &[at(0.04, g.z), at(0.10, 0.55 * g.z), at(0.46, 0.12)], 0.013, slot::METAL, level);
            pipe(tubes, &[at(0.10, 0.55 * g.z), at(-0.06, 0.11)], 0.012, slot::METAL, level);
            pipe(tubes, &[at(0.02, 0.33 * g.z), at(0.28, 0.33 * g.z)], 0.009, slot::METAL, level);
            wheel(tubes, at(-0.06, 0.095), 0.095, 0.03, wheels, level);
            wheel(tubes, at(0.46, 0.10), 0.10, 0.03, wheels, level);
        }
        let across = |x: f32, z: f32| [Vec3::new(g.x + x, g.y, z), Vec3::new(g.x + x, -g.y, z)];
        pipe(tubes, &across(0.10, 0.55 * g.z), 0.010, slot::METAL, level);
        pipe(tubes, &across(0.28, 0.33 * g.z), 0.009, slot::METAL, level);
        let seat = [(0.06, 0.8, 2), (0.08, 1.0, 1), (0.26, 1.0, 1), (0.28, 0.8, 2)];
        let seat = seat.map(|(x, k, keeps)| (Vec3::new(g.x + x, 0.0, 0.60 * g.z), [0.018, 0.9 * g.y * k], keeps));
        pod(tubes, Vec3::X, &seat, slot::PLASTIC, level);
        if self.has_basket {
            let basket = [(0.22, 0.09, 2), (0.25, 0.11, 1), (0.42, 0.11, 1), (0.45, 0.09, 2)];
            let basket = basket.map(|(x, h, keeps)| (Vec3::new(g.x + x, 0.0, 0.40 * g.z), [h, 0.75 * g.y], keeps));
            pod(tubes, Vec3::X, &basket, slot::CLOTH, level);
        }
    }
}
