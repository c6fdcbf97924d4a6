//! What fog, rain and snow do to a beam on its way. In clear air every factor is exactly 1 and every chance exactly 0.

use crate::math;
use crate::weather::Weather;

/// The air of one scan.
#[derive(Debug, Clone, Copy)]
pub(super) struct Air {
    /// Attenuation per metre, one way.
    alpha_per_m: f64,
    /// Power that fog scatters back from the first metres, in units of reflectance / range^2.
    fog_backscatter: f64,
    /// Chance per metre of meeting a drop or flake that answers.
    particles_per_m: f64,
    /// Share of the range added to its noise.
    range_noise_share: f64,
    /// Reflectance left of wet ground.
    pub wet_ground: f64,
}

/// Drops and flakes further away answer too weakly.
const PARTICLE_REACH_M: f64 = 18.0;

impl Air {
    pub(super) fn new(weather: &Weather) -> Self {
        let (rain, snow, fog) = (weather.rain_mm_per_h, weather.snow_mm_per_h, weather.fog_alpha_per_m);
        // Backscatter beta = 0.046 / MOR with MOR = ln 20 / alpha; a pulse of 3 m gathers about a quarter of it beyond
        // the first metre, where the receiver's view opens; pi turns it into the reflectance of a Lambertian target.
        let beta = 0.046 * fog / math::ln(20.0);
        let rain_alpha = if rain > 0.0 { 0.001 * math::pow(rain, 0.6) } else { 0.0 };
        let blur = 1.0 - math::exp(-rain);
        Self {
            alpha_per_m: fog + rain_alpha + 0.004 * snow,
            fog_backscatter: math::PI * 0.25 * beta,
            particles_per_m: 2e-5 * rain + 2e-3 * snow,
            range_noise_share: 2e-4 * blur * blur,
            wet_ground: 1.0 - 0.6 * weather.wetness,
        }
    }

    /// Power that is left after the way there and back.
    pub(super) fn transmittance(&self, range_m: f64) -> f64 {
        if self.alpha_per_m == 0.0 { 1.0 } else { math::exp(-2.0 * self.alpha_per_m * range_m) }
    }

    /// Noise that the air adds to a range.
    pub(super) fn range_noise_m(&self, range_m: f64) -> f64 {
        self.range_noise_share * range_m
    }

    /// Where the air answers instead of a target at `range_m` that returns `power` (reflectance / range^2), if it does;
    /// infinity stands for no target. `chance` and `place` are uniform in [0, 1).
    pub(super) fn answers_first(&self, range_m: f64, power: f64, chance: f64, place: f64) -> Option<AirReturn> {
        if self.particles_per_m > 0.0 {
            let reach_m = range_m.min(PARTICLE_REACH_M);
            if chance < self.particles_per_m * reach_m {
                return Some(AirReturn { range_m: reach_m * place, reflectance: 0.06 });
            }
        }
        if self.fog_backscatter > 0.0 {
            // Speckle: an exponential spread about the mean.
            let soft = -self.fog_backscatter * math::ln(1.0 - chance);
            let at_m = 1.5 + 4.0 * place * place;
            if soft > power && soft > SOFT_FLOOR && at_m < range_m {
                return Some(AirReturn { range_m: at_m, reflectance: soft * at_m * at_m });
            }
        }
        None
    }
}

/// Fog weaker than this is not heard.
const SOFT_FLOOR: f64 = 1e-3;

/// A return from a drop, a flake or fog.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct AirReturn {
    pub range_m: f64,
    pub reflectance: f64,
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn clear_air_does_nothing_at_all() {
        let air = Air::new(&Weather::preset("clear_noon").expect("exists"));
        assert_eq!((air.transmittance(79.0), air.range_noise_m(79.0), air.wet_ground), (1.0, 0.0, 1.0));
        assert_eq!(air.answers_first(f64::INFINITY, 0.0, 0.0, 0.5), None);
        assert_eq!(air.answers_first(f64::INFINITY, 0.0, 0.999_999, 0.5), None);
    }

    #[test]
    fn fog_halves_power_as_beer_and_lambert_say() {
        let air = Air::new(&Weather::preset("dense_fog").expect("exists"));
        let half = math::ln(2.0) / (2.0 * 0.06);
        assert!((air.transmittance(half) - 0.5).abs() < 1e-12);
    }
}
