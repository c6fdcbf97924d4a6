//! One weather for both sensors.

use crate::error::{Error, Result};
use crate::math::TAU;
use crate::rng::Stream;

/// The state of the air, the sky and the ground.
///
/// Presets by name are CARLA 0.8's fourteen (two suns, seven skies) and four more ([`Weather::NAMES`]).
#[derive(Debug, Clone, PartialEq)]
pub struct Weather {
    /// The preset's name, `"custom"` for others.
    pub name: String,
    /// Height of the sun over the horizon.
    pub sun_elevation_rad: f64,
    /// Direction of the sun, counter-clockwise from east.
    pub sun_azimuth_rad: f64,
    /// 0 is a clear sky, 1 an overcast one without shadows.
    pub cloudiness: f64,
    /// 0 is a dry road, 1 a mirror of water.
    pub wetness: f64,
    /// Rain rate, mm/h.
    pub rain_mm_per_h: f64,
    /// Snow rate, mm/h of water.
    pub snow_mm_per_h: f64,
    /// Attenuation of fog, 1/m (MOR = ln 20 / alpha); 0 is clear.
    pub fog_alpha_per_m: f64,
}

/// (name, cloudiness, wetness, rain mm/h) of the seven skies of CARLA 0.8.
const SKIES: [(&str, f64, f64, f64); 7] = [
    ("clear", 0.1, 0.0, 0.0),
    ("cloudy", 0.7, 0.0, 0.0),
    ("wet", 0.15, 0.6, 0.0),
    ("wet_cloudy", 0.75, 0.6, 0.0),
    ("soft_rain", 0.8, 0.5, 2.0),
    ("mid_rain", 0.9, 0.75, 8.0),
    ("hard_rain", 1.0, 1.0, 25.0),
];

impl Weather {
    /// The presets' names.
    pub const NAMES: [&str; 18] = [
        "clear_noon",
        "cloudy_noon",
        "wet_noon",
        "wet_cloudy_noon",
        "soft_rain_noon",
        "mid_rain_noon",
        "hard_rain_noon",
        "clear_sunset",
        "cloudy_sunset",
        "wet_sunset",
        "wet_cloudy_sunset",
        "soft_rain_sunset",
        "mid_rain_sunset",
        "hard_rain_sunset",
        "light_fog",
        "dense_fog",
        "snow",
        "dusk",
    ];

    /// The preset of that name, its sun in the south; the scene turns the sun by its seed.
    ///
    /// # Errors
    /// [`Error::Unknown`], listing the names that exist.
    pub fn preset(name: &str) -> Result<Self> {
        let mut weather = Self {
            name: name.to_owned(),
            sun_elevation_rad: 35_f64.to_radians(),
            sun_azimuth_rad: (-90_f64).to_radians(),
            cloudiness: 0.1,
            wetness: 0.0,
            rain_mm_per_h: 0.0,
            snow_mm_per_h: 0.0,
            fog_alpha_per_m: 0.0,
        };
        let sky = name.strip_suffix("_noon").or_else(|| name.strip_suffix("_sunset"));
        match (sky.and_then(|s| SKIES.iter().find(|k| k.0 == s)), name) {
            (Some((_, cloudiness, wetness, rain)), _) => {
                weather.cloudiness = *cloudiness;
                weather.wetness = *wetness;
                weather.rain_mm_per_h = *rain;
                if name.ends_with("_sunset") {
                    weather.sun_elevation_rad = 10_f64.to_radians();
                }
            }
            (None, "light_fog") => (weather.cloudiness, weather.fog_alpha_per_m) = (0.9, 0.01),
            (None, "dense_fog") => (weather.cloudiness, weather.fog_alpha_per_m) = (1.0, 0.06),
            (None, "snow") => (weather.cloudiness, weather.snow_mm_per_h) = (1.0, 1.5),
            (None, "dusk") => (weather.cloudiness, weather.sun_elevation_rad) = (0.4, 3_f64.to_radians()),
            _ => {
                return Err(Error::Unknown { what: "weather", name: name.to_owned(), known: Self::NAMES.join(", ") });
            }
        }
        Ok(weather)
    }

    /// The same weather with its sun in a random direction, and a high sun between 20 and 45 degrees (KITTI's hours).
    #[must_use]
    pub fn with_sun_turned(mut self, stream: &mut Stream) -> Self {
        self.sun_azimuth_rad = stream.range(0.0, TAU);
        let height = stream.unit();
        if self.sun_elevation_rad > 15_f64.to_radians() {
            self.sun_elevation_rad = (20.0 + 25.0 * height).to_radians();
        }
        self
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_preset_exists_and_no_other() {
        for name in Weather::NAMES {
            assert_eq!(Weather::preset(name).expect(name).name, name);
        }
        for bad in ["", "clear", "hail_noon", "_noon", "clear_noon "] {
            let text = Weather::preset(bad).expect_err(bad).to_string();
            assert!(text.contains("dense_fog"), "{text}");
        }
    }
}
