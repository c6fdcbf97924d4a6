//! A picture of a posed scene: color from two samples a pixel, depth and identity from the pixels' centers.

use std::cell::RefCell;

use super::bloom::add_halos;
use super::development::Development;
use super::distortion::Warp;
use super::exposure::{Exposure, WHITE_BALANCE, gain_at_night, gain_for_mean_luma, metered, night_gain};
use super::lens_drops::LensDrops;
use super::light::Light;
use super::maps::Maps;
use super::noise::{ROWS_BEFORE, blur, expose};
use super::precipitation::Precipitation;
use super::radiance_pass::{radiance_pass, room_for};
use super::shadow::ShadowMaps;
use super::sky_visibility::SkyProbes;
use super::spray;
use super::visibility_pass::{ImageRays, View, Visibility, visible_points};
use crate::sense::PosedScene;
use crate::spray::Spray;
use crate::weather::Weather;
use cadet_base::math::{DVec3, Vec3};
use cadet_base::rng::Stream;

/// What the camera writes.
#[derive(Debug, Clone, PartialEq)]
pub struct Rendered {
    /// RGB, 8 bits, by the camera's response to light, row-major.
    pub image: Vec<u8>,
    /// Depth and identity, if asked for.
    pub maps: Option<Maps>,
    /// Light in shares of white, interleaved RGB, if asked for.
    pub radiance: Option<Vec<f32>>,
}

/// Share of the mean radiance that lens and housing scatter over the image; see [`Light::glare_ceiling`].
const VEILING_GLARE: f32 = 0.016;
/// Mean luma that the exposure aims at, and its spread from frame to frame.
const MEAN_LUMA: (f64, f64) = (92.0, 4.5);
/// Mean luma that the exposure aims at by night, which is to stay dark, and its spread from frame to frame.
const NIGHT_MEAN_LUMA: (f64, f64) = (27.0, 2.0);
/// Every so many pixels one is metered: a prime number, so that no column is.
const METERED_STEP: usize = 37;

/// Memory that a thread keeps from frame to frame: touching fresh pages costs as much as the casting.
#[derive(Default)]
pub(super) struct Scratch {
    visible_world: Vec<Vec3>,
    pub rgb: Vec<f32>,
    shadows: Vec<Vec<i16>>,
}

impl Scratch {
    /// Keeps the memory of the shadow maps.
    pub fn reuse(&mut self, light: Light) {
        self.shadows = light.shadows.map(ShadowMaps::into_buffers).unwrap_or_default();
    }
}

thread_local! {
    static SCRATCH: RefCell<Scratch> = RefCell::default();
}

/// Everything between the scene and the sensor.
#[derive(Debug, Clone, Default)]
pub struct Foreground<'a> {
    /// What vehicles throw up behind them.
    pub spray: Spray,
    /// What falls through the view, one by one.
    pub precipitation: Option<Precipitation>,
    /// Drops on the lens.
    pub lens_drops: LensDrops,
    /// A lens that bends the image: it takes it from the view's, before the sensor's noise.
    pub warp: Option<&'a Warp>,
    /// How values are made of the light.
    pub development: Development,
    /// Whether the light itself is wanted, beside the image.
    pub with_radiance: bool,
}

/// Shades what is visible, exposes it, and adds the sensor's noise: RGB, 8 bits, row-major.
///
/// # Determinism
/// A function of its arguments; one thread. `stream` feeds the exposure and the noise alone.
#[must_use]
pub fn render(scene: &PosedScene, view: &View, weather: &Weather, seen: &Visibility, stream: &mut Stream) -> Vec<u8> {
    render_through(scene, view, weather, seen, &Foreground::default(), stream).image
}

/// Renders as [`render()`] does, through what is between scene and sensor; without maps.
#[must_use]
pub fn render_through(
    scene: &PosedScene,
    view: &View,
    weather: &Weather,
    seen: &Visibility,
    foreground: &Foreground<'_>,
    stream: &mut Stream,
) -> Rendered {
    let (width, height) = (view.width, view.height);
    let mut scratch = SCRATCH.take();
    let light = radiance(scene, view, weather, seen, &mut scratch);
    let rgb = &mut scratch.rgb[ROWS_BEFORE * width * 3..];
    spray::draw(&foreground.spray, rgb, view, seen, &light);
    if let Some(precipitation) = &foreground.precipitation {
        precipitation.draw(rgb, view, seen, &light);
    }
    foreground.lens_drops.draw(rgb, view);
    // Lens and housing scatter a share of the light over the whole image: shadows are never fully black.
    let sums = blur(&mut scratch.rgb, width, height, light.glare_ceiling());
    let blurred = &mut scratch.rgb[..width * height * 3];
    let is_night = light.night.is_some();
    if is_night {
        add_halos(blurred, width, height);
    }
    let exposed = exposure(blurred, sums, is_night, &foreground.development, stream);
    let mut develop = |rgb: &[f32], (width, height)| Rendered {
        image: expose(rgb, width, height, &exposed, &foreground.development, stream),
        maps: None,
        radiance: foreground.with_radiance.then(|| exposed.light(rgb)),
    };
    let rendered = match foreground.warp {
        None => develop(blurred, (width, height)),
        Some(warp) => develop(&warp.colors(blurred), warp.image_size()),
    };
    scratch.reuse(light);
    SCRATCH.set(scratch);
    rendered
}

/// How an image is exposed. `radiance_sums` are those of [`blur`].
pub(super) fn exposure(
    blurred_rgb: &[f32],
    radiance_sums: [f64; 3],
    is_night: bool,
    development: &Development,
    stream: &mut Stream,
) -> Exposure {
    let num_pixels = (blurred_rgb.len() / 3) as f64;
    let veil = radiance_sums.map(|s| (f64::from(VEILING_GLARE) * s / num_pixels) as f32);
    let (mean, deviation) = if is_night { NIGHT_MEAN_LUMA } else { MEAN_LUMA };
    let target = development.response.metered(stream.clipped_normal(mean, deviation) as f32);
    let metered = metered(blurred_rgb, veil, METERED_STEP);
    let (gain, amplification) = if is_night {
        night_gain(gain_at_night(&metered, target))
    } else {
        (gain_for_mean_luma(&metered, target, 1), 1.0)
    };
    let gain = gain * development.exposure;
    let gains = std::array::from_fn(|k| WHITE_BALANCE[k] * gain * development.white_balance[k]);
    Exposure { veil, gains, amplification }
}

/// Linear radiance of every pixel, interleaved RGB, into `scratch.rgb` from the row [`ROWS_BEFORE`] on; returns the light.
pub(super) fn radiance(
    scene: &PosedScene,
    view: &View,
    weather: &Weather,
    seen: &Visibility,
    scratch: &mut Scratch,
) -> Light {
    let rays = ImageRays::new(view);
    visible_points(&rays, &seen.samples, &mut scratch.visible_world);
    let light = light_of(scene, view, weather, &scratch.visible_world, std::mem::take(&mut scratch.shadows));
    let first = ROWS_BEFORE * view.width * 3;
    scratch.rgb.resize(first + room_for(view.width, view.height), 0.0);
    radiance_pass(scene, view, &rays, &light, &seen.samples, &mut scratch.rgb[first..]);
    light
}

/// Sun, sky, shadows and sky visibility around a view.
fn light_of(
    scene: &PosedScene,
    view: &View,
    weather: &Weather,
    visible_world: &[Vec3],
    buffers: Vec<Vec<i16>>,
) -> Light {
    let eye = view.world_from_cam.translation;
    let (sky, night) = Light::sources(scene, weather, eye);
    let forward = view.world_from_cam.rotation * DVec3::Z;
    let shadows =
        sky.has_shadows().then(|| ShadowMaps::new(scene, eye, forward, sky.sun_world, Some(visible_world), buffers));
    let sky_probes = SkyProbes::new(scene, eye, forward, visible_world);
    Light::new(weather, (sky, night), shadows, sky_probes)
}
