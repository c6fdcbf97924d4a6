//! The sun, the sky and the light that falls from them: linear RGB, in units in which a white diffuse surface square to
//! the clear sun shines with about 1.

mod night;

use std::sync::LazyLock;

use crate::camera::surfaces::fbm;
use crate::weather::Weather;
use cadet_base::math::{self, Vec3};

/// Mean albedo of asphalt, paving, and lawns: for the light that comes from below.
const GROUND_ALBEDO: Vec3 = Vec3::new(0.182, 0.181, 0.163);
/// Of the light of the sky and of the sun on open ground, the shares that lit ground shows in reflections: things cast shadows.
const GROUND_SKY_SHARE: f32 = 0.8;
const GROUND_SUN_SHARE: f32 = 0.65;

/// The sun above the air, R, G, B, and the optical depths of the air at the zenith.
const SUN_ABOVE_AIR: [f32; 3] = [1.05, 1.05, 1.08];
const ZENITH_OPTICAL_DEPTHS: [f32; 3] = [0.155, 0.180, 0.215];
/// The sun is taken to stand at least so high, and the air to be so much thinner at the horizon: sines of elevations.
const LEAST_SINE: f32 = 0.02;
const HORIZON_SINE: f32 = 0.02;
/// Fog of this extinction hides the sun, 1/m.
const HIDING_FOG_PER_M: f64 = 0.02;
/// Cloudiness at which the sky begins to be overcast, and is.
const OVERCAST_CLOUDINESS: (f64, f64) = (0.25, 0.75);
/// Irradiance on level ground, with the sun at the horizon and by the sine of its elevation.
const CLEAR_LEVEL: f32 = 0.034;
const CLEAR_LEVEL_BY_SINE: f32 = 0.145;
const OVERCAST_LEVEL: f32 = 0.020;
const OVERCAST_LEVEL_BY_SINE: f32 = 0.330;
/// Colors of the clear sky, relative to each other.
const ZENITH: Vec3 = Vec3::new(0.52, 0.87, 1.31);
const HORIZON: Vec3 = Vec3::new(1.25, 1.51, 1.64);
const GLOW: Vec3 = Vec3::new(5.0, 4.9, 4.6);
/// Brightness of the visible sky over the one that lights the ground, and how much less of that an overcast sky has.
const VISIBLE_OVER_LIGHTING: f32 = 2.2;
const OVERCAST_VISIBLE: f32 = 1.0;
/// R, G, B of a clear sky's light on surfaces.
const SKYLIGHT_TINT: Vec3 = Vec3::new(0.87, 1.0, 1.10);
/// Irradiance of a clear sky on an upright surface over that on level ground, by the cosine to the sun: constant, linear, and
/// square part, and the least one (Threlkeld 1963; ASHRAE's clear sky). More than the sky above gives, by what is bright about the
/// sun and along the horizon.
const UPRIGHT_RATIO: [f32; 3] = [0.55, 0.437, 0.313];
const LEAST_UPRIGHT_RATIO: f32 = 0.45;
const LEAST_UPRIGHT_COS: f32 = -0.2;
/// The sun casts shadows from this irradiance and this sine of its elevation on.
const SHADOW_IRRADIANCE: f32 = 0.004;
const SHADOW_SINE: f32 = 0.01;
/// The glow about the sun: how fast it falls with the angle, as light that haze scatters (Henyey and Greenstein's g = 0.65), and
/// its wide and its narrow part.
const GLOW_FALL: f32 = 4.5;
const WIDE_GLOW: f32 = 0.55;
const NARROW_GLOW: f32 = 0.45;
/// The overcast sky: gray at the horizon and its rise to the zenith (brighter there, as in the CIE's standard), red, and blue.
const GRAY_HORIZON: f32 = 0.36;
const GRAY_RISE: f32 = 0.30;
const GRAY_RED: f32 = 0.985;
const GRAY_BLUE: f32 = 1.03;
/// Clouds lie on a plane, which ends at this sine of an elevation.
const CLOUD_PLANE: f32 = 0.12;
const CLOUD_CELLS: f32 = 1.3;
const CLOUD_SHIFT: [f32; 2] = [40.0, 17.0];
const CLOUD_OCTAVES: u32 = 4;
const CLOUD_SALT: u32 = 0x51C7;
/// An overcast sky has no gaps from here on, but folds: least brightness and contrast.
const CLOSED: f32 = 0.9;
const LEAST_FOLD: f32 = 0.88;
const FOLD_CONTRAST: f32 = 0.24;
/// Clouds begin at this level of the noise without cloudiness, and so much lower with it.
const CLOUDS_FROM: f32 = 0.80;
const CLOUDS_LOWER: f32 = 0.55;
/// How sharp their edges are, how fast they end towards the horizon, and how much of the sky they hide.
const CLOUD_SHARPNESS: f32 = 4.0;
const CLOUD_HORIZON: f32 = 8.0;
const CLOUD_COVER: f32 = 0.85;
/// Light of the sky and of the sun that they scatter, least brightness and contrast.
const CLOUD_SKY: f32 = 1.1;
const CLOUD_SUN: f32 = 0.16;
const LEAST_CLOUD: f32 = 0.9;
const CLOUD_CONTRAST: f32 = 0.2;
/// Mean albedo of what hides the sky, plaster, brick, leaves, fences, cars, with a tenth more for further bounces.
const STANDING_ALBEDO: Vec3 = Vec3::new(0.255, 0.240, 0.200);
/// Of the open sky's and the sun's light on such an upright surface, the shares that reach it between others like it.
const STANDING_SKY_SHARE: f32 = 0.8;
const STANDING_SUN_SHARE: f32 = 0.65;
/// Ground before what hides the sky has this share of the radiance of open ground; under a roof, this one.
const GROUND_BEFORE_WALLS: f32 = 0.8;
const GROUND_UNDER_COVER: f32 = 0.35;
/// The golden angle, radians: directions of a spiral that spread evenly.
const GOLDEN_ANGLE: f32 = 2.399_963_2;

/// Sun and sky of one weather.
#[derive(Debug, Clone)]
pub struct Sky {
    /// Unit vector towards the sun.
    pub sun_world: Vec3,
    /// Irradiance of the sun on a surface square to it; zero under an overcast sky.
    pub sun: Vec3,
    /// Irradiance of the whole sky on open level ground.
    pub sky_on_level: Vec3,
    /// Radiance of sunlit open ground, as seen in reflections.
    pub ground: Vec3,
    zenith: Vec3,
    horizon: Vec3,
    glow: Vec3,
    overcast: f32,
    cloudiness: f32,
    /// Irradiance on surfaces that face +x, -x, +y, -y, +z, -z where all of the sky is hidden, and how much more it is in
    /// the open.
    hidden: [Vec3; 6],
    more_in_open: [Vec3; 6],
}

impl Sky {
    /// The sky of a weather.
    #[must_use]
    pub fn new(weather: &Weather) -> Self {
        let (elevation, azimuth) = (weather.sun_elevation_rad, weather.sun_azimuth_rad);
        let (sin_e, cos_e) = (math::sin(elevation) as f32, math::cos(elevation) as f32);
        let sun_world =
            Vec3::new(cos_e * math::cos(azimuth) as f32, cos_e * math::sin(azimuth) as f32, sin_e).normalize();
        let sin_e = sin_e.max(LEAST_SINE);
        let falling = f64::from(u8::from(weather.rain_mm_per_h + weather.snow_mm_per_h > 0.0));
        let fog = math::smoothstep(0.0, HIDING_FOG_PER_M, weather.fog_alpha_per_m);
        let (open, closed) = OVERCAST_CLOUDINESS;
        let overcast = math::smoothstep(open, closed, weather.cloudiness).max(fog).max(falling) as f32;
        // Air turns the low sun red: the blue is scattered out first.
        let air = |tau: f32| math::expf(-tau / (sin_e + HORIZON_SINE));
        let [red, green, blue] = [0, 1, 2].map(|k| SUN_ABOVE_AIR[k] * air(ZENITH_OPTICAL_DEPTHS[k]));
        let sun = Vec3::new(red, green, blue) * (1.0 - overcast);
        let clear_level = CLEAR_LEVEL + CLEAR_LEVEL_BY_SINE * sin_e;
        let overcast_level = OVERCAST_LEVEL + OVERCAST_LEVEL_BY_SINE * sin_e;
        let level = math::lerp(f64::from(clear_level), f64::from(overcast_level), f64::from(overcast)) as f32;
        let mut sky = Self {
            sun_world,
            sun,
            sky_on_level: Vec3::ZERO,
            ground: Vec3::ZERO,
            zenith: ZENITH,
            horizon: HORIZON,
            glow: GLOW,
            overcast,
            cloudiness: weather.cloudiness as f32,
            hidden: [Vec3::ZERO; 6],
            more_in_open: [Vec3::ZERO; 6],
        };
        // The shapes above are relative. Measured skies are brighter against lit asphalt than the light that reaches the
        // ground of a street: what stands about hides their brightest part, the horizon.
        let scale = (VISIBLE_OVER_LIGHTING - OVERCAST_VISIBLE * overcast) * level / sky.irradiance(Vec3::Z).y;
        for c in [&mut sky.zenith, &mut sky.horizon, &mut sky.glow] {
            *c *= scale;
        }
        // Distant walls and the camera's gains make the skylight on surfaces less blue than the sky itself.
        let open = sky.irradiance(Vec3::Z);
        let clear_gains = SKYLIGHT_TINT * level / open;
        let gains = clear_gains + (Vec3::splat(level / open.y) - clear_gains) * overcast;
        sky.sky_on_level = open * gains;
        sky.ground = GROUND_ALBEDO * (sky.sky_on_level * GROUND_SKY_SHARE + sky.sun * (sin_e * GROUND_SUN_SHARE));
        let shapes = sky.irradiances(HALF_AXES);
        let open = std::array::from_fn(|k| {
            let (n, shape) = (HALF_AXES[k], shapes[k] * gains);
            if n.z == 0.0 { shape + (sky.clear_on_upright(n) - shape) * (1.0 - overcast) } else { shape }
        });
        sky.hidden = sky.irradiance_between_walls(&open);
        sky.more_in_open = std::array::from_fn(|k| open[k] - sky.hidden[k]);
        sky
    }

    /// True if the sun casts shadows.
    #[must_use]
    pub fn has_shadows(&self) -> bool {
        self.sun.y > SHADOW_IRRADIANCE && self.sun_world.z > SHADOW_SINE
    }

    /// Smooth radiance of the sky without clouds' edges or the sun's disk; below the horizon, of the ground.
    #[inline(always)]
    #[must_use]
    pub fn radiance(&self, direction: Vec3) -> Vec3 {
        let up = direction.z;
        let low = 1.0 - up;
        let low2 = low * low;
        let gradient = self.zenith + (self.horizon - self.zenith) * (low2 * low2);
        let q = 1.0 / (1.0 + GLOW_FALL * (1.0 - direction.dot(self.sun_world)));
        let q2 = q * q;
        let clear = gradient + self.glow * (q2 * (WIDE_GLOW + NARROW_GLOW * q2));
        let gray = (self.zenith.y + self.horizon.y) * (GRAY_HORIZON + GRAY_RISE * up);
        let covered = Vec3::new(gray * GRAY_RED, gray, gray * GRAY_BLUE);
        let sky = clear + (covered - clear) * self.overcast;
        let is_up = up >= 0.0;
        Vec3::new(
            if is_up { sky.x } else { self.ground.x },
            if is_up { sky.y } else { self.ground.y },
            if is_up { sky.z } else { self.ground.z },
        )
    }

    /// The sky as the camera sees it: with clouds.
    #[inline(always)]
    #[must_use]
    pub fn visible_radiance(&self, direction: Vec3) -> Vec3 {
        let base = self.radiance(direction);
        let up = direction.z.max(0.0);
        let over = 1.0 / (up + CLOUD_PLANE);
        let (x, y) = (direction.x * over, direction.y * over);
        let puffs = fbm(x * CLOUD_CELLS + CLOUD_SHIFT[0], y * CLOUD_CELLS - CLOUD_SHIFT[1], CLOUD_OCTAVES, CLOUD_SALT);
        let sky = if self.overcast > CLOSED {
            base * (LEAST_FOLD + FOLD_CONTRAST * puffs)
        } else {
            let from = CLOUDS_FROM - CLOUDS_LOWER * self.cloudiness;
            let cover =
                ((puffs - from) * CLOUD_SHARPNESS).clamp(0.0, 1.0) * (up * CLOUD_HORIZON).min(1.0) * CLOUD_COVER;
            let lit = self.sky_on_level * CLOUD_SKY + self.sun * CLOUD_SUN;
            let white = Vec3::splat(lit.y) * (LEAST_CLOUD + CLOUD_CONTRAST * puffs);
            base + (white - base).max(Vec3::ZERO) * cover
        };
        let is_up = direction.z >= 0.0;
        Vec3::new(
            if is_up { sky.x } else { base.x },
            if is_up { sky.y } else { base.y },
            if is_up { sky.z } else { base.z },
        )
    }

    /// Light on a surface of the sky, of the ground, and of what hides the sky, by its unit normal and its sky visibility.
    #[inline(always)]
    #[must_use]
    pub fn ambient(&self, normal: Vec3, visibility: &[f32; 6]) -> Vec3 {
        // Of each axis the half that the normal faces; the other one counts nothing.
        let square = |v: f32| v.max(0.0) * v.max(0.0);
        let along = |k: usize, share: f32| (self.hidden[k] + self.more_in_open[k] * visibility[k]) * share;
        let n = normal;
        along(0, square(n.x))
            + along(1, square(-n.x))
            + along(2, square(n.y))
            + along(3, square(-n.y))
            + along(4, square(n.z))
            + along(5, square(-n.z))
    }

    /// Irradiance of a clear sky and of open ground on an upright surface.
    fn clear_on_upright(&self, normal: Vec3) -> Vec3 {
        let cos_sun = normal.dot(self.sun_world);
        let [constant, linear, square] = UPRIGHT_RATIO;
        let ratio = constant + linear * cos_sun + square * cos_sun * cos_sun;
        let ratio = if cos_sun < LEAST_UPRIGHT_COS { LEAST_UPRIGHT_RATIO } else { ratio };
        self.sky_on_level * ratio + self.ground * 0.5
    }

    /// Irradiance on surfaces along the six half axes before which walls hide all of the sky, one bounce of light; `open` is
    /// that without walls. What faces away from the sun looks at sunlit walls, what faces it at shaded ones.
    fn irradiance_between_walls(&self, open: &[Vec3; 6]) -> [Vec3; 6] {
        let [x, y] = [self.sun_world.x, self.sun_world.y];
        // A wall that one sees toward +x faces -x.
        let walls = [(open[1], -x), (open[0], x), (open[3], -y), (open[2], y)].map(|(sky, cos_sun)| {
            STANDING_ALBEDO * (sky * STANDING_SKY_SHARE + self.sun * (cos_sun.max(0.0) * STANDING_SUN_SHARE))
        });
        let mean = (walls[0] + walls[1] + walls[2] + walls[3]) * 0.25;
        // The lower half of what a wall sees is ground.
        let [a, b, c, d] = walls.map(|wall| (wall + self.ground * GROUND_BEFORE_WALLS) * 0.5);
        [a, b, c, d, mean, self.ground * GROUND_UNDER_COVER]
    }

    /// Cosine-weighted mean radiance about a normal.
    fn irradiance(&self, normal: Vec3) -> Vec3 {
        self.irradiances([normal])[0]
    }

    /// Cosine-weighted mean radiance about normals, by a fixed spiral of directions.
    fn irradiances<const N: usize>(&self, normals: [Vec3; N]) -> [Vec3; N] {
        let mut sums = [Vec3::ZERO; N];
        for direction in SPIRAL.iter() {
            let radiance = self.radiance(*direction);
            for (sum, normal) in sums.iter_mut().zip(normals) {
                *sum += radiance * direction.dot(normal).max(0.0);
            }
        }
        sums.map(|sum| sum * (4.0 / NUM_DIRECTIONS as f32))
    }
}

/// The half axes, in the order of [`Sky::ambient`].
const HALF_AXES: [Vec3; 6] = [Vec3::X, Vec3::NEG_X, Vec3::Y, Vec3::NEG_Y, Vec3::Z, Vec3::NEG_Z];
const NUM_DIRECTIONS: usize = 1024;
/// Directions all around.
static SPIRAL: LazyLock<[Vec3; NUM_DIRECTIONS]> = LazyLock::new(|| {
    std::array::from_fn(|i| {
        let z = 1.0 - (2.0 * i as f32 + 1.0) / NUM_DIRECTIONS as f32;
        let r = (1.0 - z * z).max(0.0).sqrt();
        let turn = i as f32 * GOLDEN_ANGLE;
        Vec3::new(r * math::cosf(turn), r * math::sinf(turn), z)
    })
});

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_clear_sun_outshines_the_sky_three_to_five_times_and_warmer() {
        for degrees in [22.0, 35.0, 45.0_f64] {
            let mut weather = Weather::preset("clear_noon").unwrap();
            weather.sun_elevation_rad = degrees.to_radians();
            let sky = Sky::new(&weather);
            let direct = sky.sun * sky.sun_world.z;
            let ratio = direct.y / sky.sky_on_level.y;
            assert!((2.8..5.5).contains(&ratio), "{degrees}: {ratio}");
            let shaded = sky.sky_on_level.x / sky.sky_on_level.z;
            let lit = (direct.x + sky.sky_on_level.x) / (direct.z + sky.sky_on_level.z);
            assert!((0.76..0.90).contains(&shaded), "{shaded}");
            assert!((0.97..1.08).contains(&lit), "{degrees} {lit}");
        }
    }

    #[test]
    fn overcast_and_rain_have_no_sun() {
        for name in ["hard_rain_noon", "soft_rain_noon", "dense_fog", "snow"] {
            let sky = Sky::new(&Weather::preset(name).unwrap());
            assert!(!sky.has_shadows(), "{name}");
            assert!(sky.sky_on_level.y > 0.05);
        }
    }

    #[test]
    fn the_ambient_cube_agrees_with_the_integral_under_clouds_on_its_axes_and_between() {
        let sky = Sky::new(&Weather::preset("hard_rain_noon").unwrap());
        for n in [Vec3::Z, Vec3::X, Vec3::new(0.6, 0.0, 0.8), Vec3::new(0.0, -0.8, 0.6)] {
            let exact = sky.sky_on_level.y * sky.irradiance(n).y / sky.irradiance(Vec3::Z).y;
            let cube = sky.ambient(n, &[1.0; 6]).y;
            assert!((cube - exact).abs() < 0.25 * exact, "{n}: {cube} {exact}");
        }
    }

    #[test]
    fn open_walls_get_of_a_clear_sky_what_was_measured() {
        let mut weather = Weather::preset("clear_noon").unwrap();
        (weather.sun_azimuth_rad, weather.sun_elevation_rad, weather.cloudiness) = (0.0, 40.0_f64.to_radians(), 0.0);
        let sky = Sky::new(&weather);
        // Threlkeld's curve at cosines of 0.766, 0, and -0.766, and half of the ground.
        for (n, ratio) in [(Vec3::X, 1.068), (Vec3::Y, 0.55), (-Vec3::Y, 0.55), (-Vec3::X, 0.45)] {
            let of_sky = sky.ambient(n, &[1.0; 6]).y - 0.5 * sky.ground.y;
            assert!((of_sky / sky.sky_on_level.y - ratio).abs() < 0.01, "{n}: {of_sky}");
        }
        // A wall in its own shade has a sixth to a fourth of the light of the sunlit one behind it.
        let (shaded, sunlit) = (sky.ambient(-Vec3::X, &[1.0; 6]), sky.ambient(Vec3::X, &[1.0; 6]) + sky.sun * 0.766);
        assert!((4.0..9.0).contains(&(sunlit.y / shaded.y)), "{sunlit} {shaded}");
    }

    #[test]
    fn a_shaded_wall_is_lit_by_the_sunlit_one_across_the_street() {
        let mut weather = Weather::preset("clear_noon").unwrap();
        weather.sun_azimuth_rad = 0.0;
        let sky = Sky::new(&weather);
        let (shaded, sunward) = (sky.ambient(-Vec3::X, &[0.0; 6]), sky.ambient(Vec3::X, &[0.0; 6]));
        // By hand, green, with the sun in the east: half of what the shaded wall sees is the wall across the street, half the
        // ground before it.
        let across = 0.240 * (0.8 * sky.ambient(Vec3::X, &[1.0; 6]).y + 0.65 * sky.sun.y * sky.sun_world.x);
        assert!((shaded.y - 0.5 * (across + 0.8 * sky.ground.y)).abs() < 1e-6, "{shaded}");
        assert!(shaded.y > 1.8 * sunward.y, "{shaded} {sunward}");
        // Less than the sun, more than nothing, and the north and the south alike.
        assert!(shaded.y < 0.25 * sky.sun.y);
        let [north, south] = [Vec3::Y, -Vec3::Y].map(|n| sky.ambient(n, &[0.0; 6]).y);
        assert!((north - south).abs() < 0.02 * north, "{north} {south}");
        // Half open is halfway.
        let [none, half, all] = [0.0, 0.5, 1.0].map(|v| sky.ambient(-Vec3::X, &[v; 6]).y);
        assert!((half - 0.5 * (none + all)).abs() < 1e-6);
    }
}
