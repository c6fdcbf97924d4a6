//! What rain and snow leave on the ground, for a laser; snow on other surfaces, too.

use super::reflection::{fresnel, reflectance};
use crate::surface_cover::{WATER_INDEX, under_film};
use cadet_base::material::LidarMaterial;
use cadet_base::math;

/// Fallen snow at 905 nm.
pub(crate) const FALLEN_SNOW: LidarMaterial = LidarMaterial::diffuse(0.8);

/// Reflectance of a surface of which snow covers a share, by its own.
pub(crate) fn under_snow(bare_reflectance: f64, cos_incidence: f64, snow_cover: f64) -> f64 {
    if snow_cover > 0.0 {
        math::lerp(bare_reflectance, reflectance(&FALLEN_SNOW, cos_incidence), snow_cover)
    } else {
        bare_reflectance
    }
}

/// Share of the light that comes back from a diffuse surface under a film of water, against the same surface dry.
///
/// At the film's face Fresnel's share is mirrored away, on the way in and on the way out (Hahner et al., CVPR 2022).
pub(crate) fn under_water(reflectance: f64, cos_incidence: f64) -> f64 {
    under_film(reflectance, 1.0 - fresnel(WATER_INDEX, cos_incidence))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn fresnel_has_its_known_values() {
        assert!((fresnel(WATER_INDEX, 1.0) - (0.328_f64 / 2.328) * (0.328 / 2.328)).abs() < 1e-12);
        assert!((fresnel(WATER_INDEX, 0.0) - 1.0).abs() < 1e-12);
        // At Brewster's angle only half of the s-polarised light is left: ((n^2 - 1) / (n^2 + 1))^2 / 2.
        let brewster = 1.0 / (1.0 + WATER_INDEX * WATER_INDEX).sqrt();
        let s = (WATER_INDEX * WATER_INDEX - 1.0) / (WATER_INDEX * WATER_INDEX + 1.0);
        assert!((fresnel(WATER_INDEX, brewster) - s * s / 2.0).abs() < 1e-12);
    }

    #[test]
    fn wet_asphalt_is_dark_and_darker_at_grazing_angles() {
        let shares: Vec<f64> = [1.0, 0.5, 0.17, 0.09].iter().map(|c| under_water(0.2, *c)).collect();
        assert!((0.5..0.65).contains(&shares[0]), "{shares:?}");
        assert!(shares.windows(2).all(|w| w[1] < w[0]) && shares[3] < 0.15, "{shares:?}");
        // Light that all comes back from below is not lost.
        assert!(
            (under_water(1.0, 1.0) - (1.0 - fresnel(WATER_INDEX, 1.0)) * (1.0 - fresnel(WATER_INDEX, 1.0))).abs()
                < 1e-12
        );
    }
}
