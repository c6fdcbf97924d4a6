//! The sun, the sky and the light that falls from them: linear RGB, in units in which a white diffuse surface square to
//! the clear sun shines with about 1.

use super::pattern::fbm;
use crate::math::{self, Vec3};
use crate::weather::Weather;

/// Mean albedo of what lies about: for the light that comes from below.
const GROUND_ALBEDO: Vec3 = Vec3::new(0.150, 0.150, 0.140);

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
    /// Irradiance on surfaces that face +x, -x, +y, -y, +z, -z in the open.
    cube: [Vec3; 6],
}

impl Sky {
    /// The sky of a weather.
    #[must_use]
    pub fn new(weather: &Weather) -> Self {
        let (elevation, azimuth) = (weather.sun_elevation_rad, weather.sun_azimuth_rad);
        let (sin_e, cos_e) = (math::sin(elevation) as f32, math::cos(elevation) as f32);
        let sun_world =
            Vec3::new(cos_e * math::cos(azimuth) as f32, cos_e * math::sin(azimuth) as f32, sin_e).normalize();
        let sin_e = sin_e.max(0.02);
        let falling = f64::from(u8::from(weather.rain_mm_per_h + weather.snow_mm_per_h > 0.0));
        let fog = math::smoothstep(0.0, 0.02, weather.fog_alpha_per_m);
        let overcast = math::smoothstep(0.25, 0.75, weather.cloudiness).max(fog).max(falling) as f32;
        // Air turns the low sun red: the blue is scattered out first.
        let air = |tau: f32| math::expf(-tau / (sin_e + 0.02));
        let sun = Vec3::new(1.05 * air(0.155), 1.05 * air(0.180), 1.08 * air(0.215)) * (1.0 - overcast);
        let clear_level = 0.034 + 0.145 * sin_e;
        let overcast_level = 0.020 + 0.330 * sin_e;
        let level = math::lerp(f64::from(clear_level), f64::from(overcast_level), f64::from(overcast)) as f32;
        let mut sky = Self {
            sun_world,
            sun,
            sky_on_level: Vec3::ZERO,
            ground: Vec3::ZERO,
            zenith: Vec3::new(0.46, 0.84, 1.36),
            horizon: Vec3::new(1.15, 1.50, 1.68),
            glow: Vec3::new(5.0, 4.9, 4.6),
            overcast,
            cloudiness: weather.cloudiness as f32,
            cube: [Vec3::ZERO; 6],
        };
        // The shapes above are relative. Measured skies are brighter against lit asphalt than the light that reaches the
        // ground of a street: what stands about hides their brightest part, the horizon.
        let scale = (1.7 - 0.5 * overcast) * level / sky.irradiance(Vec3::Z).y;
        for c in [&mut sky.zenith, &mut sky.horizon, &mut sky.glow] {
            *c *= scale;
        }
        // Distant walls and the camera's gains make the skylight on surfaces less blue than the sky itself.
        let open = sky.irradiance(Vec3::Z);
        let clear_gains = Vec3::new(0.90, 1.0, 1.09) * level / open;
        let gains = clear_gains + (Vec3::splat(level / open.y) - clear_gains) * overcast;
        sky.sky_on_level = sky.irradiance(Vec3::Z) * gains;
        sky.ground = GROUND_ALBEDO * (sky.sky_on_level * 0.8 + sky.sun * (sin_e * 0.65));
        sky.cube = [Vec3::X, -Vec3::X, Vec3::Y, -Vec3::Y, Vec3::Z, -Vec3::Z].map(|n| sky.irradiance(n) * gains);
        sky
    }

    /// True if the sun casts shadows.
    #[must_use]
    pub fn has_shadows(&self) -> bool {
        self.sun.y > 0.004 && self.sun_world.z > 0.01
    }

    /// Smooth radiance of the sky without clouds' edges or the sun's disk; below the horizon, of the ground.
    #[inline(always)]
    #[must_use]
    pub fn radiance(&self, direction: Vec3) -> Vec3 {
        let up = direction.z;
        let low = 1.0 - up;
        let low2 = low * low;
        let gradient = self.zenith + (self.horizon - self.zenith) * (low2 * low2);
        let q = 1.0 / (1.0 + 6.0 * (1.0 - direction.dot(self.sun_world)));
        let q2 = q * q;
        let clear = gradient + self.glow * (q2 * (0.55 + 0.45 * q2));
        let gray = (self.zenith.y + self.horizon.y) * (0.36 + 0.30 * up);
        let covered = Vec3::new(gray * 0.985, gray, gray * 1.03);
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
        let over = 1.0 / (up + 0.12);
        let (x, y) = (direction.x * over, direction.y * over);
        let puffs = fbm(x * 1.3 + 40.0, y * 1.3 - 17.0, 4, 0x51C7);
        let sky = if self.overcast > 0.9 {
            base * (0.88 + 0.24 * puffs)
        } else {
            let from = 0.80 - 0.55 * self.cloudiness;
            let cover = ((puffs - from) * 4.0).clamp(0.0, 1.0) * (up * 8.0).min(1.0) * 0.85;
            let lit = self.sky_on_level * 1.1 + self.sun * 0.16;
            let white = Vec3::splat(lit.y) * (0.9 + 0.2 * puffs);
            base + (white - base).max(Vec3::ZERO) * cover
        };
        let is_up = direction.z >= 0.0;
        Vec3::new(
            if is_up { sky.x } else { base.x },
            if is_up { sky.y } else { base.y },
            if is_up { sky.z } else { base.z },
        )
    }

    /// Light of sky and ground on a surface, by its unit normal and its sky visibility.
    #[inline(always)]
    #[must_use]
    pub fn ambient(&self, normal: Vec3, visibility: &[f32; 6]) -> Vec3 {
        // Of each axis the half that the normal faces; the other one counts nothing.
        let square = |v: f32| v.max(0.0) * v.max(0.0);
        let n = normal;
        self.cube[0] * (square(n.x) * visibility[0])
            + self.cube[1] * (square(-n.x) * visibility[1])
            + self.cube[2] * (square(n.y) * visibility[2])
            + self.cube[3] * (square(-n.y) * visibility[3])
            + self.cube[4] * (square(n.z) * visibility[4])
            + self.cube[5] * (square(-n.z) * visibility[5])
    }

    /// As [`Sky::ambient`], with what comes from that which hides the sky: sunlit walls and ground.
    #[inline(always)]
    #[must_use]
    pub fn ambient_with_bounce(&self, normal: Vec3, visibility: &[f32; 6]) -> Vec3 {
        let mean_visibility = (visibility[0] + visibility[1] + visibility[2] + visibility[3] + visibility[4]) * 0.2;
        self.ambient(normal, visibility) + self.ground * (0.60 * (1.0 - mean_visibility))
    }

    /// Cosine-weighted mean radiance about a normal, by a fixed spiral of directions.
    fn irradiance(&self, normal: Vec3) -> Vec3 {
        const N: usize = 1024;
        let mut sum = Vec3::ZERO;
        for i in 0..N {
            let z = 1.0 - (2.0 * i as f32 + 1.0) / N as f32;
            let r = (1.0 - z * z).max(0.0).sqrt();
            let turn = i as f32 * 2.399_963_2;
            let d = Vec3::new(r * math::cosf(turn), r * math::sinf(turn), z);
            sum += self.radiance(d) * d.dot(normal).max(0.0);
        }
        sum * (4.0 / N as f32)
    }
}

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
    fn the_ambient_cube_agrees_with_the_integral_on_its_axes_and_between() {
        let sky = Sky::new(&Weather::preset("clear_noon").unwrap());
        for n in [Vec3::Z, Vec3::X, Vec3::new(0.6, 0.0, 0.8), Vec3::new(0.0, -0.8, 0.6)] {
            let exact = sky.sky_on_level.y * sky.irradiance(n).y / sky.irradiance(Vec3::Z).y;
            let cube = sky.ambient(n, &[1.0; 6]).y;
            assert!((cube - exact).abs() < 0.25 * exact, "{n}: {cube} {exact}");
        }
    }
}
