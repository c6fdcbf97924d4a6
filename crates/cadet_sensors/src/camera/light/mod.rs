//! The light of a scene, and the air that it goes through.

mod block_sums;
mod contact_occlusion;
mod night_lights;
mod shadow;
mod sky;
mod sky_visibility;

#[cfg(test)]
pub(super) use contact_occlusion::Occluder;
#[cfg(test)]
pub(super) use night_lights::{
    LEAF_DIRECT_SHARE, LEAF_SCATTERED_SHARE, LEAST_LAMP_ALPHA_SQUARED, LEAST_SQUARE_M2, RETRO_REFLECTANCE, RETRO_SINE,
};
pub(super) use night_lights::{NightLights, WIDE, WideLight, WideSurfaces, add_lamp};
pub(super) use shadow::{PcfTexels, ShadowMaps, ShadowQuery};
pub(super) use sky::Sky;
pub(super) use sky_visibility::SkyProbes;
#[cfg(test)]
pub(super) use sky_visibility::SkyVisibility;

use crate::camera::model::WHITE_BALANCE;
use crate::sense::PosedScene;
use crate::weather::Weather;
use cadet_base::material::NIGHT_LAMP_RADIANCE;
use cadet_base::math::{DVec3, Vec3};

/// All the light of a scene.
#[derive(Debug, Clone)]
pub struct Light {
    /// Sun and sky.
    pub sky: Sky,
    /// The sun's shadows; none under an overcast sky.
    pub shadows: Option<ShadowMaps>,
    /// What hides the sky.
    pub sky_probes: SkyProbes,
    /// 0 is dry, 1 a film of water.
    pub wetness: f32,
    /// Extinction of the air, 1/m.
    pub extinction_per_m: f32,
    /// In-scattered radiance of fog, alike in all directions, and the share of the extinction that is fog's; by day.
    fog: Vec3,
    fog_share: f32,
    /// Cover of snow on level ground, 0..1.
    pub snow_cover: f32,
    /// The lamps of a night; none by day, where they are lost in the light of the sky.
    pub night: Option<NightLights>,
    /// Radiance of what shines of itself, per unit of its color.
    pub lamp_radiance: f32,
}

/// Haze of clear air, 1/m.
const CLEAR_AIR_PER_M: f32 = 0.000_8;
/// The air shows the sky at this sine of an elevation or above, so much darker.
const AIR_SINE: f32 = 0.02;
const AIR_BRIGHTNESS: f32 = 0.8;
/// exp(-x) is taken for (1 + x / n)^-n.
const EXP_POWER: f32 = 16.0;
/// By day lenses have half the radiance of a white wall in the sun, against which lights have to be seen.
const DAY_LAMP_RADIANCE: f32 = 0.55;
/// At night no pixel counts for more in what the lens scatters over all of the image, a white surface under 100 lx; around
/// lamps there are halos ([`crate::camera::overlays`]).
const NIGHT_GLARE_CEILING: f32 = 1.0;

impl Light {
    /// Puts the parts together.
    #[must_use]
    pub fn new(
        weather: &Weather,
        (sky, night): (Sky, Option<NightLights>),
        shadows: Option<ShadowMaps>,
        sky_probes: SkyProbes,
    ) -> Self {
        let extinction_per_m = CLEAR_AIR_PER_M + weather.extinction_per_m() as f32;
        // Droplets scatter all colors alike, and in thick fog light comes to them from the sky and from the ground.
        let from_above = sky.sky_on_level + sky.sun * sky.sun_world.z.max(0.0);
        let white = WHITE_BALANCE.map(|gain| 0.5 * (from_above.y + sky.ground.y) / gain);
        Self {
            fog: white.into(),
            fog_share: if night.is_some() { 0.0 } else { weather.fog_alpha_per_m as f32 / extinction_per_m },
            lamp_radiance: if night.is_some() { NIGHT_LAMP_RADIANCE } else { DAY_LAMP_RADIANCE },
            night,
            sky,
            shadows,
            sky_probes,
            wetness: weather.wetness as f32,
            extinction_per_m,
            snow_cover: weather.snow_cover() as f32,
        }
    }

    /// Sky and lamps over and around an eye.
    #[must_use]
    pub fn sources(scene: &PosedScene, weather: &Weather, eye: DVec3) -> (Sky, Option<NightLights>) {
        if !weather.is_night() {
            return (Sky::new(weather), None);
        }
        let lights = NightLights::new(scene, eye, weather.wetness > 0.0);
        (Sky::at_night(weather, lights.mean_on_ground), Some(lights))
    }

    /// No pixel counts for more in what the lens scatters: by day twice the sky's light on level ground.
    #[must_use]
    pub fn glare_ceiling(&self) -> f32 {
        if self.night.is_some() { NIGHT_GLARE_CEILING } else { 2.0 * self.sky.sky_on_level.y }
    }

    /// The air between: haze, fog, rain.
    #[inline(always)]
    #[must_use]
    pub fn through_air(&self, radiance: Vec3, view_world: Vec3, distance_m: f32) -> Vec3 {
        let t = transmittance(self.extinction_per_m, distance_m);
        radiance * t + self.in_scattered(view_world) * (1.0 - t)
    }

    /// What drops in the air show: half of it is above them, half below.
    #[must_use]
    pub fn around(&self) -> Vec3 {
        0.5 * (self.sky.sky_on_level + self.sky.ground)
    }

    /// In-scattered radiance of the air along a view, were it endless.
    #[inline(always)]
    #[must_use]
    pub fn in_scattered(&self, view_world: Vec3) -> Vec3 {
        let above = Vec3::new(view_world.x, view_world.y, view_world.z.max(AIR_SINE));
        let haze = self.sky.radiance(above) * AIR_BRIGHTNESS;
        haze + (self.fog - haze) * self.fog_share
    }
}

/// Share of the light that the air lets through: exp(-x) by (1 + x/16 + (x/16)^2 / 2)^-16, at most 0.001 too much.
#[inline(always)]
pub(super) fn transmittance(extinction_per_m: f32, distance_m: f32) -> f32 {
    let part = extinction_per_m * distance_m * (1.0 / EXP_POWER);
    let mut t = 1.0 / (1.0 + part * (1.0 + 0.5 * part));
    t *= t;
    t *= t;
    t *= t;
    t * t
}
