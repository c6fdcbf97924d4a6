//! What fog, rain and snow do to a beam on its way. In clear air nothing is drawn and every factor is exactly 1.

mod aerosol;
mod air_echo;
mod particles;
mod recorded;
mod spray;

pub(super) use air_echo::AirEcho;
pub use recorded::{Fate, Weathered, weather_recorded};
pub(super) use spray::{Plumes, Sprayed};

use self::aerosol::Fog;
use self::particles::Particles;
use crate::lidar::detection::Receiver;
use crate::lidar::reflectance::{under_snow, under_water};
use crate::weather::Weather;
use cadet_base::material::Semantic;
use cadet_base::math;
use cadet_base::rng::CounterRng;

/// The air and the wet or white ground of one scan, as lasers of one focus see it.
#[derive(Debug, Clone)]
pub(super) struct Air {
    /// Attenuation per meter, one way: fog's, the drops', the flakes'.
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
    /// Power that is left of an echo from there.
    pub transmittance: f64,
    /// The strongest drop or flake, and fog's strongest clump, of what lies before.
    pub echoes: [Option<AirEcho>; 2],
}

impl Air {
    pub(super) fn new(weather: &Weather, receiver: &Receiver, focus_m: f64) -> Self {
        let alpha_per_m = weather.extinction_per_m();
        let fog = |extinction_per_m| Fog::new(extinction_per_m, alpha_per_m, receiver, focus_m);
        let particles = Particles::seen_by(receiver, focus_m, alpha_per_m);
        Self {
            alpha_per_m,
            fog: Some(weather.fog_alpha_per_m).filter(|alpha| *alpha > 0.0).and_then(fog),
            rain: weather.drops().map(|sizes| particles.drops(sizes)),
            snow: weather.flakes().map(|sizes| particles.flakes(sizes)),
            wetness: weather.wetness,
            snow_cover: weather.snow_cover(),
        }
    }

    /// True if nothing stands in the air.
    #[inline]
    pub(super) fn is_clear(&self) -> bool {
        self.alpha_per_m == 0.0
    }

    /// What becomes of a beam on its way to `range_m`, infinite for the sky. `key` names the beam: the same key meets the same
    /// drops.
    pub(super) fn meet(&self, range_m: f64, key: u64) -> Meeting {
        if self.is_clear() {
            return Meeting { transmittance: 1.0, echoes: [None; 2] };
        }
        let mut rng = CounterRng::new(key);
        let mut particle: Option<AirEcho> = None;
        let mut open = 1.0;
        let mut depth = 2.0 * self.alpha_per_m * range_m;
        if let Some(rain) = &self.rain {
            rain.draw(range_m, &mut rng, |drop| particle = Some(drop.echo.or_stronger(particle)));
        }
        if let Some(snow) = &self.snow {
            // On the way out the flakes that are drawn cover the beam themselves; the rest, and the way back, is the mean.
            snow.draw(range_m, &mut rng, |flake| {
                open *= 1.0 - flake.share;
                particle = Some(flake.echo.or_stronger(particle));
            });
            depth -= snow.bright_depth(range_m);
        }
        let fog = self.fog.as_ref().and_then(|fog| fog.strongest_before(range_m, &mut rng));
        Meeting { transmittance: open * math::exp(-depth), echoes: [particle, fog] }
    }

    /// What the air leaves of an echo on average: exactly 1 where it is clear.
    pub(super) fn transmittance(&self, range_m: f64) -> f64 {
        if self.is_clear() { 1.0 } else { math::exp(-2.0 * self.alpha_per_m * range_m) }
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
        1.0 - self.wetness * (1.0 - under_water(reflectance, cos_incidence))
    }
}

#[cfg(test)]
mod tests;
