//! An open umbrella: eight panels between ribs, a shaft, and a handle in the fist.

use super::paint::slot;
use super::shapes::pipe;
use crate::person::tube::{Ring, Tubes};
use cadet_base::math::{Vec3, cosf, sinf};
use cadet_base::rng::Stream;

/// The rim's height over the head, and the canopy's thickness, meters.
const OVER_HEAD_M: f32 = 0.03;
const THICK_M: f32 = 0.006;
const RIBS: usize = 8;

/// An umbrella over somebody.
#[derive(Debug, Clone)]
pub(super) struct Umbrella {
    pub hand: Vec3,
    /// Up the shaft.
    axis: Vec3,
    /// From the hand to the tip.
    length_m: f32,
    radius_m: f32,
    /// Height of the dome over its rim.
    dome_m: f32,
}

impl Umbrella {
    /// In the hand of a side, over a person of a height.
    pub fn draw(stature_m: f32, side: f32, s: &mut Stream) -> Self {
        let k = stature_m / 1.75;
        let hand = Vec3::new(0.24, side * 0.19, 1.16) * k;
        let (radius_m, dome_m) = (s.range(0.46, 0.56) as f32, s.range(0.20, 0.26) as f32);
        // Over the head, or a little forward against the rain.
        let over =
            Vec3::new(s.range(0.0, 0.16) as f32, side * s.range(0.02, 0.10) as f32, stature_m + OVER_HEAD_M + dome_m);
        let shaft = over - hand;
        Self { hand, axis: shaft.normalize(), length_m: shaft.length(), radius_m, dome_m }
    }

    pub fn add(&self, tubes: &mut Tubes, level: usize) {
        let at = |along: f32| self.hand + self.axis * along;
        let forward = Vec3::X - self.axis * self.axis.x;
        // The dome bends more toward the rim; from below up to the tip inside, out round the rim, and up again outside.
        let places = [(0.03, 1.0), (0.35, 0.94), (0.70, 0.72), (0.92, 0.34), (0.985, 0.10), (1.0, 0.0)];
        let radius = |share: f32| (self.radius_m * share, self.dome_m * places_height(&places, share));
        let shares: &[f32] =
            [&[0.03, 0.30, 0.55, 0.78, 0.94, 0.995][..], &[0.03, 0.4, 0.78, 0.99], &[0.03, 0.6, 0.99]][level];
        let rim = self.length_m - self.dome_m;
        let ring = |share: f32, thick: f32, slot: u8| {
            let (r, z) = radius(share);
            Ring::new(at(rim + z + thick), [self.axis, forward], [r; 2], slot, 2)
        };
        let inside = shares.iter().map(|share| ring(*share, 0.0, slot::CLOTH_INSIDE));
        let edge = [ring(1.0, 0.0, slot::CLOTH), ring(1.0, THICK_M, slot::CLOTH)];
        let outside = shares.iter().rev().map(|share| ring(*share, THICK_M, slot::CLOTH));
        let rings: Vec<Ring> = inside.chain(edge).chain(outside).collect();
        tubes.tube(&rings, RIBS, level, -1.0);
        let thin = [0.006, 0.007, 0.010][level];
        pipe(tubes, &[at(-0.02), at(self.length_m + 0.05)], thin, slot::METAL, level);
        if level < 2 {
            pipe(tubes, &[at(-0.11), at(0.07)], 0.014, slot::PLASTIC, level);
        }
        if level == 0 {
            // Ribs under the panels, and the struts that hold them open.
            let left = self.axis.cross(forward.normalize());
            for k in 0..RIBS {
                let angle = k as f32 / RIBS as f32 * std::f32::consts::TAU;
                let out = forward.normalize() * cosf(angle) + left * sinf(angle);
                let on = |share: f32| {
                    let (r, z) = radius(share);
                    at(rim + z - 0.006) + out * r
                };
                pipe(tubes, &[on(0.05), on(0.4), on(0.75), on(0.99)], 0.003, slot::METAL, level);
                pipe(tubes, &[at(rim + 0.35 * self.dome_m), on(0.5)], 0.003, slot::METAL, level);
            }
        }
    }
}

/// Height of the dome at a share of its radius, by the table.
fn places_height(places: &[(f32, f32); 6], share: f32) -> f32 {
    let k = places.iter().skip(1).position(|(at, _)| share <= *at).unwrap_or(places.len() - 2);
    let ((a, za), (b, zb)) = (places[k], places[k + 1]);
    za + (zb - za) * ((share - a) / (b - a)).clamp(0.0, 1.0)
}
