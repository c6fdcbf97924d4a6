//! What grows in props: cushions of leaves, and stems with leaves about them.

use super::Detail;
use super::draw::{direction, range, v};
use super::leaves::Leaves;
use super::materials::plant_slot as slot;
use cadet_base::geometry::{MeshBuilder, level_ring};
use cadet_base::math::{Vec3, cosf, powf, sinf};
use cadet_base::rng::Stream;

/// A cushion about the z axis: half extents, between two heights, its corners as square as `power` says.
pub(crate) struct Cushion {
    pub half: (f32, f32),
    pub low_m: f32,
    pub top_m: f32,
    pub power: f32,
}

impl Cushion {
    /// A point of its skin, and the way out of it: `a` about the axis, `t` from foot (0) to the middle of the top (1).
    fn skin(&self, a: f32, t: f32) -> (Vec3, Vec3) {
        let bent = |c: f32, p: f32| powf(c.abs(), 2.0 / p) * c.signum();
        let up = std::f32::consts::FRAC_PI_2 * t;
        let (x, y) = (bent(cosf(a), self.power), bent(sinf(a), self.power));
        let out = bent(cosf(up), 3.5);
        let z = self.low_m + (self.top_m - self.low_m) * bent(sinf(up), 3.0);
        (
            v(self.half.0 * x * out, self.half.1 * y * out, z),
            v(x * cosf(up), y * cosf(up), sinf(up)).normalize_or(Vec3::Z),
        )
    }

    pub(crate) fn grow(&self, s: &mut Stream, core: &mut MeshBuilder, leaves: &mut Leaves, detail: Detail) {
        let (sides, rows) = detail.pick((18, 6), (12, 4), (8, 3));
        let inset: f32 = detail.pick(0.05, 0.035, 0.0);
        let mut rings =
            vec![level_ring([self.half.0 - inset, self.half.1 - inset], self.low_m - 0.2, sides, self.power)];
        for k in 0..=rows {
            let t = 0.97 * k as f32 / rows as f32;
            let skin = (0..sides).map(|i| std::f32::consts::TAU * (i as f32 + 0.5) / sides as f32);
            rings.push(skin.map(|a| self.skin(a, t)).map(|(p, out)| p - out * inset).collect());
        }
        core.loft(&rings, if detail == Detail::Far { slot::LEAF } else { slot::DARK_LEAF }, true);
        let size: f32 = detail.pick(0.09, 0.18, 0.45);
        let coverage: f32 = detail.pick(0.9, 0.8, 0.15);
        let (hx, hy, h) = (self.half.0, self.half.1, self.top_m - self.low_m);
        let area = 4.0 * hx * hy + 3.4 * (hx + hy) * h;
        let of_top = 4.0 * hx * hy / area;
        for _ in 0..(coverage * area / (size * size)) as usize {
            let a = range(s, 0.0, std::f32::consts::TAU);
            let t = if s.chance(f64::from(of_top)) { range(s, 0.45, 1.0) } else { range(s, 0.02, 0.5) };
            let (p, out) = self.skin(a, t);
            let facing = (direction(s) + out * 0.7).normalize_or(out);
            let at = (p + out * range(s, -0.05, 0.01)).max(v(-hx + 0.04, -hy + 0.04, self.low_m));
            let at = at.min(v(hx - 0.04, hy - 0.04, self.top_m - 0.02));
            leaves.card(s, at, facing, out + Vec3::Z * 0.2, size);
        }
    }
}

/// Stems that rise from a pot and bend outwards, with leaves about them.
pub(crate) struct Stems {
    /// Radius of the pot, and height of the soil in it.
    pub pot_m: f32,
    pub foot_m: f32,
    /// Radius and height of the plant.
    pub spread_m: f32,
    pub top_m: f32,
}

impl Stems {
    pub(crate) fn grow(&self, s: &mut Stream, core: &mut MeshBuilder, leaves: &mut Leaves, detail: Detail) {
        let &Self { pot_m, foot_m, spread_m, top_m } = self;
        let num_stems = detail.pick(7, 5, 3);
        let stem_m: f32 = detail.pick(0.012, 0.014, 0.02);
        let bent: Vec<(Vec3, Vec3)> = (0..num_stems)
            .map(|k| {
                let a = std::f32::consts::TAU * (k as f32 + range(s, -0.3, 0.3)) / num_stems as f32;
                let (out, tip) = (v(cosf(a), sinf(a), 0.0), range(s, 0.75, 0.95) * top_m);
                (out * (0.5 * pot_m) + Vec3::Z * (foot_m - 0.03), out * (0.7 * spread_m) + Vec3::Z * tip)
            })
            .collect();
        for (foot, tip) in &bent {
            core.tube(&[(*foot, stem_m), (*tip, 0.7 * stem_m)], detail.pick(5, 4, 3), slot::BARK);
        }
        let (low, size) = (foot_m + 0.15, detail.pick(0.10, 0.16, 0.3));
        let coverage: f32 = detail.pick(0.9, 0.8, 0.5);
        let area = std::f32::consts::TAU * spread_m * (top_m - low);
        // A card reaches up to 0.95 of its size from its middle.
        let room = (spread_m - 0.95 * size).max(0.0);
        for _ in 0..(coverage * area / (size * size)) as usize {
            let (foot, tip) = bent[s.below(bent.len())];
            let around = direction(s) * (spread_m * range(s, 0.05, 0.5));
            let at = foot.lerp(tip, range(s, 0.15, 1.0)) + around;
            let highest = (top_m - 0.95 * size).max(low);
            let at = v(at.x.clamp(-room, room), at.y.clamp(-room, room), at.z.clamp(low, highest));
            let out = v(at.x, at.y, 0.3 * (at.z - low)).normalize_or(Vec3::Z);
            let facing = (direction(s) + out * 0.4).normalize_or(out);
            leaves.card(s, at, facing, out + Vec3::Z * 0.3, size);
        }
    }
}
