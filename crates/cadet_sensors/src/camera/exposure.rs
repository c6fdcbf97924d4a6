//! Auto-exposure: one gain that brings the mean luma of the clipped 8-bit image to a target.

/// Weights of R, G, B in the luma.
pub const LUMA_WEIGHTS: [f32; 3] = [0.2126, 0.7152, 0.0722];
/// The largest value of an image.
const WHITE: f32 = 255.0;
const NIGHT_METER_CEILING: f32 = 110.0;
/// A picture whose mean rises less with the gain is black; no gain is larger.
const LEAST_SLOPE: f64 = 1e-9;
const MAX_GAIN: f32 = 1e6;
/// Newton's steps end when the mean is so near to the target, in values.
const CLOSE_ENOUGH: f64 = 0.01;
const MAX_STEPS: usize = 40;

/// The gain from linear radiance to 8-bit values at which the mean luma is `target_luma`, found on every `step`-th pixel;
/// `rgb` is interleaved.
#[must_use]
pub fn gain_for_mean_luma(rgb: &[f32], target_luma: f32, step: usize) -> f32 {
    gain_below(rgb, target_luma, step, WHITE)
}

/// The gain from linear radiance to 8-bit values at which the mean luma is `target_luma` at night: lamps and what stands in
/// their beams count no more than a value of 110, so that they do not darken the rest.
#[must_use]
pub fn gain_at_night(rgb: &[f32], target_luma: f32) -> f32 {
    gain_below(rgb, target_luma, 1, NIGHT_METER_CEILING)
}

fn gain_below(rgb: &[f32], target: f32, step: usize, ceiling: f32) -> f32 {
    let pixels: Vec<[f32; 3]> = rgb.chunks_exact(3).step_by(step.max(1)).map(|p| [p[0], p[1], p[2]]).collect();
    // Where nothing clips, the mean is proportional to the gain. Clipping bends it downwards, so that Newton's steps
    // from there come up to the root and never pass it.
    let mut gain = 0.0_f32;
    for _ in 0..MAX_STEPS {
        let (mut mean, mut slope) = ([0.0_f64; 3], [0.0_f64; 3]);
        for pixel in &pixels {
            for k in 0..3 {
                let open = if pixel[k] * gain < ceiling { pixel[k] } else { 0.0 };
                slope[k] += f64::from(open);
                mean[k] += f64::from((pixel[k] * gain).min(ceiling));
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

/// At night the longest exposure gives this gain; what is above amplifies the sensor's signal and its noise.
const LONGEST_EXPOSURE_GAIN: f32 = 3000.0;
/// The most that the signal is amplified: 18 dB.
const MOST_AMPLIFICATION: f32 = 8.0;

/// How an image is exposed: what the lens scatters, and gains, of R, G, and B; and how much the sensor's noise is amplified.
#[derive(Debug, Clone, Copy)]
pub struct Exposure {
    pub veil: [f32; 3],
    pub gains: [f32; 3],
    pub amplification: f32,
}

impl Exposure {
    /// The light of an image as it is exposed, interleaved RGB in shares of white: what the lens let through, without the sensor's
    /// color filters, noise, clipping, and response.
    #[must_use]
    pub fn light(&self, rgb: &[f32]) -> Vec<f32> {
        let Self { veil, gains, .. } = self;
        rgb.iter().enumerate().map(|(i, v)| (v + veil[i % 3]) * (gains[i % 3] / WHITE)).collect()
    }
}

/// The gain at night, no more than the sensor has, and how much it amplifies the noise.
#[must_use]
pub fn night_gain(wanted_gain: f32) -> (f32, f32) {
    let gain = wanted_gain.min(LONGEST_EXPOSURE_GAIN * MOST_AMPLIFICATION);
    (gain, (gain / LONGEST_EXPOSURE_GAIN).max(1.0))
}

/// The camera's gains for R, G, B, beside the exposure: with them lit gray and the mean color are KITTI's.
pub const WHITE_BALANCE: [f32; 3] = [0.93, 1.0, 1.14];

/// Every `step`-th pixel as the sensor will see it, but for the gain: with the veil, white-balanced.
#[must_use]
pub fn metered(rgb: &[f32], veil: [f32; 3], step: usize) -> Vec<f32> {
    let seen = |p: &[f32]| [0, 1, 2].map(|k| (p[k] + veil[k]) * WHITE_BALANCE[k]);
    rgb.chunks_exact(3).step_by(step.max(1)).flat_map(seen).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_mean_hits_the_target_with_part_of_the_image_clipped() {
        let rgb: Vec<f32> = (0..3000).map(|i| if i < 300 { 9.0 } else { 0.01 + 0.00005 * i as f32 }).collect();
        let gain = gain_for_mean_luma(&rgb, 91.0, 1);
        let mean: f32 =
            rgb.chunks(3).map(|p| (0..3).map(|c| LUMA_WEIGHTS[c] * (p[c] * gain).min(255.0)).sum::<f32>()).sum::<f32>()
                / 1000.0;
        assert!((mean - 91.0).abs() < 0.5, "{mean}");
    }

    #[test]
    fn the_gain_at_night_ends_and_amplifies_noise_above_the_longest_exposure() {
        assert_eq!(night_gain(600.0), (600.0, 1.0));
        assert_eq!(night_gain(6000.0), (6000.0, 2.0));
        assert_eq!(night_gain(1e6), (24_000.0, 8.0));
    }

    #[test]
    fn an_all_black_image_does_not_hang_or_overflow() {
        assert!(gain_for_mean_luma(&[0.0; 30], 91.0, 1).is_finite());
        assert!(gain_for_mean_luma(&[], 91.0, 4).is_finite());
    }
}
