//! Unit vectors in four bytes.

use crate::math::Vec3;

const STEPS: f32 = 32767.0;

/// A unit vector as its octahedral coordinates: exact along the axes, within 0.005 degrees elsewhere.
///
/// Reference: Cigolle et al., "A Survey of Efficient Representations for Independent Unit Vectors" (JCGT 2014).
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) struct PackedNormal([i16; 2]);

impl PackedNormal {
    /// Packs a vector of any length; none has the direction of z.
    #[must_use]
    pub fn of(normal: Vec3) -> Self {
        let sum = normal.abs().element_sum();
        let (u, v) = if sum > 0.0 { (normal.x / sum, normal.y / sum) } else { (0.0, 0.0) };
        let folded = if normal.z < 0.0 { [(1.0 - v.abs()).copysign(u), (1.0 - u.abs()).copysign(v)] } else { [u, v] };
        // To the nearest step: `round` is a call on processors without SSE 4.
        Self(folded.map(|c| (c * STEPS + 0.5_f32.copysign(c)) as i16))
    }

    /// The unit vector.
    #[inline(always)]
    #[must_use]
    pub fn unpacked(self) -> Vec3 {
        let (u, v) = (f32::from(self.0[0]) / STEPS, f32::from(self.0[1]) / STEPS);
        let z = 1.0 - u.abs() - v.abs();
        let fold = (-z).max(0.0);
        Vec3::new(u - fold.copysign(u), v - fold.copysign(v), z).normalize()
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::rng::Stream;

    #[test]
    fn axes_are_exact_and_all_others_nearly_so() {
        for axis in [Vec3::X, Vec3::Y, Vec3::Z, -Vec3::X, -Vec3::Y, -Vec3::Z] {
            assert_eq!(PackedNormal::of(axis).unpacked(), axis);
        }
        assert_eq!(PackedNormal::of(Vec3::ZERO).unpacked(), Vec3::Z);
        let mut s = Stream::from_seed("normals", 0);
        let mut largest: f32 = 0.0;
        for _ in 0..100_000 {
            let normal = Vec3::from_array([0; 3].map(|_| s.range(-1.0, 1.0) as f32)).normalize_or(Vec3::Z);
            let unpacked = PackedNormal::of(normal).unpacked();
            assert!((unpacked.length() - 1.0).abs() < 1e-6);
            largest = largest.max(unpacked.distance(normal).to_degrees());
        }
        assert!(largest > 0.001 && largest < 0.005, "{largest}");
    }
}
