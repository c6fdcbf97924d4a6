//! Integer-hash value noise on a lattice (Perlin, "An image synthesizer", 1985, with a hash for the table).

/// Factors of a lattice's coordinates (Ericson, "Real-Time Collision Detection", 2005).
const LATTICE: [u32; 2] = [0x8DA6_B343, 0xD816_3841];
/// Factor of a salt: 2^32 over the golden ratio.
const SALT_FACTOR: u32 = 0x9E37_79B1;
/// Factors and shifts that mix a hash (Wellons, "Prospecting for Hash Functions", 2018).
const HASH_FACTORS: [u32; 2] = [0x2C1B_3C6D, 0x297A_2D39];
const HASH_SHIFTS: [u32; 2] = [15, 12];
const LATTICE_SHIFT: u32 = 14;
const LOW_24_BITS: u32 = 0xFF_FFFF;
const TWO_TO_24: f32 = 16_777_216.0;
/// 1.5 * 2^23: added to a number it leaves the nearest integer in the mantissa.
const ROUNDER: f32 = 12_582_912.0;
/// Bits of a single-precision number's mantissa.
const MANTISSA_BITS: u32 = 23;
/// From an octave to the next: its amplitude and its frequency.
const OCTAVE_GAIN: f32 = 0.5;
const LACUNARITY: f32 = 2.0;

/// A well mixed hash of two lattice coordinates and a salt.
#[inline(always)]
#[must_use]
pub fn hash2(x: i32, y: i32, salt: u32) -> u32 {
    let mut h = (x as u32).wrapping_mul(LATTICE[0]) ^ (y as u32).wrapping_mul(LATTICE[1]) ^ salt;
    h = (h ^ (h >> HASH_SHIFTS[0])).wrapping_mul(HASH_FACTORS[0]);
    h = (h ^ (h >> HASH_SHIFTS[1])).wrapping_mul(HASH_FACTORS[1]);
    h ^ (h >> HASH_SHIFTS[0])
}

/// An integer and how far `x` lies beyond it: rounding by adding a large number, as vector registers can. Of an integer
/// it may give the one below and 1; |x| must stay below 2^21.
#[inline(always)]
pub(crate) fn split(x: f32) -> (i32, f32) {
    let rounded = (x - 0.5) + ROUNDER;
    ((rounded.to_bits() as i32).wrapping_sub(ROUNDER.to_bits() as i32), x - (rounded - ROUNDER))
}

/// A number in [0, 1) for a lattice point, given by products of its coordinates with `LATTICE`.
#[inline(always)]
fn lattice(x: u32, y: u32, salt: u32) -> f32 {
    let mut h = x ^ y ^ salt;
    h = (h ^ (h >> HASH_SHIFTS[0])).wrapping_mul(HASH_FACTORS[0]);
    h ^= h >> LATTICE_SHIFT;
    ((h & LOW_24_BITS) as i32) as f32 * (1.0 / TWO_TO_24)
}

/// Hermite's cubic from 0 to 1.
#[inline(always)]
fn smoothstep(t: f32) -> f32 {
    t * t * (3.0 - 2.0 * t)
}

/// Smooth value noise in [0, 1) with lattice cells of size 1.
#[inline(always)]
#[must_use]
pub fn value_noise(x: f32, y: f32, salt: u32) -> f32 {
    let ((ix, fx), (iy, fy)) = (split(x), split(y));
    let (hx, hy) = ((ix as u32).wrapping_mul(LATTICE[0]), (iy as u32).wrapping_mul(LATTICE[1]));
    let (hx1, hy1) = (hx.wrapping_add(LATTICE[0]), hy.wrapping_add(LATTICE[1]));
    let salt = salt.wrapping_mul(SALT_FACTOR);
    let (sx, sy) = (smoothstep(fx), smoothstep(fy));
    let (a, b) = (lattice(hx, hy, salt), lattice(hx1, hy, salt));
    let (c, d) = (lattice(hx, hy1, salt), lattice(hx1, hy1, salt));
    let (top, bottom) = (a + (b - a) * sx, c + (d - c) * sx);
    top + (bottom - top) * sy
}

/// Value noise summed over octaves, in [0, 1).
#[inline(always)]
#[must_use]
pub fn fbm(x: f32, y: f32, octaves: u32, salt: u32) -> f32 {
    let (mut sum, mut amplitude, mut total, mut scale) = (0.0, OCTAVE_GAIN, 0.0, 1.0);
    for octave in 0..octaves {
        sum += amplitude * value_noise(x * scale, y * scale, salt.wrapping_add(octave));
        total += amplitude;
        amplitude *= OCTAVE_GAIN;
        scale *= LACUNARITY;
    }
    sum / total
}

/// Noise in [-1, 1] whose cells are about a pixel wide at any distance but never finer than `finest_m`: grain.
///
/// A pixel on the ground is many times as long as wide: its grain is as fine as it is wide, as in a real picture, where each
/// row of pixels shows other stones than the last.
#[inline(always)]
#[must_use]
pub fn grain(u: f32, v: f32, pixel_m: f32, finest_m: f32, salt: u32) -> f32 {
    let cell = pixel_m.max(finest_m);
    // Powers of two bracketing the cell, blended, so that nothing jumps when the camera moves.
    let exponent = (cell.to_bits() >> MANTISSA_BITS) as i32;
    let low = f32::from_bits((exponent as u32) << MANTISSA_BITS);
    let t = cell / low - 1.0;
    let (a, b) = (1.0 / low, 0.5 / low);
    let salt = salt.wrapping_add(exponent as u32);
    let fine = value_noise(u * a, v * a, salt);
    let coarse = value_noise(u * b, v * b, salt.wrapping_add(1));
    (fine + (coarse - fine) * t) * 2.0 - 1.0
}

/// The high 24 bits of a hash as a number in [0, 1).
#[inline(always)]
#[must_use]
pub fn unit(hash: u32) -> f32 {
    (hash >> 8) as i32 as f32 * (1.0 / TWO_TO_24)
}

/// The high 24 bits of a hash as a number in [-1, 1).
#[inline(always)]
#[must_use]
pub fn centered(hash: u32) -> f32 {
    (hash >> 8) as i32 as f32 * (2.0 / TWO_TO_24) - 1.0
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn noise_is_continuous_across_cells_and_negative_coordinates() {
        for k in -40..40 {
            let x = k as f32 * 0.25;
            let step = (value_noise(x + 1e-3, 0.3, 1) - value_noise(x - 1e-3, 0.3, 1)).abs();
            assert!(step < 0.01, "{x}: {step}");
        }
    }
}
