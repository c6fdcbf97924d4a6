//! Lens and sensor in the order of the light: point spread; on the mosaic of color filters exposure, Poisson-Gauss noise, and
//! clipping; then the interpolation of colors, white balance, and rounding to 8 bits.

use macro_rules_attribute::apply;

use super::exposure::{Exposure, Gain};
use super::mosaic::{Demosaic, FILTERS};
use crate::camera::model::{Development, WHITE_BALANCE, WHITE_VALUE};
use crate::wide_registers::array_of;
use cadet_base::math;
use cadet_base::rng::Stream;

/// Noise variance in squared 8-bit values of the image, for R, G, B: constant, and per value.
const READ_OUT_VARIANCE: [f32; 3] = [0.5, 0.3, 0.7];
const VARIANCE_PER_VALUE: [f32; 3] = [0.035, 0.018, 0.040];
/// The share of a pixel's variance that the mean pixel has once colors are interpolated: of R and B a quarter of the pixels have their
/// own, half the mean of two, a quarter that of four; of G half have their own and half the mean of four.
const VARIANCE_LEFT: [f32; 3] = [0.5625, 0.625, 0.5625];
/// How far the middle of a pixel's two samples lies right of and below its center, so that one of them lies on it.
pub const MIDDLE_PX: f32 = 0.25;
/// Sigma of the point spread in pixels: with the pixel's own width and the color filters' the power at 0.2 to 0.45 cycles a
/// pixel is that of KITTI's frames.
const PSF_SIGMA_PX: f32 = 0.50;

/// Taps of the point spread, along and across.
const TAPS: usize = 5;
/// Values of a pixel, R, G, B, side by side.
const RGB: usize = 3;
/// Pixels by which the filters of a row reach beyond it.
const PSF_REACH: usize = TAPS / 2;
/// Sums of a row are kept apart so that their order does not depend on the registers: whole registers and whole pixels.
const SUMS: usize = 24;
/// Two of a number's four bytes.
const EVEN_BYTES: u32 = 0x00FF_00FF;
const LOW_HALF: u32 = 0xFFFF;
/// Factors and shifts of a 32-bit hash (Wellons, "Prospecting for Hash Functions", 2018).
const HASH_FACTORS: [u32; 2] = [0x7FEB_352D, 0x846C_A68B];
const HASH_SHIFTS: [u32; 2] = [16, 15];

/// Rows that must be free before the image that is blurred: it moves up into them.
pub const ROWS_BEFORE: usize = 2;

/// Blurs interleaved linear RGB by the lens's point spread, moving it by `MIDDLE_PX` onto the pixels' centers. The image
/// begins after `ROWS_BEFORE` rows; blurred, it begins where `rgb` does.
///
/// Returns the sums over all pixels of R, G and B, of which none counts for more than `radiance_ceiling`.
pub fn blur(rgb: &mut [f32], width: usize, height: usize, radiance_ceiling: f32) -> [f64; 3] {
    let tap = |k: f32| math::expf(-0.5 * (k + MIDDLE_PX) * (k + MIDDLE_PX) / (PSF_SIGMA_PX * PSF_SIGMA_PX));
    let taps = [tap(-2.0), tap(-1.0), tap(0.0), tap(1.0), tap(2.0)];
    let sum: f32 = taps.iter().sum();
    let taps = taps.map(|w| w / sum);
    let stride = width * 3;
    let mut total = [0.0_f64; 3];
    if height == 0 || width == 0 {
        return total;
    }
    // Above the first row it goes on.
    for row in 0..ROWS_BEFORE {
        rgb.copy_within(ROWS_BEFORE * stride..(ROWS_BEFORE + 1) * stride, row * stride);
    }
    let mut padded = vec![0.0_f32; stride + 2 * PSF_REACH * RGB];
    for row in 0..height {
        let line = |r: usize| &rgb[r.min(height + 1) * stride..][..stride];
        blur_down(
            &taps,
            std::array::from_fn(|k| line(row + k)),
            &mut padded[PSF_REACH * RGB..PSF_REACH * RGB + stride],
        );
        for i in 0..PSF_REACH * RGB {
            padded[i] = padded[PSF_REACH * RGB + i % RGB];
            padded[PSF_REACH * RGB + stride + i] = padded[(PSF_REACH - 1) * RGB + stride + i % RGB];
        }
        let out = &mut rgb[row * stride..(row + 1) * stride];
        let sums = blur_across(&taps, &padded, out, radiance_ceiling);
        for (k, s) in sums.iter().enumerate() {
            total[k % 3] += f64::from(*s);
        }
    }
    total
}

#[apply(for_wide_registers)]
fn blur_down(taps: &[f32; TAPS], [a, b, c, d, e]: [&[f32]; TAPS], out: &mut [f32]) {
    let n = out.len();
    let (a, b, c, d, e) = (&a[..n], &b[..n], &c[..n], &d[..n], &e[..n]);
    let [wa, wb, wc, wd, we] = *taps;
    for i in 0..n {
        out[i] = wa * a[i] + wb * b[i] + wc * c[i] + wd * d[i] + we * e[i];
    }
}

/// Returns sums of every [`SUMS`]th value, none above the ceiling: a fixed order whatever the instruction set.
#[apply(for_wide_registers)]
fn blur_across(taps: &[f32; TAPS], padded: &[f32], out: &mut [f32], ceiling: f32) -> [f32; SUMS] {
    let n = out.len();
    let [a, b, c, d, e]: [&[f32]; TAPS] = array_of(|k| &padded[k * RGB..][..n]);
    let [wa, wb, wc, wd, we] = *taps;
    for i in 0..n {
        out[i] = wa * a[i] + wb * b[i] + wc * c[i] + wd * d[i] + we * e[i];
    }
    let mut sums = [0.0; SUMS];
    for some in out.chunks(SUMS) {
        for (s, v) in sums.iter_mut().zip(some) {
            *s += v.min(ceiling);
        }
    }
    sums
}

/// Adds the veil; lets each pixel measure one color, with its noise, until it is full; interpolates the others, balances them,
/// and gives the response in 8 bits.
///
/// Where the signal is amplified, the variance of the photons' noise grows with it and that of the read-out with its square
/// (EMVA 1288).
#[must_use]
pub fn expose(
    rgb: &[f32],
    width: usize,
    height: usize,
    exposure: &Exposure,
    development: &Development,
    stream: &mut Stream,
) -> Vec<u8> {
    let stride = width * RGB;
    let mut sensor = Sensor::new(width, exposure, development, stream.next_u64());
    let mut image = vec![0_u8; rgb.len()];
    let mut demosaic = Demosaic::new(width);
    let mut colors = [(); RGB].map(|()| vec![0.0_f32; width]);
    for (row, out) in image.chunks_exact_mut(stride.max(1)).enumerate() {
        if row == 0 {
            sensor.measure(0, &rgb[..stride], &mut demosaic);
        }
        if row + 1 < height {
            sensor.measure(row + 1, &rgb[(row + 1) * stride..][..stride], &mut demosaic);
        } else {
            demosaic.mirror_below();
        }
        if row == 0 {
            demosaic.mirror_above();
        }
        demosaic.interpolate(row, &mut colors);
        development.response.write(&colors, sensor.white_balance, out);
    }
    image
}

/// How the pixels of a row measure: offset, and variance of the noise, constant and per value.
struct FilteredRow {
    /// Of the pixels of even and of odd numbers.
    colors: [usize; 2],
    offset: Vec<f32>,
    variance: Vec<f32>,
    per_value: Vec<f32>,
}

/// A sensor behind color filters, row by row.
struct Sensor {
    gain: f32,
    /// Even rows and odd ones.
    rows: [FilteredRow; 2],
    white_balance: [f32; RGB],
    /// What a pixel measures that is full: the least that is white in all three channels.
    full: f32,
    seed: u64,
    noise: Vec<f32>,
}

impl Sensor {
    fn new(width: usize, &Exposure { veil, gain }: &Exposure, development: &Development, seed: u64) -> Self {
        let Gain { values_per_radiance, amplification } = gain;
        let (white_balance, noise) = (development.balance(), development.noise * development.noise);
        let each = |of: fn(usize) -> f32, factor: f32| std::array::from_fn(|k| of(k) * factor / VARIANCE_LEFT[k]);
        let read_out = |k| READ_OUT_VARIANCE[k] / (WHITE_BALANCE[k] * WHITE_BALANCE[k]);
        let variance = each(read_out, amplification * amplification * noise);
        let per_value = each(|k| VARIANCE_PER_VALUE[k] / WHITE_BALANCE[k], amplification * noise);
        let offset = veil.map(|v| v * values_per_radiance);
        let row = |colors: [usize; 2]| {
            let row = |of: [f32; RGB]| (0..width).map(|x| of[colors[x % 2]]).collect();
            FilteredRow { colors, offset: row(offset), variance: row(variance), per_value: row(per_value) }
        };
        Self {
            gain: values_per_radiance,
            rows: FILTERS.map(row),
            white_balance,
            full: WHITE_VALUE / white_balance.into_iter().fold(f32::INFINITY, f32::min),
            seed,
            noise: vec![0.0; width],
        }
    }

    /// Takes a row as it falls on the color filters.
    fn measure(&mut self, row: usize, input: &[f32], demosaic: &mut Demosaic) {
        let (out, filters) = (demosaic.next_row(), &self.rows[row % 2]);
        let [even, odd] = filters.colors;
        let first = (row * input.len()) as u32;
        white_noise(self.seed, [first + even as u32, first + odd as u32], &mut self.noise);
        let (pairs, last) = out.as_chunks_mut::<2>();
        for (pixels, out) in input.as_chunks::<{ 2 * RGB }>().0.iter().zip(pairs) {
            *out = [pixels[even], pixels[RGB + odd]];
        }
        if let ([last], [.., r, g, b]) = (last, input) {
            *last = [*r, *g, *b][even];
        }
        measure(self.gain, self.full, filters, &self.noise, out);
        demosaic.close_row();
    }
}

/// Makes measured values of the light in a row of pixels.
#[apply(for_wide_registers)]
fn measure(gain: f32, full: f32, filters: &FilteredRow, noise: &[f32], light: &mut [f32]) {
    let n = light.len();
    let (offset, noise) = (&filters.offset[..n], &noise[..n]);
    let (variance, per_value) = (&filters.variance[..n], &filters.per_value[..n]);
    for i in 0..n {
        let value = light[i] * gain + offset[i];
        let sd = (variance[i] + per_value[i] * value).sqrt();
        // Black lies above the converter's zero, so that noise does not brighten it.
        light[i] = (value + sd * noise[i]).min(full);
    }
}

/// Standard normal deviates from counters, which begin differently for pixels of even and of odd numbers: two hashes' eight bytes,
/// whose sum is nearly normal (excess kurtosis -0.15).
#[apply(for_wide_registers)]
fn white_noise(seed: u64, [even, odd]: [u32; 2], out: &mut [f32]) {
    // Mean 8 * 127.5; variance 8 * (256^2 - 1) / 12.
    const MEAN: f32 = 1020.0;
    const PER_SD: f32 = 1.0 / 209.021_5;
    let (low, high) = (seed as u32, (seed >> u32::BITS) as u32);
    for (i, v) in out.iter_mut().enumerate() {
        let first = if i & 1 == 0 { even } else { odd };
        let a = mix(first.wrapping_add(RGB as u32 * i as u32) ^ low);
        let b = mix(a ^ high);
        let pairs = (a & EVEN_BYTES) + (a >> 8 & EVEN_BYTES) + (b & EVEN_BYTES) + (b >> 8 & EVEN_BYTES);
        let sum = (pairs & LOW_HALF) + (pairs >> 16);
        *v = (sum as i32 as f32 - MEAN) * PER_SD;
    }
}

/// A well mixed 32-bit hash: xorshifts and multiplications, as the finaliser of a hash has them.
#[inline(always)]
fn mix(mut x: u32) -> u32 {
    x = (x ^ x >> HASH_SHIFTS[0]).wrapping_mul(HASH_FACTORS[0]);
    x = (x ^ x >> HASH_SHIFTS[1]).wrapping_mul(HASH_FACTORS[1]);
    x ^ x >> HASH_SHIFTS[0]
}

#[cfg(test)]
mod tests {
    use super::*;

    /// For an image that is white-balanced already.
    fn exposure(gain: f32, amplification: f32) -> Exposure {
        Exposure { veil: [0.0; 3], gain: Gain { values_per_radiance: gain, amplification } }
    }

    fn unbalanced(values: Vec<f32>) -> Vec<f32> {
        values.iter().enumerate().map(|(i, v)| v / WHITE_BALANCE[i % 3]).collect()
    }

    #[test]
    fn amplified_noise_grows_as_its_parts_do() {
        let (w, h) = (400, 300);
        let rgb = unbalanced(vec![60.0; w * h * 3]);
        let image =
            expose(&rgb, w, h, &exposure(1.0, 4.0), &Development::default(), &mut Stream::from_seed("amplified", 3));
        for (channel, (constant, slope)) in READ_OUT_VARIANCE.iter().zip(VARIANCE_PER_VALUE).enumerate() {
            let v: Vec<f64> = image.iter().skip(channel).step_by(3).map(|b| f64::from(*b)).collect();
            let mean = v.iter().sum::<f64>() / v.len() as f64;
            let variance = v.iter().map(|x| (x - mean) * (x - mean)).sum::<f64>() / v.len() as f64;
            let want = f64::from(16.0 * constant + 4.0 * slope * 60.0);
            assert!((variance - want).abs() < 0.12 * want, "{channel}: {variance} {want}");
        }
    }

    #[test]
    fn noise_has_the_measured_variance_and_correlation() {
        let (w, h) = (400, 300);
        let rgb = unbalanced(vec![120.0; w * h * 3]);
        let image =
            expose(&rgb, w, h, &exposure(1.0, 1.0), &Development::default(), &mut Stream::from_seed("noise", 3));
        for (channel, (constant, slope)) in READ_OUT_VARIANCE.iter().zip(VARIANCE_PER_VALUE).enumerate() {
            let v: Vec<f64> = image.iter().skip(channel).step_by(3).map(|b| f64::from(*b)).collect();
            let mean = v.iter().sum::<f64>() / v.len() as f64;
            let cov = |shift: usize| {
                (0..v.len() - shift).map(|i| (v[i] - mean) * (v[i + shift] - mean)).sum::<f64>()
                    / (v.len() - shift) as f64
            };
            let want = f64::from(constant + slope * 120.0);
            assert!((mean - 120.0).abs() < 0.1, "{mean}");
            // Rounding adds 1/12.
            assert!((cov(0) - want - 1.0 / 12.0).abs() < 0.12 * want, "{channel}: {} {want}", cov(0));
            // Interpolated noise: of R and B neighbors share 3/8 of 9/16, of G 1/4 of 5/8; rounding adds to the variance alone.
            let shared = if channel == 1 { 0.4 } else { 2.0 / 3.0 } * want / cov(0);
            for shift in [1, w] {
                let r = cov(shift) / cov(0);
                assert!((r - shared).abs() < 0.02, "{channel} {shift}: {r} {shared}");
            }
        }
    }

    #[test]
    fn what_is_too_bright_is_full_before_colors_are_interpolated() {
        let (w, h) = (20, 16);
        // A square of twice and of a hundred times white, in the dark.
        let [twice, much] = [2.0, 100.0].map(|radiance| {
            let inside = |i: usize| (8..12).contains(&(i / RGB % w)) && (6..10).contains(&(i / RGB / w));
            let rgb: Vec<f32> = (0..w * h * RGB).map(|i| if inside(i) { radiance } else { 0.0 }).collect();
            expose(&rgb, w, h, &exposure(255.0, 1.0), &Development::default(), &mut Stream::from_seed("full", 1))
        });
        assert_eq!(twice, much);
        for (i, value) in much.iter().enumerate() {
            let (x, y) = (i / RGB % w, i / RGB / w);
            let outside = |v: usize, from: usize| from.saturating_sub(v).max(v.saturating_sub(from + 3));
            match outside(x, 8).max(outside(y, 6)) {
                0 if (9..11).contains(&x) && (7..9).contains(&y) => assert_eq!(*value, 255, "{x} {y}"),
                0 => (),
                // No more than two of four pixels, or one of two, are within.
                1 => assert!(
                    f32::from(*value) <= 0.5 * WHITE_VALUE / WHITE_BALANCE[0] * WHITE_BALANCE[i % RGB] + 4.0,
                    "{x} {y}: {value}"
                ),
                _ => assert!(*value < 5, "{x} {y}: {value}"),
            }
        }
    }

    #[test]
    fn a_pixel_has_the_noise_of_one_color_which_its_neighbors_share() {
        let (w, h) = (64, 64);
        let rgb = unbalanced(vec![90.0; w * h * RGB]);
        let image =
            expose(&rgb, w, h, &exposure(1.0, 8.0), &Development::default(), &mut Stream::from_seed("shared", 2));
        let at = |x: usize, y: usize, k: usize| f32::from(image[(y * w + x) * RGB + k]);
        for (x, y) in (2..60).step_by(2).flat_map(|y| (2..60).step_by(2).map(move |x| (x, y))) {
            // Red between two red pixels, blue between four blue ones, to the roundings.
            assert!((at(x + 1, y, 0) - 0.5 * (at(x, y, 0) + at(x + 2, y, 0))).abs() <= 1.0);
            let corners = [(x - 1, y - 1), (x + 1, y - 1), (x - 1, y + 1), (x + 1, y + 1)].map(|(x, y)| at(x, y, 2));
            assert!((at(x, y, 2) - 0.25 * corners.iter().sum::<f32>()).abs() <= 1.0);
        }
    }

    #[test]
    fn an_edge_rises_over_the_measured_width_where_it_is_and_light_is_kept() {
        let (w, h) = (40, 90);
        // Samples lie a quarter pixel right of the pixels' centers: this edge is at 19.5 + 0.25.
        let mut rgb: Vec<f32> = (0..w * h * 3).map(|i| f32::from(u8::from((i / 3) % w >= 20))).collect();
        rgb.splice(0..0, vec![0.0; ROWS_BEFORE * w * 3]);
        let _ = blur(&mut rgb, w, h, 1.0);
        rgb.truncate(w * h * 3);
        // Behind lens and color filters, the mean green of all rows: the filters for it lie alike in all columns.
        let image =
            expose(&rgb, w, h, &exposure(200.0, 1.0), &Development::default(), &mut Stream::from_seed("edge", 1));
        let row: Vec<f32> = (0..w)
            .map(|x| (0..h).map(|y| f32::from(image[(y * w + x) * 3 + 1])).sum::<f32>() / (200 * h) as f32)
            .collect();
        let at = |level: f32| {
            let i = row.iter().position(|v| *v > level).unwrap();
            i as f32 - (row[i] - level) / (row[i] - row[i - 1])
        };
        let rise = at(0.9) - at(0.1);
        // The pixels' own width comes to it.
        assert!((1.6..2.6).contains(&rise), "{rise}");
        assert!((at(0.5) - 19.75).abs() < 0.08, "{}", at(0.5));

        let mut point = vec![0.0; w * h * 3];
        point[(4 * w + 20) * 3] = 1.0;
        point.splice(0..0, vec![0.0; ROWS_BEFORE * w * 3]);
        let sums = blur(&mut point, w, h, 1.0);
        point.truncate(w * h * 3);
        assert!((point.iter().sum::<f32>() - 1.0).abs() < 1e-5);
        assert!((sums[0] - 1.0).abs() < 1e-5 && sums[1] == 0.0, "{sums:?}");
    }

    #[test]
    fn white_noise_is_normal_and_frames_are_independent() {
        let draw = |seed: u64| {
            let mut v = vec![0.0_f32; 200_000];
            white_noise(Stream::from_seed("white", seed).next_u64(), [0, 1], &mut v);
            v
        };
        let (a, b) = (draw(0), draw(1));
        let n = a.len() as f64;
        let moment = |p: i32| a.iter().map(|v| (0..p).fold(1.0, |m, _| m * f64::from(*v))).sum::<f64>() / n;
        assert!(moment(1).abs() < 0.01 && (moment(2) - 1.0).abs() < 0.015, "{} {}", moment(1), moment(2));
        assert!(moment(3).abs() < 0.03 && (moment(4) - 2.85).abs() < 0.08, "{} {}", moment(3), moment(4));
        // Normal: 4.55 % lie beyond two standard deviations.
        let beyond = a.iter().filter(|v| v.abs() > 2.0).count() as f64 / n;
        assert!((beyond - 0.0455).abs() < 0.004, "{beyond}");
        let product = |x: &[f32], y: &[f32]| x.iter().zip(y).map(|(x, y)| f64::from(x * y)).sum::<f64>() / n;
        assert!(product(&a, &b).abs() < 0.01);
        for shift in [1, 2, 3, 1248, 3732] {
            assert!(product(&a[shift..], &a).abs() < 0.01, "{shift}");
        }
    }
}
