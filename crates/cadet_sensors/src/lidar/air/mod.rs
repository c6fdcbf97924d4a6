//! What fog, rain and snow do to a beam on its way. In clear air nothing is drawn and every factor is exactly 1.

mod crossover;
mod fog;
mod ground;
mod particles;
mod recorded;
mod spray;

pub(super) use ground::{FALLEN_SNOW, under_snow};
pub use recorded::{Fate, Weathered, weather_recorded};
pub(super) use spray::{Plumes, Sprayed};

use self::fog::Fog;
use self::particles::Particles;
use super::receiver::Receiver;
use crate::weather::Weather;
use cadet_base::material::Semantic;
use cadet_base::math;
use cadet_base::rng::CounterRng;

/// Fog's return is spread behind its strongest place by this times a Beta(2, 20) number: 0.9 m on average.
const FOG_SPREAD_M: f64 = 10.0;

/// The air and the wet or white ground of one scan.
#[derive(Debug, Clone)]
pub(super) struct Air {
    /// Attenuation per meter, one way: fog's, the drops', the flakes'.
    fog_alpha_per_m: f64,
    alpha_per_m: f64,
    fog: Option<Fog>,
    rain: Option<Particles>,
    snow: Option<Particles>,
    wetness: f64,
    snow_cover: f64,
}

/// What the air does to one beam.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Meeting {
    /// Power that is left of the target's echo.
    pub transmittance: f64,
    /// What the air itself returns, if it is stronger than the target.
    pub air_return: Option<AirReturn>,
}

/// A return from a drop, a flake or fog.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct AirReturn {
    pub range_m: f64,
    /// Power times range^2, with all that was lost on the way.
    pub reflectance: f64,
    pub from: Scatterer,
}

/// What returns in a target's place.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Scatterer {
    /// A drop or a flake, detected by itself.
    Particle,
    /// Fog: its response is known relative to a target's that was detected in clear air.
    Fog,
}

impl Air {
    pub(super) fn new(weather: &Weather, receiver: &Receiver) -> Self {
        let alpha_per_m = weather.extinction_per_m();
        let fog_alpha_per_m = weather.fog_alpha_per_m;
        Self {
            fog_alpha_per_m,
            alpha_per_m,
            fog: (fog_alpha_per_m > 0.0).then(|| Fog::new(fog_alpha_per_m, receiver.pulse_s)),
            rain: weather.drops().map(|sizes| Particles::drops(sizes, alpha_per_m, receiver)),
            snow: weather.flakes().map(|sizes| Particles::flakes(sizes, alpha_per_m, receiver)),
            wetness: weather.wetness,
            snow_cover: weather.snow_cover(),
        }
    }

    /// True if nothing stands in the air.
    #[inline]
    pub(super) fn is_clear(&self) -> bool {
        self.alpha_per_m == 0.0
    }

    /// What becomes of a beam whose target at `range_m` returns `power` (reflectance / range^2) in clear air; an
    /// infinite range and a power of 0 stand for no target. `key` names the beam: the same key meets the same drops.
    pub(super) fn meet(&self, range_m: f64, power: f64, key: u64) -> Meeting {
        if self.is_clear() {
            return Meeting { transmittance: 1.0, air_return: None };
        }
        let mut rng = CounterRng::new(key);
        let mut strongest: Option<particles::Particle> = None;
        let mut keep = |found: particles::Particle| {
            if strongest.is_none_or(|s| found.power > s.power) {
                strongest = Some(found);
            }
        };
        if let Some(rain) = &self.rain {
            rain.draw(range_m, &mut rng, &mut keep);
        }
        let mut open = 1.0;
        let mut depth = 2.0 * self.alpha_per_m * range_m;
        if let Some(snow) = &self.snow {
            // On the way out the flakes that are drawn cover the beam themselves; the rest, and the way back, is the mean.
            snow.draw(range_m, &mut rng, |flake| {
                open *= 1.0 - flake.share;
                keep(flake);
            });
            depth -= snow.bright_depth(range_m);
        }
        let transmittance = open * math::exp(-depth);
        let mut best = power * transmittance;
        let mut air_return = None;
        if let (Some(fog), true) = (&self.fog, range_m.is_finite()) {
            let soft = fog.before(range_m);
            // Both echoes are proportional to the target's, so that targets of intensity 0 follow the same rule.
            if soft.gain > transmittance {
                best = power * soft.gain;
                let at_m = (soft.range_m + FOG_SPREAD_M * beta_2_20(&mut rng)).min(range_m);
                air_return = Some(AirReturn {
                    range_m: at_m,
                    reflectance: power * range_m * range_m * soft.gain,
                    from: Scatterer::Fog,
                });
            }
        }
        if let Some(particle) = strongest.filter(|p| p.power > best) {
            air_return = Some(AirReturn {
                range_m: particle.range_m,
                reflectance: particle.power * particle.range_m * particle.range_m,
                from: Scatterer::Particle,
            });
        }
        Meeting { transmittance, air_return }
    }

    /// What the air leaves of an echo on average: exactly 1 where it is clear.
    pub(super) fn transmittance(&self, range_m: f64) -> f64 {
        if self.is_clear() { 1.0 } else { math::exp(-2.0 * self.alpha_per_m * range_m) }
    }

    /// What fog alone leaves of an echo.
    fn fog_transmittance(&self, range_m: f64) -> f64 {
        if self.fog_alpha_per_m == 0.0 { 1.0 } else { math::exp(-2.0 * self.fog_alpha_per_m * range_m) }
    }

    /// Reflectance of ground that has `reflectance` back to the sensor when it is dry and bare.
    pub(super) fn ground(&self, semantic: Semantic, reflectance: f64, cos_incidence: f64) -> f64 {
        let mut left = reflectance;
        // Grass holds no film.
        if semantic != Semantic::Terrain {
            left *= self.wet_share(reflectance, cos_incidence);
        }
        under_snow(left, cos_incidence, self.snow_cover)
    }

    /// Share of a paved ground's echo that is left where a film of water covers the share `wetness` of it.
    fn wet_share(&self, reflectance: f64, cos_incidence: f64) -> f64 {
        if self.wetness == 0.0 {
            return 1.0;
        }
        1.0 - self.wetness * (1.0 - ground::under_water(reflectance, cos_incidence))
    }
}

/// Beta(2, 20): the second smallest of 21 uniform numbers.
fn beta_2_20(rng: &mut CounterRng) -> f64 {
    let (u, v) = (1.0 - rng.unit(), 1.0 - rng.unit());
    1.0 - math::exp(math::ln(u) / 21.0 + math::ln(v) / 20.0)
}

#[cfg(test)]
mod tests;
