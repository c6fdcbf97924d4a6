//! Auto-exposure: one gain that brings the mean luma of the clipped 8-bit image to a target.

/// Weights of R, G, B in the luma.
pub const LUMA: [f32; 3] = [0.2126, 0.7152, 0.0722];

/// The gain from linear radiance to 8-bit values at which the mean luma is `target`, found by bisection on every
/// `step`-th pixel; `rgb` is interleaved.
#[must_use]
pub fn gain_for_mean_luma(rgb: &[f32], target: f32, step: usize) -> f32 {
    let pixels: Vec<[f32; 3]> = rgb.chunks_exact(3).step_by(step.max(1)).map(|p| [p[0], p[1], p[2]]).collect();
    let mean = |gain: f32| {
        let sum: f64 = pixels
            .iter()
            .map(|p| {
                let luma: f32 = p.iter().zip(LUMA).map(|(c, w)| w * (c * gain).clamp(0.0, 255.0)).sum();
                f64::from(luma)
            })
            .sum();
        (sum / pixels.len().max(1) as f64) as f32
    };
    // Radiances lie around 0.05; the bounds are where a black or a white image would end.
    let (mut low, mut high) = (1.0_f32, 1e6_f32);
    for _ in 0..20 {
        let middle = (low * high).sqrt();
        if mean(middle) < target { low = middle } else { high = middle }
    }
    (low * high).sqrt()
}

/// Adds the light that lens and housing scatter over the whole image: a share of the mean radiance, in which no pixel
/// counts for more than `ceiling`. Shadows are never fully black.
pub fn add_veiling_glare(rgb: &mut [f32], share: f32, ceiling: f32) {
    let mut sum = [0.0_f64; 3];
    for pixel in rgb.chunks_exact(3) {
        for (s, c) in sum.iter_mut().zip(pixel) {
            *s += f64::from(c.min(ceiling));
        }
    }
    let count = (rgb.len() / 3).max(1) as f64;
    let veil = sum.map(|s| share * (s / count) as f32);
    for pixel in rgb.chunks_exact_mut(3) {
        for (c, v) in pixel.iter_mut().zip(veil) {
            *c += v;
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_mean_hits_the_target_with_part_of_the_image_clipped() {
        let rgb: Vec<f32> = (0..3000).map(|i| if i < 300 { 9.0 } else { 0.01 + 0.00005 * i as f32 }).collect();
        let gain = gain_for_mean_luma(&rgb, 91.0, 1);
        let mean: f32 =
            rgb.chunks(3).map(|p| (0..3).map(|c| LUMA[c] * (p[c] * gain).min(255.0)).sum::<f32>()).sum::<f32>()
                / 1000.0;
        assert!((mean - 91.0).abs() < 0.5, "{mean}");
    }

    #[test]
    fn an_all_black_image_does_not_hang_or_overflow() {
        assert!(gain_for_mean_luma(&[0.0; 30], 91.0, 1).is_finite());
        assert!(gain_for_mean_luma(&[], 91.0, 4).is_finite());
    }
}
