//! A picture of a posed scene: color from two samples a pixel, depth and identity from the pixels' centers.

mod fisheye_pass;
mod rolling_shutter;

pub use fisheye_pass::render_fisheye;
pub use rolling_shutter::{Moving, render_rolling};

use std::cell::RefCell;

use crate::camera::light::{Light, ShadowMaps, SkyProbes};
use crate::camera::model::{Development, Maps, Warp};
use crate::camera::overlays::{LensDrops, Precipitation, add_halos, spray};
use crate::camera::sensor::{Exposure, Gain, MeteredPixels, Metering, ROWS_BEFORE, blur, expose};
use crate::camera::shading::{radiance_pass, room_for};
use crate::camera::visibility::{ImageRays, View, Visibility, visible_points};
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
    /// What the light was amplified by, before the exposure's correction.
    pub gain: Gain,
}

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
    /// Where the camera has its gain from.
    pub metering: Metering,
}

impl Foreground<'_> {
    /// Makes an image of the light that falls on the sensor; without maps.
    pub(super) fn develop(
        &self,
        rgb: &[f32],
        (width, height): (usize, usize),
        exposed: Exposure,
        stream: &mut Stream,
    ) -> Rendered {
        let (gain, exposed) = (exposed.gain, exposed.times(self.development.gain));
        Rendered {
            image: expose(rgb, width, height, &exposed, &self.development, stream),
            maps: None,
            radiance: self.with_radiance.then(|| exposed.light(rgb, self.development.balance())),
            gain,
        }
    }
}

/// Shades what is visible, exposes it, and adds the sensor's noise: RGB, 8 bits, row-major.
///
/// # Determinism
/// A function of its arguments; one thread. `stream` feeds the noise alone.
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
    let mut metered = MeteredPixels::default();
    metered.add(blurred, width, 0..height, 0, seen);
    let Foreground { development, metering, .. } = foreground;
    let exposed = metered.exposure(sums, width * height, is_night, *metering, development.response.aim_factor());
    let mut develop = |rgb: &[f32], size| foreground.develop(rgb, size, exposed, stream);
    let rendered = match foreground.warp {
        None => develop(blurred, (width, height)),
        Some(warp) => develop(&warp.colors(blurred), warp.image_size()),
    };
    scratch.reuse(light);
    SCRATCH.set(scratch);
    rendered
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
