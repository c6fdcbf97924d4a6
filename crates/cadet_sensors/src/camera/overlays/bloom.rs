//! Light of lamps that the lens scatters around them at night.

use super::compositing::between_cells;

/// Side of the cells on which the halo is found, pixels.
const CELL: usize = 4;
/// A pixel counts with what it has above the first radiance and up to the second.
const FROM: f32 = 0.1;
const UP_TO: f32 = 12.0;
/// Halos: how far each reaches (the standard deviation, in cells) and the share of the light that it holds.
const HALOS: [(f32, f32); 2] = [(1.3, 0.006), (6.0, 0.004)];
/// A Gaussian is three means of a sliding window.
const PASSES: usize = 3;

/// Adds the halos to an interleaved linear image.
pub fn add_halos(rgb: &mut [f32], width: usize, height: usize) {
    let (across, down) = (width.div_ceil(CELL), height.div_ceil(CELL));
    let mut bright = vec![[0.0_f32; 3]; across * down];
    let mut any = false;
    for (row, line) in rgb.chunks_exact(width * 3).take(height).enumerate() {
        let cells = &mut bright[row / CELL * across..][..across];
        for (column, pixel) in line.chunks_exact(3).enumerate() {
            if pixel[0].max(pixel[1]).max(pixel[2]) > FROM {
                any = true;
                for (sum, value) in cells[column / CELL].iter_mut().zip(pixel) {
                    *sum += (value - FROM).clamp(0.0, UP_TO);
                }
            }
        }
    }
    if !any {
        return;
    }
    let mut halo = vec![[0.0_f32; 3]; across * down];
    for (deviation, share) in HALOS {
        let mut spread = bright.clone();
        let radius = window_radius(deviation);
        for _ in 0..PASSES {
            spread = mean_along(&spread, across, down, radius);
            spread = mean_along(&spread, down, across, radius);
        }
        let scale = share / (CELL * CELL) as f32;
        for (sum, value) in halo.iter_mut().zip(&spread) {
            (0..3).for_each(|k| sum[k] += scale * value[k]);
        }
    }
    add(rgb, (width, height), &halo, (across, down));
}

/// The radius of a window whose mean, thrice, is a Gaussian of that deviation: 3 ((2r + 1)² - 1) / 12 = deviation².
fn window_radius(deviation: f32) -> usize {
    (((4.0 * deviation * deviation + 1.0).sqrt() - 1.0) * 0.5).round().max(1.0) as usize
}

/// Means of windows along rows; the result is transposed.
fn mean_along(from: &[[f32; 3]], across: usize, down: usize, radius: usize) -> Vec<[f32; 3]> {
    let mut to = vec![[0.0; 3]; from.len()];
    let scale = 1.0 / (2 * radius + 1) as f32;
    for row in 0..down {
        let line = &from[row * across..][..across];
        // Sums of few numbers each: no error runs along the row.
        for column in 0..across {
            let window = &line[column.saturating_sub(radius)..(column + radius + 1).min(across)];
            let mut sum = [0.0; 3];
            for value in window {
                (0..3).for_each(|k| sum[k] += value[k]);
            }
            to[column * down + row] = sum.map(|s| s * scale);
        }
    }
    to
}

/// Adds cells to pixels, bilinearly between their middles.
fn add(rgb: &mut [f32], (width, height): (usize, usize), halo: &[[f32; 3]], (across, down): (usize, usize)) {
    let place = |pixel: usize, cells: usize| between_cells((pixel as f64 + 0.5) / CELL as f64 - 0.5, cells);
    let columns: Vec<_> = (0..width).map(|column| place(column, across)).collect();
    let mut line = vec![[0.0_f32; 3]; across];
    for (row, pixels) in rgb.chunks_exact_mut(width * 3).take(height).enumerate() {
        let (above, below, t) = place(row, down);
        for (i, value) in line.iter_mut().enumerate() {
            let (a, b) = (&halo[above * across + i], &halo[below * across + i]);
            *value = std::array::from_fn(|k| a[k] + (b[k] - a[k]) * t);
        }
        for (pixel, (left, right, t)) in pixels.chunks_exact_mut(3).zip(&columns) {
            let (a, b) = (&line[*left], &line[*right]);
            (0..3).for_each(|k| pixel[k] += a[k] + (b[k] - a[k]) * t);
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_lamp_gets_a_halo_with_the_stated_share_of_its_light() {
        let (w, h) = (320, 320);
        let mut rgb = vec![0.0; w * h * 3];
        for (y, x) in (158..162).flat_map(|y| (158..162).map(move |x| (y, x))) {
            rgb[(y * w + x) * 3] = 5.0 + FROM;
        }
        let before: f32 = rgb.iter().sum();
        add_halos(&mut rgb, w, h);
        let added = rgb.iter().sum::<f32>() - before;
        assert!((added / (16.0 * 5.0) - 0.010).abs() < 5e-4, "{added}");
        let at = |aside: usize| rgb[(160 * w + 160 + aside) * 3];
        let fall: Vec<f32> = [4, 8, 16, 32, 64].map(at).to_vec();
        assert!(fall.windows(2).all(|pair| pair[1] < pair[0]), "{fall:?}");
        assert_eq!(rgb[1], 0.0);
    }

    #[test]
    fn what_is_dim_has_none() {
        let mut rgb = vec![0.09; 40 * 30 * 3];
        add_halos(&mut rgb, 40, 30);
        assert!(rgb.iter().all(|v| *v == 0.09));
    }
}
