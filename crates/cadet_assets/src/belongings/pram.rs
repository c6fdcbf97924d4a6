//! Prams: a chassis on four wheels with a bar to push it, and on it a carrycot, or a seat with a child.

use super::paint::slot;
use super::shapes::{SIDES, ball, pipe, pod, wheel};
use crate::person::tube::{Ring, Tubes};
use cadet_base::math::{Vec3, cosf, sinf};
use cadet_base::rng::Stream;

/// Half the distance of the hands on the bar, meters.
const GRIP_HALF_M: f32 = 0.19;
/// Radius of a hood.
const HOOD_M: f32 = 0.21;

/// A pram before somebody.
#[derive(Debug, Clone)]
pub(super) struct Pram {
    /// The middle of the bar.
    bar: Vec3,
    half_width_m: f32,
    is_carrycot: bool,
    /// Radii of the rear and the front wheels.
    wheels: [f32; 2],
    has_basket: bool,
    /// The hood's reach over the child, 0 to 1.
    hood_share: f32,
}

impl Pram {
    pub fn draw(stature_m: f32, s: &mut Stream) -> Self {
        let is_carrycot = s.chance(0.4);
        let rear = s.range(0.12, 0.16) as f32;
        Self {
            bar: Vec3::new(0.25 * stature_m, 0.0, (0.585 * stature_m).clamp(0.92, 1.10)),
            half_width_m: s.range(0.25, 0.29) as f32,
            is_carrycot,
            wheels: [rear, if s.chance(0.5) { rear } else { 0.75 * rear }],
            has_basket: s.chance(0.8),
            hood_share: s.range(0.2, 1.0) as f32,
        }
    }

    pub fn hands(&self) -> [Vec3; 2] {
        [1.0, -1.0].map(|side| self.bar + Vec3::Y * (side * GRIP_HALF_M))
    }

    pub fn add(&self, tubes: &mut Tubes, level: usize) {
        let at = |x: f32, y: f32, z: f32| Vec3::new(self.bar.x + x, y, z);
        let (w, [rear, front]) = (self.half_width_m, self.wheels);
        let (rear_hub, front_hub) = (at(0.20, 0.0, rear), at(0.80, 0.0, front));
        for side in [1.0, -1.0] {
            let aside = |p: Vec3, y: f32| p + Vec3::Y * (side * y);
            wheel(tubes, aside(rear_hub, w), rear, 0.045, [slot::TIRE, slot::METAL], level);
            wheel(tubes, aside(front_hub, 0.85 * w), front, 0.04, [slot::TIRE, slot::METAL], level);
            // From the bar down to the front wheels, and from the joint to the rear ones.
            let joint = at(0.34, side * 0.92 * w, 0.60 * self.bar.z);
            let handle = [aside(self.bar, 0.92 * w), joint, aside(front_hub, 0.80 * w) + Vec3::Z * 0.02];
            pipe(tubes, &handle, 0.013, slot::METAL, level);
            pipe(tubes, &[joint, aside(rear_hub, 0.93 * w)], 0.012, slot::METAL, level);
        }
        let ends = [0.95 * w, -0.95 * w].map(|y| self.bar + Vec3::Y * y);
        pipe(tubes, &ends, 0.017, slot::PLASTIC, level);
        for hub in [rear_hub, front_hub] {
            pipe(tubes, &[hub + Vec3::Y * (0.9 * w), hub - Vec3::Y * (0.9 * w)], 0.010, slot::METAL, level);
        }
        if self.has_basket {
            let z = rear.max(front) + 0.10;
            let places = [(0.22, 0.05, 2), (0.26, 0.10, 1), (0.66, 0.10, 1), (0.72, 0.06, 2)];
            let basket = places.map(|(x, h, keeps)| (at(x, 0.0, z + 0.02), [h, 0.72 * w], keeps));
            pod(tubes, Vec3::X, &basket, slot::CLOTH_INSIDE, level);
        }
        if self.is_carrycot { self.add_carrycot(tubes, level) } else { self.add_seat(tubes, level) }
    }

    /// A cot along the pram, with a hood over the far end that is open toward who pushes.
    fn add_carrycot(&self, tubes: &mut Tubes, level: usize) {
        let z = 0.68 * self.bar.z;
        let at = |x: f32, z: f32| Vec3::new(self.bar.x + x, 0.0, z);
        let w = 0.78 * self.half_width_m;
        let cot = [
            (0.12, 0.06, 0.7, 2),
            (0.15, 0.10, 0.92, 1),
            (0.25, 0.125, 1.0, 2),
            (0.78, 0.125, 1.0, 2),
            (0.89, 0.10, 0.9, 1),
            (0.92, 0.06, 0.65, 2),
        ];
        pod(tubes, Vec3::X, &cot.map(|(x, h, k, keeps)| (at(x, z), [h, k * w], keeps)), slot::CLOTH, level);
        // The cover over the child's legs, the pillow, and the head.
        let cover = [(0.16, 0.03, 0.8, 2), (0.20, 0.06, 0.9, 1), (0.50, 0.07, 0.9, 2), (0.56, 0.03, 0.8, 2)];
        pod(tubes, Vec3::X, &cover.map(|(x, h, k, keeps)| (at(x, z + 0.11), [h, k * w], keeps)), slot::CLOTHES, level);
        ball(tubes, at(0.66, z + 0.15), Vec3::new(0.07, 0.06, 0.06), slot::SKIN, level);
        self.add_hood(tubes, at(0.70, z + 0.09), -1.0, level);
    }

    /// A reclined seat with a child who looks ahead.
    fn add_seat(&self, tubes: &mut Tubes, level: usize) {
        let at = |x: f32, y: f32, z: f32| Vec3::new(self.bar.x + x, y, z);
        let w = 0.70 * self.half_width_m;
        let z = 0.46 * self.bar.z;
        let back = Vec3::new(-0.34, 0.0, 0.94);
        let seat = at(0.46, 0.0, z);
        let shell = [(0.0, 0.03, 1.0, 2), (0.05, 0.04, 1.0, 1), (0.42, 0.035, 1.0, 1), (0.52, 0.02, 0.8, 2)];
        pod(tubes, back, &shell.map(|(t, h, k, keeps)| (seat + back * t, [h, k * w], keeps)), slot::CLOTH, level);
        let cushion = [(0.0, 0.035, 0.9, 2), (0.05, 0.045, 1.0, 1), (0.26, 0.04, 0.95, 2), (0.30, 0.02, 0.8, 2)];
        let cushion = cushion.map(|(x, h, k, keeps)| (seat + Vec3::X * x, [h, k * w], keeps));
        pod(tubes, Vec3::X, &cushion, slot::CLOTH, level);
        // Trunk and head lean on the back; thighs on the seat, feet on the rest.
        let trunk = [(0.05, 0.07, 0.09, 2), (0.16, 0.075, 0.10, 1), (0.26, 0.07, 0.105, 2), (0.31, 0.04, 0.05, 1)];
        let on_back = |t: f32| seat + back * t + Vec3::X * 0.10;
        pod(tubes, back, &trunk.map(|(t, x, y, keeps)| (on_back(t), [x, y], keeps)), slot::CLOTHES, level);
        ball(tubes, on_back(0.40) + Vec3::X * 0.02, Vec3::new(0.078, 0.066, 0.085), slot::SKIN, level);
        ball(tubes, on_back(0.43), Vec3::new(0.076, 0.070, 0.070), slot::CLOTHES, level);
        for side in [1.0, -1.0] {
            let hip = seat + Vec3::new(0.12, 0.055 * side, 0.08);
            let knee = seat + Vec3::new(0.32, 0.07 * side, 0.07);
            pipe(tubes, &[hip, knee, knee + Vec3::new(0.06, 0.0, -0.18)], 0.042, slot::TROUSERS, level);
            ball(tubes, knee + Vec3::new(0.09, 0.0, -0.20), Vec3::new(0.055, 0.032, 0.03), slot::PLASTIC, level);
            let shoulder = on_back(0.27) + Vec3::Y * (0.09 * side);
            pipe(tubes, &[shoulder, shoulder + Vec3::new(0.10, 0.03 * side, -0.13)], 0.028, slot::CLOTHES, level);
        }
        let rest = seat + Vec3::new(0.40, 0.0, -0.16);
        pipe(tubes, &[rest + Vec3::Y * (0.8 * w), rest - Vec3::Y * (0.8 * w)], 0.02, slot::PLASTIC, level);
        for side in [1.0, -1.0] {
            let y = Vec3::Y * (side * 0.9 * w);
            pipe(tubes, &[seat + y, rest + y], 0.010, slot::METAL, level);
        }
        self.add_hood(tubes, on_back(0.36) - Vec3::X * 0.02, 1.0, level);
    }

    /// A folded or unfolded hood round the middle of a head: a band bent over it between two flanks; `toward` +1 opens forward.
    fn add_hood(&self, tubes: &mut Tubes, root: Vec3, toward: f32, level: usize) {
        let w = 0.74 * self.half_width_m;
        let last = 1.0 + 0.9 * self.hood_share;
        let steps = [7, 4, 2][level];
        let axes = |k: usize| {
            let turn = -0.45 + (last + 0.45) * k as f32 / steps as f32;
            let (x, z) = (cosf(turn), sinf(turn));
            [Vec3::new(toward * z, 0.0, x), Vec3::new(-toward * x, 0.0, z)]
        };
        let band = |center: Vec3, half: [f32; 2]| -> Vec<Ring> {
            let ring = |[along, forward]: [Vec3; 2]| {
                Ring::new(center + forward * (HOOD_M - half[0]), [along, forward], half, slot::CLOTH, 2)
            };
            (0..=steps).map(axes).map(ring).collect()
        };
        tubes.tube(&band(root, [0.012, w]), SIDES[level][1], level, -1.0);
        for side in [1.0, -1.0] {
            let flank = band(root + Vec3::Y * (side * 0.94 * w), [0.5 * HOOD_M, 0.009]);
            tubes.tube(&flank, SIDES[level][1], level, -1.0);
        }
    }
}
