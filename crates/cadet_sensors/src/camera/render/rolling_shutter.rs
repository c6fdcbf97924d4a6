//! Images that take time: a rolling shutter exposes rows one after the other, and each row gathers light for a while, as the
//! car and all actors move.
//!
//! The image is taken in bands of rows, each of the whole world (bodies, shadows, sky visibility) as it is in the middle of
//! the band's time, or at several instants of it whose mean is taken. Bodies move as under a turning LIDAR: with steady velocity and angular velocity.

use std::ops::Range;

use super::{Foreground, Rendered, Scratch, radiance};
use crate::camera::model::{CameraModel, Maps, Warp};
use crate::camera::overlays::{add_halos, spray};
use crate::camera::sensor::{MeteredPixels, ROWS_BEFORE, blur};
use crate::camera::visibility::{Motions, SurfaceMapKinds, View, visibility_pass};
use crate::sense::{PosedScene, RigidMotion};
use crate::weather::Weather;
use cadet_base::error::Result;
use cadet_base::math::DPose3;
use cadet_base::rng::Stream;

/// A band's time: what is passed 5 m aside and 8 m ahead at 15 m/s moves by 0.4 pixels of KITTI's camera meanwhile.
const BAND_S: f64 = 0.000_5;
/// Instants of a blurred image are at most so far apart: in it, what is passed as above moves by 0.8 pixels.
const INSTANT_S: f64 = 0.001;
/// Rows above and below a band whose light the lens's point spread brings into it.
const MARGIN: usize = 2;

/// What moves while the rows are exposed.
pub struct Moving<'a, F> {
    /// The world at the instant in the middle of the exposures.
    pub scene: &'a PosedScene,
    /// The pose of the camera's frame then.
    pub world_from_cam: &'a DPose3,
    /// The camera's motion.
    pub camera: RigidMotion,
    /// How an actor moves, by its id.
    pub motion_of: F,
    /// Everything between the scene and the sensor.
    pub foreground: Foreground<'a>,
}

/// When a row is exposed, in seconds from the middle of the first's and the last's time.
fn row_time_s(camera: &CameraModel, row: f64) -> f64 {
    camera.rolling_shutter_s() * (row / (camera.height - 1) as f64 - 0.5)
}

/// The instants at which light is gathered, seconds from a row's time.
fn instants(camera: &CameraModel) -> impl ExactSizeIterator<Item = f64> {
    let span_s = camera.motion_blur_s();
    let count = ((span_s / INSTANT_S).ceil() as usize).max(1);
    (0..count).map(move |i| span_s * ((i as f64 + 0.5) / count as f64 - 0.5))
}

/// The rows that are exposed together.
fn bands(camera: &CameraModel) -> impl Iterator<Item = Range<usize>> {
    let (height, count) = (camera.height, (camera.rolling_shutter_s() / BAND_S).ceil());
    let count = (count as usize).clamp(1, height);
    (0..count).map(move |i| i * height / count..(i + 1) * height / count)
}

/// As [`super::render_through`], [`crate::camera::Visibility::maps`], and [`crate::camera::Visibility::surface_maps`], row by
/// row: what moves does so from the row's time on. `maps` says which are made; `None` makes none at all.
///
/// # Errors
/// Those of [`visibility_pass`].
pub fn render_rolling(
    moving: &Moving<'_, impl Fn(i32) -> RigidMotion>,
    camera: &CameraModel,
    weather: &Weather,
    maps: Option<&SurfaceMapKinds>,
    stream: &mut Stream,
) -> Result<Rendered> {
    let at_instant = View::new(camera, moving.world_from_cam);
    let mut scratch = Scratch::default();
    let (mut rgb, mut sums) = (Vec::with_capacity(camera.width * camera.height * 3), [0.0; 3]);
    let mut metered = MeteredPixels::default();
    let (mut maps, is_night) = (maps.map(|kinds| (kinds, Maps::default())), weather.is_night());
    for rows in bands(camera) {
        let time_s = row_time_s(camera, 0.5 * (rows.start + rows.end - 1) as f64);
        // Of the image before the lens.
        let needed = moving.foreground.warp.map_or(rows.clone(), |warp| warp.rows_needed(rows.clone()));
        let drawn = needed.start.saturating_sub(MARGIN)..(needed.end + MARGIN).min(at_instant.height);
        let moved = |time_s: f64| {
            let view = at_instant.rows(drawn.clone(), &moving.camera.displacement(time_s));
            let scene = moving.scene.moved(|actor_id| (moving.motion_of)(actor_id).displacement(time_s));
            let seen = visibility_pass(&scene, &view);
            seen.map(|seen| (view, scene, seen))
        };
        let (mut gathered, mut ceiling, mut last_seen) = (Vec::new(), f32::INFINITY, None);
        for instant_s in instants(camera) {
            let (view, scene, seen) = moved(time_s + instant_s)?;
            let light = radiance(&scene, &view, weather, &seen, &mut scratch);
            let below = &mut scratch.rgb[ROWS_BEFORE * view.width * 3..];
            spray::draw(&moving.foreground.spray, below, &view, &seen, &light);
            if let Some(precipitation) = &moving.foreground.precipitation {
                precipitation.draw(below, &view, &seen, &light);
            }
            ceiling = light.glare_ceiling();
            let _ = blur(&mut scratch.rgb, view.width, view.height, ceiling);
            scratch.reuse(light);
            gather(&mut gathered, &scratch.rgb[..view.width * view.height * 3]);
            last_seen = Some(seen);
        }
        let share = 1.0 / instants(camera).len() as f32;
        gathered.iter_mut().for_each(|value| *value *= share);
        let of_band = needed.start - drawn.start..needed.end - drawn.start;
        if let Some(seen) = &last_seen {
            metered.add(&gathered, at_instant.width, of_band, drawn.start, seen);
        }
        let band = Band { rows, first: drawn.start, width: at_instant.width, warp: moving.foreground.warp };
        let start = rgb.len();
        band.append_colors(&gathered, &mut rgb);
        for pixel in rgb[start..].chunks_exact(3) {
            for (sum, value) in sums.iter_mut().zip(pixel) {
                *sum += f64::from(value.min(ceiling));
            }
        }
        if let Some((kinds, maps)) = &mut maps {
            let of_actor = |id| (moving.motion_of)(id).after(time_s);
            let motions = Motions { camera: moving.camera.after(time_s), of_actor: &of_actor };
            let (_, scene, seen) = moved(time_s)?;
            let of_band = seen.maps(&scene);
            let surfaces = seen.surface_maps(&scene, |ray| camera.pixel_of_ray(ray), &motions, kinds);
            band.append(&of_band.depth_m, &mut maps.depth_m);
            band.append(&of_band.instance, &mut maps.instance);
            band.append(&of_band.semantic, &mut maps.semantic);
            band.append(&surfaces.normal_cam, &mut maps.surfaces.normal_cam);
            band.append(&surfaces.velocity_cam_m_per_s, &mut maps.surfaces.velocity_cam_m_per_s);
            band.append(&surfaces.flow_px, &mut maps.surfaces.flow_px);
        }
    }
    moving.foreground.lens_drops.draw(&mut rgb, &View { width: camera.width, height: camera.height, ..at_instant });
    if is_night {
        add_halos(&mut rgb, camera.width, camera.height);
    }
    let Foreground { development, metering, .. } = &moving.foreground;
    let num_pixels = camera.width * camera.height;
    let exposed = metered.exposure(sums, num_pixels, is_night, *metering, development.response.aim_factor());
    let rendered = moving.foreground.develop(&rgb, (camera.width, camera.height), exposed, stream);
    Ok(Rendered { maps: maps.map(|(_, maps)| maps), ..rendered })
}

/// Adds an image to the sum of others.
fn gather(sum: &mut Vec<f32>, rgb: &[f32]) {
    if sum.is_empty() {
        sum.extend_from_slice(rgb);
    } else {
        sum.iter_mut().zip(rgb).for_each(|(sum, value)| *sum += value);
    }
}

/// Rows of the image, taken from an image before the lens that begins at row `first`.
struct Band<'a> {
    rows: Range<usize>,
    first: usize,
    width: usize,
    warp: Option<&'a Warp>,
}

impl Band<'_> {
    /// Where the rows are, if there is no lens.
    fn pixels(&self) -> Range<usize> {
        (self.rows.start - self.first) * self.width..(self.rows.end - self.first) * self.width
    }

    fn append_colors(&self, rgb: &[f32], out: &mut Vec<f32>) {
        match self.warp {
            None => out.extend_from_slice(&rgb[self.pixels().start * 3..self.pixels().end * 3]),
            Some(warp) => warp.append_colors(self.rows.clone(), self.first, rgb, out),
        }
    }

    /// Nothing of a map that was not made.
    fn append<T: Copy>(&self, values: &[T], out: &mut Vec<T>) {
        match self.warp {
            _ if values.is_empty() => {}
            None => out.extend_from_slice(&values[self.pixels()]),
            Some(warp) => warp.append_nearest(self.rows.clone(), self.first, values, out),
        }
    }
}
