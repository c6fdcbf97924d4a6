//! One weather for both sensors.

use cadet_base::error::{Error, Result, finite};
use cadet_base::math::{self, PI, TAU};
use cadet_base::rng::Stream;
use cadet_base::settings::Setting;

/// The state of the air, the sky and the ground.
///
/// Presets by name are CARLA 0.8's fourteen (two suns, seven skies) and seven more ([`Weather::NAMES`]).
#[derive(Debug, Clone, PartialEq)]
pub struct Weather {
    /// The preset's name, `"custom"` for others.
    pub name: String,
    /// Height of the sun over the horizon; below it, it is night.
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
    /// Wind, m/s: drops and flakes go with it.
    pub wind_mps: f64,
}

/// Where a user wants the sun; what is `None` is the weather's or drawn.
#[derive(Debug, Clone, Copy, Default, PartialEq)]
pub struct Sun {
    /// Over the horizon.
    pub elevation_deg: Option<f64>,
    /// Counter-clockwise from east.
    pub azimuth_deg: Option<f64>,
}

impl Sun {
    /// Names and limits.
    #[must_use]
    pub fn settings() -> Vec<Setting> {
        let of = |name, least, most| Setting { name, default: Vec::new(), least, most, is_whole: false };
        vec![of("sun_elevation_deg", 3.0, 90.0), of("sun_azimuth_deg", -360.0, 360.0)]
    }

    /// Checks the angles.
    ///
    /// # Errors
    /// [`Error::OutOfRange`], naming the angle.
    pub fn check(&self) -> Result<()> {
        let angles = [self.elevation_deg, self.azimuth_deg];
        Self::settings().iter().zip(&angles).try_for_each(|(setting, angle)| setting.check(angle.as_slice()))
    }
}

/// How many drops or flakes there are and how large: diameters are exponential.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct SizeDistribution {
    /// Particles of all sizes in a cubic meter.
    pub number_per_m3: f64,
    /// One over the mean diameter, 1/m.
    pub slope_per_m: f64,
}

impl SizeDistribution {
    /// Attenuation of light, 1/m, one way: twice the particles' cross-section, as for all that is much larger than a
    /// wavelength.
    #[must_use]
    pub fn extinction_per_m(&self) -> f64 {
        // The mean square of an exponential diameter is 2 / slope^2.
        PI * self.number_per_m3 / (self.slope_per_m * self.slope_per_m)
    }
}

/// Diameter of a flake over that of the drop it melts to: flakes have a tenth of water's density.
const FLAKE_OVER_DROP: f64 = 2.154_434_690_031_884;
/// Height of the sun below which lamps are lit: 8 degrees.
const LAMPS_BELOW_RAD: f64 = 8.0 * PI / 180.0;
/// Height of the sun at night: 20 degrees below the horizon, where its light is gone.
const NIGHT_SUN_RAD: f64 = -20.0 * PI / 180.0;
/// Share of the ground that is white once snow falls.
const SNOW_COVER: f64 = 0.75;

/// Attenuation of fog, 1/m, through which one sees so far: the meteorological optical range, at which a twentieth of the light
/// of a lamp is left.
#[must_use]
pub fn fog_alpha_per_m(visibility_m: f64) -> f64 {
    math::ln(20.0) / visibility_m
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
    pub const NAMES: [&str; 21] = [
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
        "clear_night",
        "wet_night",
        "rain_night",
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
            wind_mps: 0.0,
        };
        let sky = name.strip_suffix("_noon").or_else(|| name.strip_suffix("_sunset"));
        match (sky.and_then(|s| SKIES.iter().find(|(sky, ..)| *sky == s)), name) {
            (Some((_, cloudiness, wetness, rain)), _) => {
                weather.cloudiness = *cloudiness;
                weather.wetness = *wetness;
                weather.rain_mm_per_h = *rain;
                if name.ends_with("_sunset") {
                    weather.sun_elevation_rad = 10_f64.to_radians();
                }
            }
            (None, "light_fog") => (weather.cloudiness, weather.fog_alpha_per_m) = (0.9, fog_alpha_per_m(300.0)),
            (None, "dense_fog") => (weather.cloudiness, weather.fog_alpha_per_m) = (1.0, fog_alpha_per_m(50.0)),
            (None, "snow") => (weather.cloudiness, weather.snow_mm_per_h) = (1.0, 1.5),
            (None, "dusk") => (weather.cloudiness, weather.sun_elevation_rad) = (0.4, 3_f64.to_radians()),
            (None, "clear_night") => weather.sun_elevation_rad = NIGHT_SUN_RAD,
            (None, "wet_night") => {
                (weather.cloudiness, weather.wetness, weather.sun_elevation_rad) = (0.75, 0.6, NIGHT_SUN_RAD);
            }
            (None, "rain_night") => {
                (weather.cloudiness, weather.wetness, weather.sun_elevation_rad) = (0.9, 0.75, NIGHT_SUN_RAD);
                weather.rain_mm_per_h = 8.0;
            }
            _ => {
                return Err(Error::Unknown { what: "weather", name: name.to_owned(), known: Self::NAMES.join(", ") });
            }
        }
        Ok(weather)
    }

    /// A clear noon with this in its air.
    ///
    /// # Errors
    /// What [`Weather::check`] finds.
    pub fn of_air(fog_alpha_per_m: f64, rain_mm_per_h: f64, snow_mm_per_h: f64, wetness: f64) -> Result<Self> {
        let clear = Self::preset("clear_noon")?;
        let name = "custom".to_owned();
        let weather = Self { name, wetness, rain_mm_per_h, snow_mm_per_h, fog_alpha_per_m, ..clear };
        weather.check()?;
        Ok(weather)
    }

    /// Checks what is in the air, the sky, and on the ground: fog of at most 10 per meter, rain of at most 1000 and snow of at
    /// most 100 mm/h, wetness and clouds of 0 to 1, wind of at most 60 m/s, a sun from 90 degrees below to 90 above the horizon.
    ///
    /// # Errors
    /// [`Error::NotFinite`] or [`Error::OutOfRange`], naming the field.
    pub fn check(&self) -> Result<()> {
        for (what, value, most) in [
            ("fog", self.fog_alpha_per_m, 10.0),
            ("rain", self.rain_mm_per_h, 1000.0),
            ("snow", self.snow_mm_per_h, 100.0),
            ("wetness", self.wetness, 1.0),
            ("cloud_cover", self.cloudiness, 1.0),
            ("wind_mps", self.wind_mps, 60.0),
            ("sun_elevation_deg + 90", self.sun_elevation_rad.to_degrees() + 90.0, 180.0),
        ] {
            if !(0.0..=most).contains(&finite(what, value)?) {
                return Err(Error::OutOfRange { what, value: value.to_string(), expected: format!("0 to {most}") });
            }
        }
        Ok(())
    }

    /// The rain's drops (Marshall and Palmer 1948): 8000 exp(-4.1 rate^-0.21 D) a cubic meter and mm of diameter.
    #[must_use]
    pub fn drops(&self) -> Option<SizeDistribution> {
        (self.rain_mm_per_h > 0.0).then(|| {
            let per_mm = 4.1 * math::pow(self.rain_mm_per_h, -0.21);
            SizeDistribution { number_per_m3: 8000.0 / per_mm, slope_per_m: 1e3 * per_mm }
        })
    }

    /// The snow's flakes (Gunn and Marshall 1958): 3800 rate^-0.87 exp(-2.55 rate^-0.48 D) a cubic meter and mm of the
    /// drop's diameter D that a flake melts to.
    #[must_use]
    pub fn flakes(&self) -> Option<SizeDistribution> {
        (self.snow_mm_per_h > 0.0).then(|| {
            let per_mm = 2.55 * math::pow(self.snow_mm_per_h, -0.48);
            let number_per_m3 = 3800.0 * math::pow(self.snow_mm_per_h, -0.87) / per_mm;
            SizeDistribution { number_per_m3, slope_per_m: 1e3 * per_mm / FLAKE_OVER_DROP }
        })
    }

    /// Attenuation of light by fog, drops and flakes together, 1/m, one way: the camera's and the laser's.
    #[must_use]
    pub fn extinction_per_m(&self) -> f64 {
        let of = |sizes: Option<SizeDistribution>| sizes.map_or(0.0, |s| s.extinction_per_m());
        self.fog_alpha_per_m + of(self.drops()) + of(self.flakes())
    }

    /// Share of the ground under fallen snow.
    #[must_use]
    pub fn snow_cover(&self) -> f64 {
        if self.snow_mm_per_h > 0.0 { SNOW_COVER } else { 0.0 }
    }

    /// Whether lamps are all the light there is: the sun is below the horizon.
    #[must_use]
    pub fn is_night(&self) -> bool {
        self.sun_elevation_rad < 0.0
    }

    /// Whether drivers have their lamps lit: near sunset, and in rain, snow, and fog.
    #[must_use]
    pub fn needs_lamps(&self) -> bool {
        let is_dim = self.sun_elevation_rad < LAMPS_BELOW_RAD;
        is_dim || self.rain_mm_per_h > 0.0 || self.snow_mm_per_h > 0.0 || self.fog_alpha_per_m > 0.0
    }

    /// Turns the sun in a random direction, and puts a high sun between 20 and 45 degrees (KITTI's hours).
    #[must_use]
    pub fn with_sun_turned(mut self, stream: &mut Stream) -> Self {
        self.sun_azimuth_rad = stream.range(0.0, TAU);
        let height = stream.unit();
        if self.sun_elevation_rad > 15_f64.to_radians() {
            self.sun_elevation_rad = (20.0 + 25.0 * height).to_radians();
        }
        self
    }

    /// Puts the sun where a user wants it.
    #[must_use]
    pub fn with_sun(mut self, sun: &Sun) -> Self {
        self.sun_elevation_rad = sun.elevation_deg.map_or(self.sun_elevation_rad, f64::to_radians);
        self.sun_azimuth_rad = sun.azimuth_deg.map_or(self.sun_azimuth_rad, f64::to_radians);
        self
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn lamps_are_lit_at_dusk_and_in_rain_snow_and_fog() {
        let lit = Weather::NAMES.into_iter().filter(|name| Weather::preset(name).expect("known").needs_lamps());
        let wet = ["soft_rain", "mid_rain", "hard_rain"].map(|sky| [format!("{sky}_noon"), format!("{sky}_sunset")]);
        let other =
            ["light_fog", "dense_fog", "snow", "dusk", "clear_night", "wet_night", "rain_night"].map(str::to_owned);
        let expected: std::collections::BTreeSet<String> = wet.into_iter().flatten().chain(other).collect();
        assert_eq!(lit.map(str::to_owned).collect::<std::collections::BTreeSet<_>>(), expected);
    }

    #[test]
    fn rain_and_snow_dim_as_measured() {
        let of = |rain, snow| Weather::of_air(0.0, rain, snow, 0.0).expect("valid").extinction_per_m();
        // Atlas (1953): 1.2 rate^0.63 dB/km for visible light in widespread rain.
        for rate in [1.0, 5.0, 25.0] {
            let atlas = 1.2 * math::pow(rate, 0.63) / 4.343 / 1e3;
            assert!((of(rate, 0.0) / atlas - 1.0).abs() < 0.35, "{rate}: {} {atlas}", of(rate, 0.0));
        }
        // Moderate snow is seen through for 0.5 to 1 km (3 / extinction).
        assert!((500.0..1000.0).contains(&(3.0 / of(0.0, 1.5))), "{}", 3.0 / of(0.0, 1.5));
        assert_eq!(of(0.0, 0.0), 0.0);
        for rates in [[0.1, 1.0], [1.0, 30.0]] {
            assert!(of(rates[0], 0.0) < of(rates[1], 0.0) && of(0.0, rates[0]) < of(0.0, rates[1]));
        }
    }

    #[test]
    fn a_sun_below_the_horizon_is_refused_by_name() {
        let text = |elevation_deg| Sun { elevation_deg, azimuth_deg: None }.check().expect_err("bad").to_string();
        assert!(text(Some(-5.0)).contains("sun_elevation_deg is -5, expected 3 to 90"));
        assert!(text(Some(f64::NAN)).contains("sun_elevation_deg"));
        Sun { elevation_deg: Some(90.0), azimuth_deg: Some(-360.0) }.check().expect("the limits themselves");
    }

    #[test]
    fn impossible_air_is_refused_by_name() {
        let text = |f, r, s, w| Weather::of_air(f, r, s, w).expect_err("bad").to_string();
        assert!(text(-0.1, 0.0, 0.0, 0.0).contains("fog is -0.1, expected 0 to 10"));
        assert!(text(0.0, f64::NAN, 0.0, 0.0).contains("rain is not finite"));
        assert!(text(0.0, 0.0, 101.0, 0.0).contains("snow is 101"));
        assert!(text(0.0, 0.0, 0.0, 1.5).contains("wetness is 1.5"));
    }

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
