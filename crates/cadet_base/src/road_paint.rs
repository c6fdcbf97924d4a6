//! Worn paint on roads: who lays it knows the paint, how much of it is left, and the asphalt below; who looks at it needs all
//! three, and a material has one albedo.

use crate::math::Vec3;

/// Albedos of fresh paint.
pub const WHITE_ALBEDO: [f32; 3] = [0.47, 0.47, 0.455];
/// As [`WHITE_ALBEDO`], of yellow paint.
pub const YELLOW_ALBEDO: [f32; 3] = [0.47, 0.34, 0.09];
/// Red less blue: what is left of white paint has less than this, of yellow paint more.
const YELLOW_FROM: f32 = 0.05;
/// Shares that are left lie between these.
const LEAST_LEFT: f32 = 0.05;
const MOST_LEFT: f32 = 0.98;

/// Paint of which a share is left, and between it the asphalt's gray.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct WornPaint {
    /// The share of the paint that is left.
    pub left_share: f32,
    /// Albedo of the asphalt.
    pub asphalt_albedo: f32,
}

impl WornPaint {
    /// The mean albedo over what is left of the paint and the asphalt between.
    #[must_use]
    pub fn albedo(self, fresh: [f32; 3]) -> [f32; 3] {
        fresh.map(|c| self.asphalt_albedo + (c - self.asphalt_albedo) * self.left_share)
    }

    /// Takes the mean albedo apart: gray asphalt adds nothing to the difference of red and blue, which tells what is left.
    #[inline(always)]
    #[must_use]
    pub fn of_albedo(albedo: Vec3) -> Self {
        let warmth = albedo.x - albedo.z;
        let fresh =
            if warmth > YELLOW_FROM { YELLOW_ALBEDO[0] - YELLOW_ALBEDO[2] } else { WHITE_ALBEDO[0] - WHITE_ALBEDO[2] };
        let left = (warmth / fresh).clamp(LEAST_LEFT, MOST_LEFT);
        Self { left_share: left, asphalt_albedo: (albedo.x - WHITE_ALBEDO[0] * left) / (1.0 - left) }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_is_left_and_the_asphalt_below_are_read_from_the_mean() {
        assert!((WHITE_ALBEDO[0] - YELLOW_ALBEDO[0]).abs() < f32::EPSILON, "of_albedo() takes both for equally red");
        for fresh in [WHITE_ALBEDO, YELLOW_ALBEDO] {
            for left in [0.42, 0.58, 0.74, 0.88, 0.97] {
                for asphalt in [0.1, 0.2, 0.3] {
                    let found = WornPaint::of_albedo(Vec3::from(
                        WornPaint { left_share: left, asphalt_albedo: asphalt }.albedo(fresh),
                    ));
                    assert!((found.left_share - left).abs() < 1e-4, "{found:?} of {left}");
                    assert!((found.asphalt_albedo - asphalt).abs() < 1e-3, "{found:?} on {asphalt}");
                }
            }
        }
    }
}
