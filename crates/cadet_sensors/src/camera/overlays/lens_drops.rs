//! Drops of rain on the lens: each a blurred disc that shows the whole view upside down.
//!
//! A drop lies before the front element, far nearer than the lens is focused: its disc is blurred by the aperture, and where
//! it is smaller than the aperture, light passes beside it. It acts as a ball lens, whose image is inverted and wide.

use std::ops::Range;

use super::compositing::{between_cells, blend};
use crate::camera::visibility::View;
use crate::weather::Weather;
use cadet_base::math::{self, Vec3};
use cadet_base::rng::{CounterRng, Stream};

/// From the front element to the aperture, and the aperture's diameter, m.
const BEFORE_APERTURE_M: f64 = 0.03;
const APERTURE_M: f64 = 0.0012;
/// Diameters of drops that stay: larger ones run off.
const DIAMETER_M: Range<f64> = 0.001..0.0028;
/// The largest number of drops, and their number at 1 mm/h; it grows with the root of the rate.
const MOST: u64 = 14;
const AT_1_MM_PER_H: f64 = 0.9;
/// How long one stays before it runs off, or the wind takes it, s.
const STAYS_S: Range<f64> = 6.0..40.0;
/// Sides of the cells of the picture that a drop shows, px, and the share of the image's half that its edge shows.
const CELL_PX: usize = 24;
const WIDE: f64 = 0.95;

/// A drop on the lens: its middle and its diameter on the image.
#[derive(Debug, Clone, Copy, PartialEq)]
struct LensDrop {
    /// Column and row, as shares of the image's width and height.
    at: [f64; 2],
    diameter_m: f64,
}

/// The drops on a lens at a time.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct LensDrops(Vec<LensDrop>);

impl LensDrops {
    /// The drops at a time of an episode. `stream` names episode and camera: it is the same at all times, so that a drop
    /// stays where it is until it is gone.
    #[must_use]
    pub fn at(weather: &Weather, time_s: f64, stream: &mut Stream) -> Self {
        let seed = stream.next_u64();
        let share = (AT_1_MM_PER_H * weather.rain_mm_per_h.max(0.0).sqrt() / MOST as f64).min(1.0);
        let drop_of = |place: u64| {
            let mut own = CounterRng::new(CounterRng::key(seed, [place, 0, 0]));
            let stays_s = math::lerp(STAYS_S.start, STAYS_S.end, own.unit());
            let turn = (time_s / stays_s + own.unit()).floor();
            let mut rng = CounterRng::new(CounterRng::key(seed, [place, 1, turn as i64 as u64]));
            let is_there = rng.unit() < share;
            let at = [rng.unit(), rng.unit()];
            is_there.then(|| LensDrop { at, diameter_m: math::lerp(DIAMETER_M.start, DIAMETER_M.end, rng.unit()) })
        };
        Self((0..MOST).filter_map(drop_of).collect())
    }

    /// Draws them over linear radiance, interleaved RGB.
    pub(crate) fn draw(&self, rgb: &mut [f32], view: &View) {
        if self.0.is_empty() {
            return;
        }
        let picture = Small::of(rgb, view.width, view.height);
        let px_per_m = view.intrinsics_px[0] / BEFORE_APERTURE_M;
        for one in &self.0 {
            let middle = [one.at[0] * view.width as f64, one.at[1] * view.height as f64];
            let [radius_px, blur_px] = [one.diameter_m, APERTURE_M].map(|m| 0.5 * m * px_per_m);
            // A drop that is smaller than the aperture lets light pass beside it.
            let most = (one.diameter_m / APERTURE_M).min(1.0);
            let reach_px = radius_px + blur_px;
            let span = |at: f64, size: usize| {
                (at - reach_px).max(0.0) as usize..((at + reach_px).max(0.0) as usize + 1).min(size)
            };
            for row in span(middle[1], view.height) {
                for column in span(middle[0], view.width) {
                    let off = [column as f64 - middle[0], row as f64 - middle[1]];
                    let distance_px = math::hypot(off[0], off[1]);
                    let inside = 1.0 - math::smoothstep((radius_px - blur_px).abs(), reach_px, distance_px);
                    let cover = (most * most * inside) as f32;
                    if cover > 0.0 {
                        let shown = picture.at([0, 1].map(|k| 0.5 - 0.5 * WIDE * (off[k] / reach_px).clamp(-1.0, 1.0)));
                        let at = 3 * (row * view.width + column);
                        blend(&mut rgb[at..at + 3], shown, cover);
                    }
                }
            }
        }
    }
}

/// An image of cells' means.
struct Small {
    columns: usize,
    rows: usize,
    cells: Vec<Vec3>,
}

impl Small {
    fn of(rgb: &[f32], width: usize, height: usize) -> Self {
        let (columns, rows) = (width.div_ceil(CELL_PX), height.div_ceil(CELL_PX));
        let mean = |cell: usize| {
            let (row, column) = (cell / columns * CELL_PX, cell % columns * CELL_PX);
            let (to_row, to_column) = ((row + CELL_PX).min(height), (column + CELL_PX).min(width));
            let mut sum = Vec3::ZERO;
            for r in row..to_row {
                for pixel in rgb[3 * (r * width + column)..3 * (r * width + to_column)].chunks_exact(3) {
                    sum += Vec3::new(pixel[0], pixel[1], pixel[2]);
                }
            }
            sum / ((to_row - row) * (to_column - column)) as f32
        };
        Self { columns, rows, cells: (0..columns * rows).map(mean).collect() }
    }

    /// The color at shares of width and height, bilinear between cells' middles.
    fn at(&self, [x, y]: [f64; 2]) -> Vec3 {
        let place = |share: f64, count: usize| between_cells(share * count as f64 - 0.5, count);
        let ((x0, x1, tx), (y0, y1, ty)) = (place(x, self.columns), place(y, self.rows));
        let row = |y: usize| self.cells[y * self.columns + x0].lerp(self.cells[y * self.columns + x1], tx);
        row(y0).lerp(row(y1), ty)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use cadet_base::math::DPose3;

    fn view() -> View {
        View { intrinsics_px: [721.0, 721.0, 610.0, 173.0], width: 1242, height: 375, world_from_cam: DPose3::IDENTITY }
    }

    #[test]
    fn a_dry_lens_has_no_drops_and_a_wet_one_has_as_many_as_the_rate_says() {
        let count = |rain: f64| -> f64 {
            let weather = Weather::of_air(0.0, rain, 0.0, 0.0).expect("valid");
            let of = |seed| LensDrops::at(&weather, 3.0, &mut Stream::from_seed("lens", seed)).0.len();
            (0..400).map(of).sum::<usize>() as f64 / 400.0
        };
        assert_eq!(count(0.0), 0.0);
        for rain in [2.0, 8.0, 25.0] {
            let expected = AT_1_MM_PER_H * f64::sqrt(rain);
            assert!((count(rain) - expected).abs() < 0.08 * expected + 0.1, "{rain}: {}", count(rain));
        }
    }

    #[test]
    fn drops_stay_from_frame_to_frame_and_are_gone_after_a_while() {
        let weather = Weather::of_air(0.0, 25.0, 0.0, 0.0).expect("valid");
        let at = |time_s| LensDrops::at(&weather, time_s, &mut Stream::from_seed("lens", 4));
        let kept = |a: &LensDrops, b: &LensDrops| a.0.iter().filter(|d| b.0.contains(d)).count();
        let first = at(0.0);
        assert!(first.0.len() >= 2);
        assert!(kept(&first, &at(0.1)) + 1 >= first.0.len());
        assert_eq!(kept(&first, &at(100.0)), 0);
    }

    #[test]
    fn a_drop_shows_the_view_upside_down() {
        let view = view();
        // Bright above, dark below.
        let mut rgb: Vec<f32> = (0..375).flat_map(|row| vec![if row < 187 { 9.0 } else { 1.0 }; 3 * 1242]).collect();
        let plain = rgb.clone();
        LensDrops(vec![LensDrop { at: [0.5, 0.25], diameter_m: 0.0025 }]).draw(&mut rgb, &view);
        let at = |row: usize| rgb[3 * (row * 1242 + 621)];
        // In its middle the horizon; above it the dark ground, below it the bright sky.
        assert!(at(93 - 22) < 3.0 && at(93 + 22) > 7.0, "{} {}", at(71), at(115));
        let changed = rgb.chunks(3).zip(plain.chunks(3)).filter(|(a, b)| a != b).count();
        // Not beyond its disc and the aperture's blur: 0.5 (2.5 + 1.2) mm at 721 px / 30 mm.
        let reach_px: f64 = 0.5 * 0.0037 * 721.0 / 0.03;
        assert!((changed as f64) < 3.15 * (reach_px + 1.0) * (reach_px + 1.0), "{changed}");
    }

    #[test]
    fn one_smaller_than_the_aperture_lets_light_pass_beside_it() {
        let mut rgb = vec![0.0; 3 * 1242 * 375];
        let view = view();
        // The picture is black but for the drop's own place, so what it shows is nearly black too: fill by hand.
        rgb.iter_mut().for_each(|v| *v = 1.0);
        let half = 3 * 1242 * 187;
        rgb[half..].fill(5.0);
        LensDrops(vec![LensDrop { at: [0.5, 0.2], diameter_m: 0.0006 }]).draw(&mut rgb, &view);
        // At its upper edge it shows the lower half, 5, by a quarter of the light at most.
        let most = rgb[..half].iter().fold(0.0_f32, |a, b| a.max(*b));
        assert!(most > 1.0 && most <= 1.0 + 4.0 * 0.25 + 1e-5, "{most}");
    }
}
