//! Which points of a mesh stand at one place.

use std::collections::HashMap;
use std::hash::{BuildHasherDefault, Hasher};

use crate::math::Vec3;

/// A place as a number; -0 and 0 are one.
pub(super) fn place_key(p: Vec3) -> u128 {
    let [x, y, z] = p.to_array().map(|v| u128::from((v + 0.0).to_bits()));
    x << 64 | y << 32 | z
}

/// Values by place. The map is only looked up, never walked through, so its order does not matter.
pub(super) type ByPlace<T> = HashMap<u128, T, BuildHasherDefault<PlaceHasher>>;

/// For each vertex the lowest vertex at its place.
pub(super) fn lowest_at_place(vertices: &[Vec3]) -> Vec<u32> {
    let mut lowest = ByPlace::with_capacity_and_hasher(vertices.len(), BuildHasherDefault::default());
    vertices.iter().zip(0..).map(|(p, i)| *lowest.entry(place_key(*p)).or_insert(i)).collect()
}

/// A few multiplications: the standard library's hasher, which withstands attacks, takes as long as all else that is done
/// with a corner.
#[derive(Debug, Default)]
pub(super) struct PlaceHasher(u64);

impl PlaceHasher {
    fn add(&mut self, word: u64) {
        self.0 = (self.0.rotate_left(23) ^ word).wrapping_mul(0x9E37_79B9_7F4A_7C15);
    }
}

impl Hasher for PlaceHasher {
    fn write(&mut self, bytes: &[u8]) {
        bytes.iter().for_each(|b| self.add(u64::from(*b)));
    }

    fn write_u128(&mut self, key: u128) {
        self.add(key as u64);
        self.add((key >> 64) as u64);
    }

    fn finish(&self) -> u64 {
        // Coordinates of few digits end in zeros, and so would the product.
        let mixed = (self.0 ^ self.0 >> 32).wrapping_mul(0xD6E8_FEB8_6659_FD93);
        mixed ^ mixed >> 32
    }
}

#[cfg(test)]
mod tests {
    use std::hash::BuildHasher;

    use super::*;

    #[test]
    fn the_lowest_vertex_stands_for_its_place() {
        let p = Vec3::new(0.0, 1.0, 2.0);
        let vertices = [p, Vec3::X, Vec3::new(-0.0, 1.0, 2.0), Vec3::X, p + Vec3::X * 1e-7];
        assert_eq!(lowest_at_place(&vertices), [0, 1, 0, 1, 4]);
    }

    #[test]
    fn places_on_a_lattice_are_spread_over_a_table() {
        // Of 4,096 numbers drawn evenly into 4,096 places, 63 % are taken.
        let build = BuildHasherDefault::<PlaceHasher>::default();
        for step in [1.0, 0.5, 0.1] {
            let mut taken = [vec![false; 4096], vec![false; 4096]];
            for i in 0..4096_u16 {
                let at = [i % 16, i / 16 % 16, i / 256].map(|k| f32::from(k) * step);
                let hash = build.hash_one(place_key(Vec3::from(at)));
                // Tables take the lowest bits and the highest.
                taken[0][hash as usize % 4096] = true;
                taken[1][(hash >> 52) as usize] = true;
            }
            for taken in taken {
                let taken = taken.iter().filter(|t| **t).count();
                assert!(taken > 2400, "{taken} places of 4,096 at steps of {step} m");
            }
        }
    }
}
