//! The sensor: point spread, Poisson-Gauss noise as measured after demosaicing, rounding to 8 bits.

use crate::math;
use crate::rng::Stream;

/// Noise variance in squared 8-bit values: constant and per value, for R, G, B.
const VARIANCE: [(f32, f32); 3] = [(0.5, 0.035), (0.3, 0.018), (0.7, 0.040)];
/// Neighbour tap of the noise filter: neighbours correlate with 0.35 across and down, as demosaiced noise does.
const NEIGHBOUR: f32 = 0.187;
/// How far the middle of a pixel's four samples lies right of and below its centre, so that one of them lies on it.
pub const MIDDLE_PX: f32 = 0.25;
/// Sigma of the point spread in pixels; with the pixel's own width the edges rise over 2.1 px.
const PSF_SIGMA_PX: f32 = 0.70;

/// Blurs interleaved linear RGB by the lens's point spread, moving it by `MIDDLE_PX` onto the pixels' centres.
/// `scratch` is reused.
pub fn blur(rgb: &mut [f32], width: usize, height: usize, scratch: &mut Vec<f32>) {
    let tap = |k: f32| math::expf(-0.5 * (k + MIDDLE_PX) * (k + MIDDLE_PX) / (PSF_SIGMA_PX * PSF_SIGMA_PX));
    let taps = [tap(-2.0), tap(-1.0), tap(0.0), tap(1.0), tap(2.0)];
    let sum: f32 = taps.iter().sum();
    let [wa, wb, wc, wd, we] = taps.map(|w| w / sum);
    let stride = width * 3;
    scratch.clear();
    scratch.resize(rgb.len(), 0.0);
    for row in 0..height {
        let at = |r: isize| (row as isize + r).clamp(0, height as isize - 1) as usize * stride;
        let line = |r: isize| &rgb[at(r)..at(r) + stride];
        let (a, b, c, d, e) = (line(-2), line(-1), line(0), line(1), line(2));
        let out = &mut scratch[row * stride..(row + 1) * stride];
        for i in 0..stride {
            out[i] = wa * a[i] + wb * b[i] + wc * c[i] + wd * d[i] + we * e[i];
        }
    }
    let mut padded = vec![0.0_f32; stride + 12];
    for row in 0..height {
        let line = &scratch[row * stride..(row + 1) * stride];
        padded[6..6 + stride].copy_from_slice(line);
        for i in 0..6 {
            padded[i] = line[i % 3];
            padded[6 + stride + i] = line[stride - 3 + i % 3];
        }
        let out = &mut rgb[row * stride..(row + 1) * stride];
        let (a, b, c, d, e) = (&padded[..stride], &padded[3..], &padded[6..], &padded[9..], &padded[12..]);
        for i in 0..stride {
            out[i] = wa * a[i] + wb * b[i] + wc * c[i] + wd * d[i] + we * e[i];
        }
    }
}

/// Applies the gain, adds the noise and rounds to 8 bits.
#[must_use]
pub fn expose(rgb: &[f32], width: usize, height: usize, gain: f32, stream: &mut Stream) -> Vec<u8> {
    let deviates = normal_table(stream);
    let mut state = stream.next_u64() | 1;
    let stride = width * 3;
    let normal = 1.0 / (1.0 + 2.0 * NEIGHBOUR * NEIGHBOUR);
    let variance: Vec<[f32; 2]> = (0..stride).map(|i| [VARIANCE[i % 3].0, VARIANCE[i % 3].1]).collect();
    // White noise with a border of one pixel; three rows of it are alive at a time.
    let wide = stride + 6;
    let mut rows = vec![0.0_f32; wide * 3];
    let mut fill = |row: &mut [f32]| {
        for four in row.chunks_mut(4) {
            state ^= state << 13;
            state ^= state >> 7;
            state ^= state << 17;
            for (k, v) in four.iter_mut().enumerate() {
                *v = deviates[(state >> (16 * k)) as usize & (TABLE - 1)];
            }
        }
    };
    fill(&mut rows[..wide]);
    fill(&mut rows[wide..2 * wide]);
    let mut down = vec![0.0_f32; wide];
    let mut image = vec![0_u8; rgb.len()];
    for row in 0..height {
        let newest = (row + 2) % 3;
        fill(&mut rows[newest * wide..(newest + 1) * wide]);
        let line = |r: usize| &rows[(r % 3) * wide..(r % 3 + 1) * wide];
        let (above, here, below) = (line(row), line(row + 1), line(row + 2));
        for i in 0..wide {
            down[i] = here[i] + NEIGHBOUR * (above[i] + below[i]);
        }
        let input = &rgb[row * stride..(row + 1) * stride];
        let out = &mut image[row * stride..(row + 1) * stride];
        let (left, middle, right) = (&down[..stride], &down[3..stride + 3], &down[6..stride + 6]);
        for i in 0..stride {
            let value = (input[i] * gain).clamp(0.0, 2000.0);
            let sd = (variance[i][0] + variance[i][1] * value).sqrt();
            let noise = (middle[i] + NEIGHBOUR * (left[i] + right[i])) * normal;
            out[i] = (value + sd * noise + 0.5) as u8;
        }
    }
    image
}

const TABLE: usize = 4096;

/// Standard normal deviates with mean 0 and variance 1 exactly.
fn normal_table(stream: &mut Stream) -> Vec<f32> {
    let mut z: Vec<f64> = (0..TABLE).map(|_| stream.normal()).collect();
    let mean = z.iter().sum::<f64>() / TABLE as f64;
    let sd = (z.iter().map(|v| (v - mean) * (v - mean)).sum::<f64>() / TABLE as f64).sqrt();
    z.iter_mut().for_each(|v| *v = (*v - mean) / sd);
    z.into_iter().map(|v| v as f32).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn noise_has_the_measured_variance_and_correlation() {
        let (w, h) = (400, 300);
        let rgb = vec![120.0_f32; w * h * 3];
        let image = expose(&rgb, w, h, 1.0, &mut Stream::from_seed("noise", 3));
        for (channel, (constant, slope)) in VARIANCE.iter().enumerate() {
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
            for shift in [1, w] {
                let r = cov(shift) / cov(0);
                assert!((0.27..0.42).contains(&r), "{channel} {shift}: {r}");
            }
        }
    }

    #[test]
    fn an_edge_rises_over_the_measured_width_where_it_is_and_light_is_kept() {
        let (w, h) = (40, 9);
        // Samples lie a quarter pixel right of the pixels' centres: this edge is at 19.5 + 0.25.
        let mut rgb: Vec<f32> = (0..w * h * 3).map(|i| f32::from(u8::from((i / 3) % w >= 20))).collect();
        blur(&mut rgb, w, h, &mut Vec::new());
        let row: Vec<f32> = rgb[3 * w * 3..][..w * 3].iter().step_by(3).copied().collect();
        let at = |level: f32| {
            let i = row.iter().position(|v| *v > level).unwrap();
            i as f32 - (row[i] - level) / (row[i] - row[i - 1])
        };
        let rise = at(0.9) - at(0.1);
        assert!((1.7..2.6).contains(&rise), "{rise}");
        assert!((at(0.5) - 19.75).abs() < 0.05, "{}", at(0.5));

        let mut point = vec![0.0; w * h * 3];
        point[(4 * w + 20) * 3] = 1.0;
        blur(&mut point, w, h, &mut Vec::new());
        assert!((point.iter().sum::<f32>() - 1.0).abs() < 1e-5);
    }
}
