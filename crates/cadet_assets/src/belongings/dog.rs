//! Dogs on a lead: trunk, head, tail, and four legs that trot as fast as their owner walks.

use super::paint::slot;
use super::shapes::{ball, pipe, pod};
use crate::person::arms::two_links;
use crate::person::tube::Tubes;
use cadet_base::math::{Vec3, cosf, sinf};
use cadet_base::rng::Stream;
use std::f32::consts::TAU;

/// Share of a stride for which a paw is on the ground.
const STANCE: f32 = 0.55;
/// Way of a stride for a dog of a height at the withers.
const STRIDE_OF_HEIGHT: f32 = 1.5;
/// How far the lead sags.
const SAG_M: f32 = 0.10;

/// A dog beside somebody.
#[derive(Debug, Clone)]
pub(super) struct Dog {
    pub hand: Vec3,
    /// On the ground below its middle.
    at: Vec3,
    /// Height of the withers.
    height_m: f32,
    length_m: f32,
    /// Thickness of trunk and legs against a lean dog's.
    girth_factor: f32,
    pricked: bool,
    tail_up_share: f32,
    /// Strides to a cycle of the owner's gait, and the way of one; 0 if the owner stands.
    strides: u32,
    stride_m: f32,
}

impl Dog {
    pub fn draw(stature_m: f32, side: f32, owner_cycle_m: f32, s: &mut Stream) -> Self {
        let k = stature_m / 1.75;
        let height_m = s.range(0.30, 0.60) as f32;
        let length_m = height_m * s.range(0.95, 1.2) as f32;
        let strides =
            if owner_cycle_m > 0.0 { (owner_cycle_m / (STRIDE_OF_HEIGHT * height_m)).round().max(1.0) } else { 0.0 };
        Self {
            hand: Vec3::new(0.14, side * 0.27, 0.80) * k,
            at: Vec3::new(s.range(0.45, 0.85) as f32, side * s.range(0.30, 0.44) as f32, 0.0),
            height_m,
            length_m,
            girth_factor: s.range(0.9, 1.2) as f32,
            pricked: s.chance(0.45),
            tail_up_share: s.range(-0.3, 1.0) as f32,
            strides: strides as u32,
            stride_m: if strides > 0.0 { owner_cycle_m / strides } else { 0.0 },
        }
    }

    /// Adds the dog at a phase of its owner's gait.
    pub fn add(&self, tubes: &mut Tubes, owner_phase: f32, level: usize) {
        let (h, l, g) = (self.height_m, self.length_m, self.girth_factor);
        let phase = owner_phase * self.strides as f32;
        let bob = if self.strides > 0 { 0.012 * h * sinf(2.0 * TAU * phase) } else { 0.0 };
        let at = |x: f32, y: f32, z: f32| self.at + Vec3::new(x, y, z + bob);
        let trunk = [
            (-0.53, 0.86, 0.05, 2),
            (-0.48, 0.84, 0.11, 1),
            (-0.34, 0.79, 0.17, 2),
            (-0.08, 0.78, 0.17, 0),
            (0.20, 0.75, 0.205, 2),
            (0.38, 0.77, 0.195, 1),
            (0.50, 0.83, 0.12, 2),
        ];
        let trunk = trunk.map(|(x, z, r, keeps)| (at(x * l, 0.0, z * h), [r * h * g, 0.80 * r * h * g], keeps));
        pod(tubes, Vec3::X, &trunk, slot::COAT, level);
        // Neck, head, muzzle.
        let (chest, nape) = (at(0.36 * l, 0.0, 0.86 * h), at(0.36 * l + 0.25 * h, 0.0, 1.17 * h));
        let neck = [(0.0, 0.15, 2), (0.5, 0.125, 1), (1.0, 0.11, 2)]
            .map(|(t, r, keeps)| (chest.lerp(nape, t), [r * h * g, 0.85 * r * h * g], keeps));
        pod(tubes, (nape - chest).normalize(), &neck, slot::COAT, level);
        let head = [(-0.10, 0.05, 0.06, 1), (-0.04, 0.045, 0.105, 2), (0.06, 0.03, 0.115, 0), (0.14, 0.0, 0.09, 2)];
        let skull = nape + Vec3::Z * (0.02 * h);
        let head = head.map(|(x, z, r, keeps)| (skull + Vec3::new(x * h, 0.0, z * h), [r * h, 0.92 * r * h], keeps));
        pod(tubes, Vec3::X, &head, slot::COAT, level);
        let muzzle = [(0.12, -0.015, 0.070, 2), (0.22, -0.03, 0.058, 1), (0.30, -0.035, 0.046, 2)];
        let muzzle = muzzle.map(|(x, z, r, keeps)| (skull + Vec3::new(x * h, 0.0, z * h), [r * h, 0.9 * r * h], keeps));
        pod(tubes, Vec3::X, &muzzle, slot::MUZZLE, level);
        if level < 2 {
            ball(tubes, skull + Vec3::new(0.325, 0.0, -0.015) * h, Vec3::splat(0.024 * h), slot::NOSE, 1);
        }
        for side in [1.0_f32, -1.0] {
            let root = skull + Vec3::new(-0.01, 0.07 * side, 0.10) * h;
            let tip =
                if self.pricked { Vec3::new(-0.03, 0.03 * side, 0.17) } else { Vec3::new(0.02, 0.075 * side, -0.13) };
            let ear = [(0.0, [0.045, 0.022], 2), (0.5, [0.048, 0.018], 1), (1.0, [0.016, 0.010], 2)];
            let ear = ear.map(|(t, [x, y], keeps)| (root + tip * (t * h), [x * h, y * h], keeps));
            pod(tubes, tip.normalize(), &ear, slot::MUZZLE, level);
        }
        // The tail wags once a stride.
        let wag = if self.strides > 0 { 0.10 * sinf(TAU * phase) } else { 0.0 };
        let up = self.tail_up_share;
        let tail = [
            at(-0.50 * l, 0.0, 0.88 * h),
            at(-0.50 * l - 0.20 * h, 0.5 * wag * h, (0.88 + 0.12 * up) * h),
            at(-0.50 * l - 0.36 * h, wag * h, (0.88 + 0.36 * up) * h),
        ];
        pipe(tubes, &tail, 0.032 * h, slot::COAT, level);
        for (k, (front, side)) in [(true, 1.0_f32), (true, -1.0), (false, 1.0), (false, -1.0)].into_iter().enumerate() {
            // Diagonal pairs, as in a trot.
            let own = phase + if k == 0 || k == 3 { 0.0 } else { 0.5 };
            self.add_leg(tubes, front, side, own, bob, level);
        }
        // The collar, and the lead up to the hand.
        let collar = chest.lerp(nape, 0.55);
        let band = [(-0.02, 0.136), (0.02, 0.134)]
            .map(|(t, r)| (collar + (nape - chest).normalize() * (t * h), [r * h * g, 0.86 * r * h * g], 2));
        pod(tubes, (nape - chest).normalize(), &band, slot::CLOTH, level);
        if level < 2 {
            let lead: Vec<Vec3> = (0..=4)
                .map(|k| k as f32 / 4.0)
                .map(|t| collar.lerp(self.hand, t) - Vec3::Z * (4.0 * SAG_M * t * (1.0 - t)))
                .collect();
            pipe(tubes, &lead, [0.006, 0.008][level], slot::CLOTH, level);
        }
    }

    fn add_leg(&self, tubes: &mut Tubes, is_front: bool, side: f32, phase: f32, bob: f32, level: usize) {
        let (h, l, g) = (self.height_m, self.length_m, self.girth_factor);
        let phase = phase - phase.floor();
        let reach = 0.5 * STANCE * self.stride_m;
        let (swing, lift) = if phase < STANCE {
            (1.0 - 2.0 * phase / STANCE, 0.0)
        } else {
            let t = (phase - STANCE) / (1.0 - STANCE);
            (-cosf(std::f32::consts::PI * t), sinf(std::f32::consts::PI * t))
        };
        let (x, hip_z) = if is_front { (0.36 * l, 0.72 * h) } else { (-0.40 * l, 0.76 * h) };
        let hip = self.at + Vec3::new(x, side * 0.10 * h * g, hip_z + bob);
        let back = if is_front { 0.0 } else { -0.06 * h };
        let lift_m = if self.strides > 0 { 0.13 * h * lift } else { 0.0 };
        let foot = self.at + Vec3::new(x + back + reach * swing, side * 0.105 * h * g, 0.055 * h + lift_m);
        let (a, b) = if is_front { (0.37 * h, 0.345 * h) } else { (0.40 * h, 0.37 * h) };
        let (upper, _) = two_links(hip, foot, a, b, Vec3::new(if is_front { -1.0 } else { 1.0 }, 0.0, 0.0));
        let joint = hip + upper * a;
        let thick = if is_front { [0.115, 0.070, 0.050] } else { [0.155, 0.080, 0.050] };
        let down = (foot - hip).normalize();
        let thigh = [
            (hip + Vec3::Z * (0.03 * h), thick[0], 1),
            (hip.lerp(joint, 0.5), 0.85 * thick[0], 2),
            (joint, thick[1], 2),
        ];
        pod(tubes, down, &thigh.map(|(p, r, keeps)| (p, [r * h * g, 0.62 * r * h * g], keeps)), slot::COAT, level);
        let hock = if is_front { joint.lerp(foot, 0.5) } else { joint.lerp(foot, 0.5) - Vec3::X * (0.05 * h) };
        pipe(tubes, &[joint + Vec3::Z * (0.02 * h), hock, foot], thick[2] * h * g, slot::COAT, level);
        let paw = [(-0.045, 0.030, 2), (0.0, 0.050, 1), (0.06, 0.046, 2), (0.085, 0.025, 1)];
        let ground = Vec3::new(foot.x, foot.y, lift_m);
        let paw = paw.map(|(x, r, keeps)| {
            let r = r * h;
            (ground + Vec3::new(x * h, 0.0, 0.8 * r), [0.8 * r, r * g], keeps)
        });
        pod(tubes, Vec3::X, &paw, slot::MUZZLE, level);
    }
}
