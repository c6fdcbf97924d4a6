//! The sky at night: the glow of a town, and what lit streets send back.

use super::{
    GROUND_ALBEDO, GROUND_BEFORE_WALLS, GROUND_UNDER_COVER, HALF_AXES, OVERCAST_CLOUDINESS, STANDING_ALBEDO, Sky,
};
use crate::weather::Weather;
use cadet_base::math::{self, Vec3};

/// Radiances of the clear sky over a town in units of 31.8 cd/m² (at night a white surface under 100 lx has 1): 9 mcd/m² at the
/// zenith, 80 at the horizon, and a dome of light over the town's middle.
const ZENITH: Vec3 = Vec3::new(2.6e-4, 2.9e-4, 3.7e-4);
const HORIZON: Vec3 = Vec3::new(2.9e-3, 2.4e-3, 2.0e-3);
const DOME: Vec3 = Vec3::new(7.0e-3, 5.2e-3, 3.6e-3);
/// The glow over open country as a share of that over a town, whose ground gets 3 lx of its lamps in the mean.
const DARKEST: f32 = 0.25;
const LIT_TOWN: f32 = 0.03;
/// Clouds throw back so many times the light of a clear sky.
const CLOUDY_OVER_CLEAR: f32 = 3.0;
/// Of the mean light of lamps on the ground, what reaches upright surfaces.
const LAMPS_ON_WALLS: f32 = 0.4;
const SKY_ON_GROUND: f32 = 0.8;

impl Sky {
    /// The sky of a night; `lamps`: mean irradiance of lamps on the ground around.
    #[must_use]
    pub fn at_night(weather: &Weather, lamps: Vec3) -> Self {
        let azimuth = weather.sun_azimuth_rad;
        let (open, closed) = OVERCAST_CLOUDINESS;
        let overcast = math::smoothstep(open, closed, weather.cloudiness) as f32;
        let town = (DARKEST + lamps.y / LIT_TOWN).min(1.0);
        let brightness = town * (1.0 + (CLOUDY_OVER_CLEAR - 1.0) * overcast);
        let mut sky = Self {
            // Where the town's middle lies; there is no sun.
            sun_world: Vec3::new(math::cos(azimuth) as f32, math::sin(azimuth) as f32, 0.0),
            sun: Vec3::ZERO,
            sky_on_level: Vec3::ZERO,
            ground: Vec3::ZERO,
            zenith: ZENITH * brightness,
            horizon: HORIZON * brightness,
            glow: DOME * brightness,
            overcast,
            cloudiness: weather.cloudiness as f32,
            hidden: [Vec3::ZERO; 6],
            more_in_open: [Vec3::ZERO; 6],
        };
        sky.sky_on_level = sky.irradiance(Vec3::Z);
        sky.ground = GROUND_ALBEDO * (sky.sky_on_level * SKY_ON_GROUND + lamps);
        let open = sky.irradiances(HALF_AXES);
        let wall = STANDING_ALBEDO * (sky.sky_on_level * 0.5 + lamps * LAMPS_ON_WALLS);
        let beside = (wall + sky.ground * GROUND_BEFORE_WALLS) * 0.5;
        sky.hidden = [beside, beside, beside, beside, wall, sky.ground * GROUND_UNDER_COVER];
        sky.more_in_open = std::array::from_fn(|k| open[k] - sky.hidden[k]);
        sky
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_night_is_ten_thousand_times_darker_than_noon_and_brighter_at_the_horizon() {
        let of = |name: &str| Weather::preset(name).unwrap();
        let (noon, night) = (Sky::new(&of("clear_noon")), Sky::at_night(&of("clear_night"), Vec3::ZERO));
        // The unit is a thousandth of the day's.
        assert!(noon.sky_on_level.y > 1e4 * night.sky_on_level.y * 1e-3);
        let level = Vec3::new(0.0, 1.0, 0.05).normalize();
        assert!(night.radiance(level).y > 3.0 * night.radiance(Vec3::Z).y);
        assert!(!night.has_shadows());
        let cloudy = Sky::at_night(&of("wet_night"), Vec3::ZERO);
        assert!(cloudy.sky_on_level.y > 1.5 * night.sky_on_level.y);
    }

    #[test]
    fn lit_streets_light_what_is_under_no_sky() {
        let weather = Weather::preset("clear_night").unwrap();
        let [dark, lit] = [0.0, 0.05].map(|lamps| Sky::at_night(&weather, Vec3::splat(lamps)));
        // One bounce by hand, green: half of it wall, half ground.
        for (sky, lamps) in [(&dark, 0.0), (&lit, 0.05)] {
            let above = sky.sky_on_level.y;
            let bounce = 0.5 * (0.240 * (0.5 * above + 0.4 * lamps) + 0.8 * 0.181 * (0.8 * above + lamps));
            assert!((sky.ambient(Vec3::X, &[0.0; 6]).y / bounce - 1.0).abs() < 1e-4);
        }
        assert!(lit.ambient(Vec3::X, &[0.0; 6]).y > 10.0 * dark.ambient(Vec3::X, &[0.0; 6]).y);
    }
}
