//! Clipped bushes, beds of shrubs, planted tubs: a core with leaf cards all over it; and tall plants in pots.

use super::shapes::{ring, sizes, v, within};
use crate::assets::scenery::draw::{direction, range, tube};
use crate::assets::scenery::leaves::Leaves;
use crate::assets::scenery::materials::plant_slot as slot;
use crate::assets::scenery::{Detail, Mesh};
use crate::geometry::MeshBuilder;
use crate::math::{Vec3, cosf, powf, sinf};
use crate::rng::Stream;

/// A cushion about the z axis: half extents, between two heights, its corners as square as `power` says.
struct Cushion {
    half: (f32, f32),
    low: f32,
    top: f32,
    power: f32,
}

impl Cushion {
    /// A point of its skin, and the way out of it: `a` about the axis, `t` from foot (0) to the middle of the top (1).
    fn skin(&self, a: f32, t: f32) -> (Vec3, Vec3) {
        let bent = |c: f32, p: f32| powf(c.abs(), 2.0 / p) * c.signum();
        let up = std::f32::consts::FRAC_PI_2 * t;
        let (x, y) = (bent(cosf(a), self.power), bent(sinf(a), self.power));
        let out = bent(cosf(up), 3.5);
        let at =
            v(self.half.0 * x * out, self.half.1 * y * out, self.low + (self.top - self.low) * bent(sinf(up), 3.0));
        (at, v(x * cosf(up), y * cosf(up), sinf(up)).normalize_or(Vec3::Z))
    }

    fn grow(&self, s: &mut Stream, core: &mut MeshBuilder, leaves: &mut Leaves, detail: Detail) {
        let (sides, rows) = detail.pick((18, 6), (12, 4), (8, 3));
        let inset: f32 = detail.pick(0.05, 0.035, 0.0);
        let mut rings = vec![ring((self.half.0 - inset, self.half.1 - inset), self.low - 0.2, sides, self.power)];
        for k in 0..=rows {
            let t = 0.97 * k as f32 / rows as f32;
            let skin = (0..sides).map(|i| std::f32::consts::TAU * (i as f32 + 0.5) / sides as f32);
            rings.push(skin.map(|a| self.skin(a, t)).map(|(p, out)| p - out * inset).collect());
        }
        core.loft(&rings, if detail == Detail::Far { slot::LEAF } else { slot::DARK_LEAF }, true);
        let size: f32 = detail.pick(0.09, 0.18, 0.45);
        let coverage: f32 = detail.pick(0.9, 0.8, 0.15);
        let (hx, hy, h) = (self.half.0, self.half.1, self.top - self.low);
        let area = 4.0 * hx * hy + 3.4 * (hx + hy) * h;
        let of_top = 4.0 * hx * hy / area;
        for _ in 0..(coverage * area / (size * size)) as usize {
            let a = range(s, 0.0, std::f32::consts::TAU);
            let t = if s.chance(f64::from(of_top)) { range(s, 0.45, 1.0) } else { range(s, 0.02, 0.5) };
            let (p, out) = self.skin(a, t);
            let facing = (direction(s) + out * 0.7).normalize_or(out);
            let at = (p + out * range(s, -0.05, 0.01)).max(v(-hx + 0.04, -hy + 0.04, self.low));
            let at = at.min(v(hx - 0.04, hy - 0.04, self.top - 0.02));
            leaves.card(s, at, facing, out + Vec3::Z * 0.2, size);
        }
    }
}

/// A block or a ball, alone in a lawn or before a house.
pub(super) fn clipped_bush(variant: usize, detail: Detail) -> Mesh {
    let s = &mut sizes("clipped bush", variant);
    let is_ball = variant.is_multiple_of(3);
    let (x, y, h) = if is_ball {
        let r = within(s, (0.5, 0.95));
        (r, r, within(s, (0.9, 1.6)))
    } else {
        (within(s, (0.6, 1.0)), within(s, (1.1, 2.3)), within(s, (0.9, 1.6)))
    };
    let mut core = MeshBuilder::new();
    let mut leaves = Leaves::default();
    let power = if is_ball { 2.0 } else { 5.0 };
    Cushion { half: (x, y), low: 0.0, top: h, power }.grow(s, &mut core, &mut leaves, detail);
    leaves.build("clipped bush", &core)
}

/// Low and wide.
pub(super) fn shrub_bed(variant: usize, detail: Detail) -> Mesh {
    let s = &mut sizes("shrub bed", variant);
    let (x, y, h) = (within(s, (0.8, 1.5)), within(s, (1.7, 3.6)), within(s, (0.45, 1.0)));
    let mut core = MeshBuilder::new();
    let mut leaves = Leaves::default();
    Cushion { half: (x, y), low: 0.0, top: h, power: 3.0 }.grow(s, &mut core, &mut leaves, detail);
    leaves.build("shrub bed", &core)
}

/// A round or long tub; its wood is the plant's.
pub(super) fn tub(variant: usize, detail: Detail) -> Mesh {
    let s = &mut sizes("tub", variant);
    let is_round = variant.is_multiple_of(2);
    let (x, y) = if is_round {
        let r = within(s, (0.28, 0.5));
        (r, r)
    } else {
        (within(s, (0.25, 0.4)), within(s, (0.5, 0.95)))
    };
    let (h, grown) = (within(s, (0.4, 0.7)), within(s, (0.3, 0.8)));
    let (sides, power) = if is_round { (detail.pick(16, 9, 6), 2.0) } else { (detail.pick(12, 8, 8), 9.0) };
    let mut core = MeshBuilder::new();
    let wall = [ring((x * 0.85, y * 0.9), 0.0, sides, power), ring((x, y), h, sides, power)];
    core.loft(&wall, slot::BARK, true);
    let mut leaves = Leaves::default();
    Cushion { half: (x * 0.9, y * 0.9), low: h - 0.02, top: h + grown, power: 2.2 }.grow(
        s,
        &mut core,
        &mut leaves,
        detail,
    );
    leaves.build("tub", &core)
}

/// A pot with bamboo, oleander, or the like: stems, and leaves about them that are thin enough to look through.
pub(super) fn tall_plant(variant: usize, detail: Detail) -> Mesh {
    let s = &mut sizes("tall plant", variant);
    let (pot, high) = (within(s, (0.2, 0.34)), within(s, (0.32, 0.5)));
    let (spread, top) = (within(s, (0.3, 0.6)), within(s, (1.25, 2.2)));
    let mut core = MeshBuilder::new();
    let sides = detail.pick(14, 9, 6);
    let wall = [ring((pot * 0.75, pot * 0.75), 0.0, sides, 2.0), ring((pot, pot), high, sides, 2.0)];
    core.loft(&wall, slot::BARK, true);
    let stems = detail.pick(7, 5, 3);
    let stem_m: f32 = detail.pick(0.012, 0.014, 0.02);
    let bent: Vec<(Vec3, Vec3)> = (0..stems)
        .map(|k| {
            let a = std::f32::consts::TAU * (k as f32 + within(s, (-0.3, 0.3))) / stems as f32;
            let (out, tip) = (v(cosf(a), sinf(a), 0.0), within(s, (0.75, 0.95)) * top);
            (out * (0.5 * pot) + Vec3::Z * (high - 0.03), out * (0.7 * spread) + Vec3::Z * tip)
        })
        .collect();
    for (foot, tip) in &bent {
        tube(&mut core, (*foot, stem_m), (*tip, 0.7 * stem_m), detail.pick(5, 4, 3), slot::BARK);
    }
    let mut leaves = Leaves::default();
    let (low, size) = (high + 0.15, detail.pick(0.10, 0.16, 0.3));
    let coverage: f32 = detail.pick(0.9, 0.8, 0.5);
    let area = std::f32::consts::TAU * spread * (top - low);
    for _ in 0..(coverage * area / (size * size)) as usize {
        let (foot, tip) = bent[s.below(bent.len())];
        let around = direction(s) * (spread * within(s, (0.05, 0.5)));
        let at = foot.lerp(tip, within(s, (0.15, 1.0))) + around;
        // A card reaches up to 0.95 of its size from its middle.
        let room = spread - 0.95 * size;
        let at = v(at.x.clamp(-room, room), at.y.clamp(-room, room), at.z.clamp(low, top - 0.95 * size));
        let out = v(at.x, at.y, 0.3 * (at.z - low)).normalize_or(Vec3::Z);
        let facing = (direction(s) + out * 0.4).normalize_or(out);
        leaves.card(s, at, facing, out + Vec3::Z * 0.3, size);
    }
    leaves.build("tall plant", &core)
}
