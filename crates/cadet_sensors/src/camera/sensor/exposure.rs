//! Auto-exposure: one gain that brings the mean luma of the clipped 8-bit image to a target.
//!
//! A rig has one: its first camera meters, and all expose alike, as those of a stereo pair have to. It meters what stands. In a
//! sequence its gain follows the light, slowly where little is missing; a camera that has not looked for a second meters anew, so
//! that its image is a function of its instant.

use std::ops::Range;

use crate::camera::model::{WHITE_BALANCE, WHITE_VALUE};
use crate::camera::visibility::Visibility;
use crate::wide_registers::array_of;
use cadet_base::math;

/// Weights of R, G, B in the luma.
pub const LUMA_WEIGHTS: [f32; 3] = [0.2126, 0.7152, 0.0722];
const NIGHT_METER_CEILING: f32 = 110.0;
/// Mean luma that the exposure aims at, and its spread from episode to episode: that of images, with darker traffic, is 92.
pub const MEAN_LUMA: [f32; 2] = [95.0, 3.0];
/// Mean luma that the exposure aims at by night, which is to stay dark, and its spread from episode to episode.
pub const NIGHT_MEAN_LUMA: [f32; 2] = [27.0, 2.0];
/// Share of the mean radiance that lens and housing scatter over the image; see
/// [`crate::camera::light::Light::glare_ceiling`].
pub const VEILING_GLARE_SHARE: f32 = 0.016;
/// Every so many pixels one is metered: a prime number, so that no column is.
const METERED_STEP: usize = 37;
/// Vehicles and people have this weight, and what stands beside them in the same rows theirs: what passes a camera that stands
/// does not make its images flicker, and one that is full of a bus is metered by the bus.
const ACTOR_WEIGHT: f32 = 0.05;
/// Rows that are metered together: as many as hold enough pixels.
const STRIP_ROWS: usize = 8;
/// A picture whose mean rises less with the gain is black; no gain is larger.
const LEAST_SLOPE: f64 = 1e-9;
const MAX_GAIN: f32 = 1e6;
/// Newton's steps end when the mean is so near to the target, in values.
const CLOSE_ENOUGH: f64 = 0.01;
const MAX_STEPS: usize = 40;

/// How fast a gain adapts, by the cube of the logarithm x of what it is wrong by, 1/s: what passes a camera that stands makes
/// x 0.2 at most, and images half a percent brighter in a tenth of a second; of a factor of four, a second of sun leaves 1.35.
const ADAPTATION_PER_S: f32 = 6.0;
/// A camera that has not looked for so long has adapted, seconds.
const ADAPTED_AFTER_S: f32 = 1.0;

/// The longest exposure gives this gain, which a clear noon does not need; what is above amplifies the sensor's signal and its
/// noise. KITTI's cameras expose for 2 ms at most (Geiger et al. 2013).
const LONGEST_EXPOSURE_GAIN: f32 = 3000.0;
/// The longest exposure's gain at night, in the unit of that light.
const LONGEST_EXPOSURE_GAIN_AT_NIGHT: f32 = 3000.0;
/// The most that the signal is amplified: 18 dB.
const MOST_AMPLIFICATION: f32 = 8.0;

/// How much an image's light is amplified, alike for all cameras of a rig.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Gain {
    /// From linear radiance to 8-bit values.
    pub values_per_radiance: f32,
    /// How much of it amplifies the sensor's signal and its noise: 1 where the exposure is long enough.
    pub amplification: f32,
}

impl Gain {
    /// The gain that is wanted, but no more than the sensor has, if its longest exposure gives another.
    #[must_use]
    pub fn within(wanted_gain: f32, longest_exposure_gain: f32) -> Self {
        let gain = wanted_gain.min(longest_exposure_gain * MOST_AMPLIFICATION);
        Self { values_per_radiance: gain, amplification: (gain / longest_exposure_gain).max(1.0) }
    }
}

/// The gain of the image before, and how long ago that was.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct LastGain {
    /// That of the image.
    pub gain: Gain,
    /// Seconds.
    pub age_s: f32,
}

impl LastGain {
    /// What auto-exposure gives now that another gain is wanted.
    #[must_use]
    pub fn toward(self, wanted_gain: f32) -> f32 {
        if self.age_s >= ADAPTED_AFTER_S {
            return wanted_gain;
        }
        // Solves dx/dt = -a x^3.
        let last = self.gain.values_per_radiance;
        let wrong = math::lnf(last / wanted_gain);
        let left = wrong / (1.0 + 2.0 * ADAPTATION_PER_S * wrong * wrong * self.age_s).sqrt();
        last * math::expf(left - wrong)
    }
}

/// Where a camera has its gain from.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Metering {
    /// From its own image, whose mean luma it brings to so many standard deviations above that of most.
    Own {
        /// Of the mean luma, in standard deviations.
        error: f32,
        /// That of the image before, in a sequence.
        last: Option<LastGain>,
    },
    /// From another camera of its rig.
    Rig(Gain),
}

impl Default for Metering {
    fn default() -> Self {
        Self::Own { error: 0.0, last: None }
    }
}

/// How an image is exposed: what the lens scatters, and the gain.
#[derive(Debug, Clone, Copy)]
pub struct Exposure {
    pub veil: [f32; 3],
    pub gain: Gain,
}

impl Exposure {
    /// The light of an image as it is exposed and developed, interleaved RGB in shares of white: what the lens let through, without
    /// the sensor's color filters, noise, clipping, and response.
    #[must_use]
    pub fn light(&self, rgb: &[f32], white_balance: [f32; 3]) -> Vec<f32> {
        let balance = white_balance.map(|factor| factor * self.gain.values_per_radiance / WHITE_VALUE);
        rgb.iter().enumerate().map(|(i, v)| (v + self.veil[i % 3]) * balance[i % 3]).collect()
    }

    /// This exposure with a factor of the light.
    #[must_use]
    pub fn times(mut self, factor: f32) -> Self {
        self.gain.values_per_radiance *= factor;
        self
    }
}

/// A pixel in linear RGB, and what it counts.
pub type MeteredPixel = ([f32; 3], f32);

/// The pixels that a camera meters, before the lens bends their image.
#[derive(Debug, Default)]
pub struct MeteredPixels(Vec<MeteredPixel>);

impl MeteredPixels {
    /// Some of the pixels of an image in linear RGB, all alike.
    pub fn of(pixels: &[[f32; 3]]) -> Self {
        Self(pixels.iter().step_by(METERED_STEP).map(|pixel| (*pixel, 1.0)).collect())
    }

    /// Adds some of the pixels in rows of a part of the image in linear RGB, and of what was seen in that part; it begins
    /// `above` rows below the image's top.
    pub fn add(&mut self, rgb: &[f32], width: usize, rows: Range<usize>, above: usize, seen: &Visibility) {
        let pixels = rgb.as_chunks::<3>().0;
        let number = |row: usize| ((above + row) * width).div_ceil(METERED_STEP);
        for top in rows.clone().step_by(STRIP_ROWS) {
            let (first, mut sum) = (self.0.len(), 0.0);
            let metered = (number(top)..number((top + STRIP_ROWS).min(rows.end)))
                .map(|number| number * METERED_STEP - above * width);
            for (at, shows_actor) in metered.clone().zip(seen.show_actors(metered)) {
                let weight = if shows_actor { ACTOR_WEIGHT } else { 1.0 };
                sum += weight;
                self.0.push((pixels[at], weight));
            }
            let strip = &mut self.0[first..];
            let scale = strip.len() as f32 / sum;
            strip.iter_mut().for_each(|(_, weight)| *weight *= scale);
        }
    }

    /// How the image is exposed. `radiance_sums` are those of [`super::noise::blur`], of so many pixels; the meter aims at so many
    /// times the usual light.
    #[must_use]
    pub fn exposure(
        self,
        radiance_sums: [f64; 3],
        num_pixels: usize,
        is_night: bool,
        metering: Metering,
        aim_factor: f32,
    ) -> Exposure {
        let veil = radiance_sums.map(|s| (f64::from(VEILING_GLARE_SHARE) * s / num_pixels as f64) as f32);
        let gain = match metering {
            Metering::Own { error, last } => self.gain(veil, is_night, (error, last), aim_factor),
            Metering::Rig(gain) => gain,
        };
        Exposure { veil, gain }
    }

    fn gain(self, veil: [f32; 3], is_night: bool, (error, last): (f32, Option<LastGain>), aim_factor: f32) -> Gain {
        let pixels: Vec<MeteredPixel> = self.0.into_iter().map(|(p, weight)| (balanced(p, veil), weight)).collect();
        let [mean, deviation] = if is_night { NIGHT_MEAN_LUMA } else { MEAN_LUMA };
        let target = (mean + deviation * error) * aim_factor;
        let (wanted, longest) = if is_night {
            (gain_at_night(&pixels, target), LONGEST_EXPOSURE_GAIN_AT_NIGHT)
        } else {
            (gain_for_mean_luma(&pixels, target), LONGEST_EXPOSURE_GAIN)
        };
        Gain::within(last.map_or(wanted, |last| last.toward(wanted)), longest)
    }
}

/// A pixel as the sensor will see it, but for the gain: with the veil, white-balanced.
pub fn balanced(rgb: [f32; 3], veil: [f32; 3]) -> [f32; 3] {
    array_of(|k| (rgb[k] + veil[k]) * WHITE_BALANCE[k])
}

/// The gain from linear radiance to 8-bit values at which the mean luma of the pixels is `target_luma`.
#[must_use]
pub fn gain_for_mean_luma(pixels: &[MeteredPixel], target_luma: f32) -> f32 {
    gain_below(pixels, target_luma, WHITE_VALUE)
}

/// The gain from linear radiance to 8-bit values at which the mean luma is `target_luma` at night: lamps and what stands in
/// their beams count no more than a value of 110, so that they do not darken the rest.
#[must_use]
pub fn gain_at_night(pixels: &[MeteredPixel], target_luma: f32) -> f32 {
    gain_below(pixels, target_luma, NIGHT_METER_CEILING)
}

fn gain_below(pixels: &[MeteredPixel], target: f32, ceiling: f32) -> f32 {
    // Where nothing clips, the mean is proportional to the gain. Clipping bends it downwards, so that Newton's steps
    // from there come up to the root and never pass it.
    let mut gain = 0.0_f32;
    for _ in 0..MAX_STEPS {
        let (mut mean, mut slope) = ([0.0_f64; 3], [0.0_f64; 3]);
        for (pixel, weight) in pixels {
            for k in 0..3 {
                let open = if pixel[k] * gain < ceiling { pixel[k] } else { 0.0 };
                slope[k] += f64::from(weight * open);
                mean[k] += f64::from(weight * (pixel[k] * gain).min(ceiling));
            }
        }
        let luma =
            |v: [f64; 3]| v.iter().zip(LUMA_WEIGHTS).map(|(c, w)| c * f64::from(w)).sum::<f64>() / pixels.len() as f64;
        let (missing, slope) = (f64::from(target) - luma(mean), luma(slope));
        let next = gain + (missing / slope) as f32;
        // Black or empty images have no slope.
        if !(slope > LEAST_SLOPE && next < MAX_GAIN) {
            return gain.max(1.0);
        }
        gain = next;
        if missing < CLOSE_ENOUGH {
            break;
        }
    }
    gain
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_mean_hits_the_target_with_part_of_the_image_clipped() {
        let rgb: Vec<f32> = (0..3000).map(|i| if i < 300 { 9.0 } else { 0.01 + 0.00005 * i as f32 }).collect();
        let pixels = rgb.as_chunks::<3>().0;
        let alike: Vec<MeteredPixel> = pixels.iter().map(|p| (*p, 1.0)).collect();
        let gain = gain_for_mean_luma(&alike, 91.0);
        let luma = |p: &[f32; 3]| (0..3).map(|c| LUMA_WEIGHTS[c] * (p[c] * gain).min(255.0)).sum::<f32>();
        let mean = pixels.iter().map(luma).sum::<f32>() / 1000.0;
        assert!((mean - 91.0).abs() < 0.5, "{mean}");
    }

    #[test]
    fn the_gain_ends_and_amplifies_noise_above_the_longest_exposure() {
        let of = |wanted| {
            let Gain { values_per_radiance, amplification } = Gain::within(wanted, 3000.0);
            (values_per_radiance, amplification)
        };
        assert_eq!(of(600.0), (600.0, 1.0));
        assert_eq!(of(6000.0), (6000.0, 2.0));
        assert_eq!(of(1e6), (24_000.0, 8.0));
    }

    #[test]
    fn a_sequence_is_steady_under_small_changes_and_follows_large_ones_within_two_seconds() {
        let toward = |last: f32, wanted, age_s| LastGain { gain: Gain::within(last, 3000.0), age_s }.toward(wanted);
        for wanted in [410.0, 460.0, 550.0, 610.0] {
            assert!((toward(500.0, wanted, 0.1) / 500.0 - 1.0).abs() < 0.005, "{wanted}");
        }
        // From shade into sun that is four times as bright, and back, in frames of 10 Hz.
        for (from, wanted) in [(2000.0, 500.0), (500.0, 2000.0)] {
            let mut gains = vec![from];
            for _ in 0..20 {
                gains.push(toward(gains[gains.len() - 1], wanted, 0.1));
            }
            let missing = |gain: f32| math::lnf(gain / wanted).abs();
            assert!(gains.windows(2).all(|g| missing(g[1]) < missing(g[0])), "{gains:?}");
            assert!(missing(gains[10]) < 0.30 && missing(gains[20]) < 0.21, "{gains:?}");
            // Twice the frames are no faster.
            let halves = toward(toward(from, wanted, 0.05), wanted, 0.05);
            assert!((halves / gains[1] - 1.0).abs() < 1e-5, "{halves} {gains:?}");
            // Two pictures of one instant are one; an old one is forgotten.
            assert_eq!((toward(from, wanted, 0.0), toward(from, wanted, 1.0)), (from, wanted));
        }
    }

    #[test]
    fn an_all_black_image_does_not_hang_or_overflow() {
        assert!(gain_for_mean_luma(&[([0.0; 3], 1.0); 10], 91.0).is_finite());
        assert!(gain_for_mean_luma(&[], 91.0).is_finite());
    }
}
