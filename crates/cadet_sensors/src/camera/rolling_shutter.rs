//! A rolling shutter: rows are exposed one after the other, while the car and all actors move.
//!
//! The image is taken in bands of rows, each of the whole world (bodies, shadows, sky visibility) as it is in the middle of
//! the band's time. Bodies move as under a turning LIDAR: with steady velocity and angular velocity.

use std::ops::Range;

use super::bloom::add_halos;
use super::distortion::Warp;
use super::exposure::MeteredPixels;
use super::model::CameraModel;
use super::noise::{ROWS_BEFORE, blur, expose};
use super::render::{Foreground, Rendered, Scratch, radiance};
use super::spray;
use super::visibility_pass::{Maps, View, visibility_pass};
use crate::sense::{PosedScene, RigidMotion};
use crate::weather::Weather;
use cadet_base::error::Result;
use cadet_base::math::DPose3;
use cadet_base::rng::Stream;

/// A band's time: what is passed 5 m aside and 8 m ahead at 15 m/s moves by 0.4 pixels of KITTI's camera meanwhile.
const BAND_S: f64 = 0.000_5;
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

/// The rows that are exposed together.
fn bands(camera: &CameraModel) -> impl Iterator<Item = Range<usize>> {
    let (height, count) = (camera.height, (camera.rolling_shutter_s() / BAND_S).ceil());
    let count = (count as usize).clamp(1, height);
    (0..count).map(move |i| i * height / count..(i + 1) * height / count)
}

/// As [`super::render_through`] and [`super::Visibility::maps_through`], row by row.
///
/// # Errors
/// Those of [`visibility_pass`].
pub fn render_rolling(
    moving: &Moving<'_, impl Fn(i32) -> RigidMotion>,
    camera: &CameraModel,
    weather: &Weather,
    with_maps: bool,
    stream: &mut Stream,
) -> Result<Rendered> {
    let at_instant = View::new(camera, moving.world_from_cam);
    let mut scratch = Scratch::default();
    let (mut rgb, mut sums) = (Vec::with_capacity(camera.width * camera.height * 3), [0.0; 3]);
    let mut metered = MeteredPixels::default();
    let (mut maps, is_night) = (with_maps.then(Maps::default), weather.is_night());
    for rows in bands(camera) {
        let time_s = row_time_s(camera, 0.5 * (rows.start + rows.end - 1) as f64);
        // Of the image before the lens.
        let needed = moving.foreground.warp.map_or(rows.clone(), |warp| warp.rows_needed(rows.clone()));
        let drawn = needed.start.saturating_sub(MARGIN)..(needed.end + MARGIN).min(at_instant.height);
        let view = at_instant.rows(drawn.clone(), &moving.camera.displacement(time_s));
        let scene = moving.scene.moved(|actor_id| (moving.motion_of)(actor_id).displacement(time_s));
        let seen = visibility_pass(&scene, &view)?;
        let light = radiance(&scene, &view, weather, &seen, &mut scratch);
        let below = &mut scratch.rgb[ROWS_BEFORE * view.width * 3..];
        spray::draw(&moving.foreground.spray, below, &view, &seen, &light);
        if let Some(precipitation) = &moving.foreground.precipitation {
            precipitation.draw(below, &view, &seen, &light);
        }
        let ceiling = light.glare_ceiling();
        let _ = blur(&mut scratch.rgb, view.width, view.height, ceiling);
        scratch.reuse(light);
        let of_band = needed.start - drawn.start..needed.end - drawn.start;
        metered.add(&scratch.rgb, view.width, of_band, drawn.start, &seen);
        let band = Band { rows, first: drawn.start, width: view.width, warp: moving.foreground.warp };
        let start = rgb.len();
        band.append_colors(&scratch.rgb, &mut rgb);
        for pixel in rgb[start..].chunks_exact(3) {
            for (sum, value) in sums.iter_mut().zip(pixel) {
                *sum += f64::from(value.min(ceiling));
            }
        }
        if let Some(maps) = &mut maps {
            let of_band = seen.maps(&scene);
            band.append(&of_band.depth_m, &mut maps.depth_m);
            band.append(&of_band.instance, &mut maps.instance);
            band.append(&of_band.semantic, &mut maps.semantic);
        }
    }
    moving.foreground.lens_drops.draw(&mut rgb, &View { width: camera.width, height: camera.height, ..at_instant });
    if is_night {
        add_halos(&mut rgb, camera.width, camera.height);
    }
    let metering = moving.foreground.metering;
    let exposed = metered.exposure(sums, camera.width * camera.height, is_night, metering);
    let image = expose(&rgb, camera.width, camera.height, &exposed, stream);
    Ok(Rendered { image, maps, gain: exposed.gain })
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

    fn append<T: Copy>(&self, values: &[T], out: &mut Vec<T>) {
        match self.warp {
            None => out.extend_from_slice(&values[self.pixels()]),
            Some(warp) => warp.append_nearest(self.rows.clone(), self.first, values, out),
        }
    }
}
