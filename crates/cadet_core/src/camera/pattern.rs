//! Procedural textures: integer-hash value noise and the few patterns of a street, faded where a pixel can't hold them.

use crate::material::Pattern;
use crate::math::Vec3;

/// A well mixed hash of two lattice coordinates and a salt.
#[inline(always)]
#[must_use]
pub fn hash2(x: i32, y: i32, salt: u32) -> u32 {
    let mut h = (x as u32).wrapping_mul(0x8DA6_B343) ^ (y as u32).wrapping_mul(0xD816_3841) ^ salt;
    h = (h ^ (h >> 15)).wrapping_mul(0x2C1B_3C6D);
    h = (h ^ (h >> 12)).wrapping_mul(0x297A_2D39);
    h ^ (h >> 15)
}

/// An integer and how far `x` lies beyond it: rounding by adding a large number, as vector registers can. Of an integer
/// it may give the one below and 1; |x| must stay below 2^21.
#[inline(always)]
pub(super) fn split(x: f32) -> (i32, f32) {
    const LARGE: f32 = 12_582_912.0; // 1.5 * 2^23
    let rounded = (x - 0.5) + LARGE;
    ((rounded.to_bits() as i32).wrapping_sub(LARGE.to_bits() as i32), x - (rounded - LARGE))
}

/// A number in [0, 1) for a lattice point, given by products of its coordinates with `LATTICE`.
#[inline(always)]
fn lattice(x: u32, y: u32, salt: u32) -> f32 {
    let mut h = x ^ y ^ salt;
    h = (h ^ (h >> 15)).wrapping_mul(0x2C1B_3C6D);
    h ^= h >> 14;
    ((h & 0xFF_FFFF) as i32) as f32 * (1.0 / 16_777_216.0)
}
const LATTICE: [u32; 2] = [0x8DA6_B343, 0xD816_3841];

/// Smooth value noise in [0, 1) with lattice cells of size 1.
#[inline(always)]
#[must_use]
pub fn value_noise(x: f32, y: f32, salt: u32) -> f32 {
    let ((ix, fx), (iy, fy)) = (split(x), split(y));
    let (hx, hy) = ((ix as u32).wrapping_mul(LATTICE[0]), (iy as u32).wrapping_mul(LATTICE[1]));
    let (hx1, hy1) = (hx.wrapping_add(LATTICE[0]), hy.wrapping_add(LATTICE[1]));
    let salt = salt.wrapping_mul(0x9E37_79B1);
    let (sx, sy) = (fx * fx * (3.0 - 2.0 * fx), fy * fy * (3.0 - 2.0 * fy));
    let (a, b) = (lattice(hx, hy, salt), lattice(hx1, hy, salt));
    let (c, d) = (lattice(hx, hy1, salt), lattice(hx1, hy1, salt));
    let (top, bottom) = (a + (b - a) * sx, c + (d - c) * sx);
    top + (bottom - top) * sy
}

/// Value noise summed over octaves, in [0, 1).
#[inline(always)]
#[must_use]
pub fn fbm(x: f32, y: f32, octaves: u32, salt: u32) -> f32 {
    let (mut sum, mut amplitude, mut total, mut scale) = (0.0, 0.5, 0.0, 1.0);
    for octave in 0..octaves {
        sum += amplitude * value_noise(x * scale, y * scale, salt.wrapping_add(octave));
        total += amplitude;
        amplitude *= 0.5;
        scale *= 2.0;
    }
    sum / total
}

/// Where a pattern is evaluated.
#[derive(Debug, Clone, Copy)]
pub struct PatternPoint {
    /// Along the surface: world x and y on the ground, else meters along and up a wall.
    pub u: f32,
    /// See `u`.
    pub v: f32,
    /// Size of a pixel on the surface, meters (the geometric mean of its two extents).
    pub footprint_m: f32,
    /// Width of a pixel there square to the view, meters.
    pub pixel_m: f32,
    /// Hash of the face, for what varies leaf by leaf.
    pub face_hash: u32,
    /// Hash of the instance's place, for what varies tree by tree.
    pub place_hash: u32,
}

/// 1 where a feature of `size_m` spans pixels enough to be drawn, 0 where it would flicker.
#[inline(always)]
fn keep(size_m: f32, footprint_m: f32) -> f32 {
    ((size_m / footprint_m - 0.7) * 0.8).clamp(0.0, 1.0)
}

/// Noise in [-1, 1] whose cells are about a pixel wide at any distance but never finer than `finest_m`: grain.
///
/// A pixel on the ground is many times as long as wide: its grain is as fine as it is wide, as in a real picture, where each
/// row of pixels shows other stones than the last.
#[inline(always)]
fn grain(u: f32, v: f32, pixel_m: f32, finest_m: f32, salt: u32) -> f32 {
    let cell = pixel_m.max(finest_m);
    // Powers of two bracketing the cell, blended, so that nothing jumps when the camera moves.
    let exponent = (cell.to_bits() >> 23) as i32;
    let low = f32::from_bits((exponent as u32) << 23);
    let t = cell / low - 1.0;
    let (a, b) = (1.0 / low, 0.5 / low);
    let salt = salt.wrapping_add(exponent as u32);
    let fine = value_noise(u * a, v * a, salt);
    let coarse = value_noise(u * b, v * b, salt.wrapping_add(1));
    (fine + (coarse - fine) * t) * 2.0 - 1.0
}

/// A cell of a grid of stones: its hash and the darkening of the joints.
#[inline(always)]
fn stones(u: f32, v: f32, length: f32, width: f32, joint: f32, running: bool, footprint: f32) -> (u32, f32) {
    let (row, in_row) = split(v * (1.0 / width));
    let shift = if running && row & 1 == 1 { 0.5 } else { 0.0 };
    let (column, in_column) = split(u * (1.0 / length) + shift);
    let (du, dv) = (in_column * length, in_row * width);
    let edge = du.min(length - du).min(dv.min(width - dv));
    // A joint thinner than the pixel darkens by its share of the pixel.
    let soft = joint.max(footprint * 0.7);
    let line = (1.0 - edge / soft).clamp(0.0, 1.0) * (joint / soft).min(1.0);
    (hash2(column, row, 0x57A1), line * keep(width, footprint))
}

#[inline(always)]
fn centered(hash: u32) -> f32 {
    (hash >> 8) as i32 as f32 * (2.0 / 16_777_216.0) - 1.0
}

/// The albedo of a pattern at a point.
#[inline(always)]
#[must_use]
pub fn albedo(pattern: Pattern, base: Vec3, at: &PatternPoint) -> Vec3 {
    let (u, v, px, fine) = (at.u, at.v, at.footprint_m, at.pixel_m);
    match pattern {
        Pattern::Plain => base,
        Pattern::Asphalt => {
            // Far stones are averaged, but patches of them remain.
            let grain = 0.60 / (1.0 + fine * (1.0 / 0.04)) * grain(u, v, fine, 0.008, 0xA5F1);
            let patches = 0.16 * (value_noise(u * 0.45, v * 0.45, 7) - 0.5) * keep(2.2, px)
                + 0.09 * (value_noise(u * 1.9 + 3.3, v * 1.9, 8) - 0.5) * keep(0.5, px)
                + 0.16 * (value_noise(u * 0.06, v * 0.06, 9) - 0.5);
            base * (1.0 + grain + patches)
        }
        Pattern::Slabs | Pattern::Blocks => {
            let (length, width, joint, running) =
                if pattern == Pattern::Slabs { (0.40, 0.40, 0.006, true) } else { (0.20, 0.10, 0.006, true) };
            let (stone, line) = stones(u, v, length, width, joint, running, px);
            let each = 0.13 * centered(stone) * keep(width, px);
            let dirt = 0.30 * (value_noise(u * 1.7, v * 1.7, 21) - 0.5) + 0.21 * grain(u, v, fine, 0.008, 22);
            base * ((1.0 + each + dirt) * (1.0 - 0.55 * line))
        }
        Pattern::Bricks => {
            let (stone, line) = stones(u, v, 0.25, 0.077, 0.010, true, px);
            let each = 0.18 * centered(stone) * keep(0.077, px);
            let mortar = base * 0.3 + Vec3::splat(0.25);
            let brick = base * (1.0 + each + 0.22 * grain(u, v, fine, 0.008, 31));
            brick + (mortar - brick) * (0.8 * line)
        }
        Pattern::Render => {
            // Stains run down a wall: stretched noise. Rain splashes soil on its foot.
            let streak = value_noise(u * 2.9, v * 0.5, 41) - 0.5;
            let stains = 0.16 * streak * keep(0.34, px);
            let low = (1.0 - v * 0.9).clamp(0.0, 1.0);
            let splashed = 0.30 * low * low * (0.6 + streak);
            // The trowel leaves it uneven, over some pixels at any distance; sand is finer.
            let uneven = 0.08 * grain(u, v, 3.0 * fine, 0.05, 42);
            base * (1.0 + stains - splashed + uneven + 0.11 * grain(u, v, fine, 0.006, 43))
        }
        Pattern::Tiles => {
            let (row, in_row) = split(v * (1.0 / 0.33));
            let dv = in_row * 0.33;
            let (column, du) = split(u * (1.0 / 0.22));
            let each = 0.16 * centered(hash2(column, row, 51)) * keep(0.25, px);
            let soft = (px * 0.7).max(0.03);
            let shadow = (1.0 - dv / soft).clamp(0.0, 1.0) * (0.03 / soft).min(1.0) * 0.6;
            let roll = 0.25 * (du * (1.0 - du) * 4.0 - 0.66) * keep(0.22, px);
            let moss = 0.24 * (value_noise(u * 0.5, v * 0.35, 52) - 0.5);
            let rough = 0.22 * grain(u, v, fine, 0.01, 53);
            base * ((1.0 + each + roll + moss + rough) * (1.0 - shadow))
        }
        Pattern::Grass => {
            let blades = 0.55 * grain(u, v, fine, 0.008, 61) + 0.35 * grain(u * 0.37, v * 0.37, px, 0.04, 64);
            let tufts = 0.7 * (value_noise(u * 4.1, v * 4.1, 62) - 0.5) * keep(0.25, px);
            // Patches that dry out are yellower and lighter.
            let dry = value_noise(u * 0.8, v * 0.8, 63);
            let tint = Vec3::new(0.96 + 0.45 * dry * dry, 1.0, 1.25 - 0.2 * dry);
            base * tint * (1.0 + blades + tufts + 0.9 * (dry - 0.5) * keep(1.2, px)).max(0.15)
        }
        Pattern::Leaves => {
            let leaf = (at.face_hash >> 8) as i32 as f32 * (1.0 / 16_777_216.0);
            let tree = (at.place_hash >> 8) as i32 as f32 * (1.0 / 16_777_216.0);
            let yellow = ((at.face_hash & 0xFF) as i32 as f32 / 255.0 - 0.55).max(0.0);
            let spread = 0.58 + 0.75 * leaf * leaf;
            // A card holds many leaves, a few of them bright before the shade between them.
            let bright = (0.5 + 1.0 * grain(u, v, 1.7 * px, 0.035, at.face_hash | 1)).clamp(0.0, 1.0);
            let inside = 0.38 + 1.9 * bright * bright;
            let tint = Vec3::new(0.85 + 0.4 * tree + 0.5 * yellow, 0.95 + 0.25 * yellow, 1.12 + 0.2 * tree);
            base * tint * (spread * inside)
        }
        Pattern::Wood => {
            let fibre = 0.30 * (value_noise(u * 14.0, v * 1.2, 71) - 0.5) * keep(0.07, px);
            let board = 0.15 * centered(hash2(split(u * (1.0 / 0.12)).0, 0, 72)) * keep(0.12, px);
            base * (1.0 + fibre + board + 0.20 * grain(u, v, fine, 0.006, 73))
        }
        Pattern::Cloth => {
            let folds = 0.30 * (value_noise(u * 9.0, v * 4.0, 81) - 0.5) * keep(0.1, px);
            base * (1.0 + folds + 0.10 * grain(u, v, fine, 0.006, 82))
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn statistics(pattern: Pattern, footprint_m: f32) -> (f32, f32) {
        let n = 160;
        let mut values = Vec::new();
        for i in 0..n {
            for j in 0..n {
                let (u, v) = (i as f32 * footprint_m, j as f32 * footprint_m);
                let hash = hash2(i / 3, j / 3, 5);
                let at = PatternPoint { u, v, footprint_m, pixel_m: footprint_m, face_hash: hash, place_hash: 77 };
                values.push(albedo(pattern, Vec3::splat(0.5), &at).y);
            }
        }
        let mean = values.iter().sum::<f32>() / values.len() as f32;
        let var = values.iter().map(|x| (x - mean) * (x - mean)).sum::<f32>() / values.len() as f32;
        (mean / 0.5, var.sqrt() / mean)
    }

    #[test]
    fn patterns_keep_their_mean_albedo_near_and_far() {
        for pattern in Pattern::ALL {
            for footprint in [0.004, 0.03, 0.3] {
                let (mean, spread) = statistics(pattern, footprint);
                assert!((0.78..1.22).contains(&mean), "{pattern:?} at {footprint}: mean {mean}");
                assert!(spread < 0.75, "{pattern:?} at {footprint}: spread {spread}");
            }
        }
    }

    #[test]
    fn asphalt_has_the_grain_that_was_measured() {
        for footprint in [0.008, 0.02, 0.06] {
            let (_, spread) = statistics(Pattern::Asphalt, footprint);
            // Before lens and sensor; what is left of it in pictures is tested on them.
            assert!((0.10..0.24).contains(&spread), "{footprint}: {spread}");
        }
    }

    #[test]
    fn noise_is_continuous_across_cells_and_negative_coordinates() {
        for k in -40..40 {
            let x = k as f32 * 0.25;
            let step = (value_noise(x + 1e-3, 0.3, 1) - value_noise(x - 1e-3, 0.3, 1)).abs();
            assert!(step < 0.01, "{x}: {step}");
        }
    }
}
