//! The color filters over the sensor's pixels: each pixel measures one of R, G, B, and its neighbors lend it the others.
//!
//! Details as fine as the pixels, such as the stones of asphalt, leaves, and edges, thus get false colors, as in
//! KITTI's images.

use macro_rules_attribute::apply;

use crate::wide_registers::array_of;

/// The colors that Bayer's filters let through (US patent 3,971,065), by the parity of row and column.
pub const FILTERS: [[usize; 2]; 2] = [[RED, GREEN], [GREEN, BLUE]];
const RED: usize = 0;
const GREEN: usize = 1;
const BLUE: usize = 2;

/// Bilinear interpolation of Bayer's mosaic.
pub struct Demosaic {
    /// The rows above, here, and below: what each pixel measures, with a pixel more at both ends.
    rows: [Vec<f32>; 3],
    /// 1 and 0 by turns.
    turns: Vec<f32>,
}

impl Demosaic {
    /// For rows of so many pixels.
    #[must_use]
    pub fn new(width: usize) -> Self {
        let row = || vec![0.0; width + 2];
        Self { rows: [row(), row(), row()], turns: (0..=width).map(|x| ((x + 1) % 2) as f32).collect() }
    }

    /// Room for what the pixels of the row measure that follows those given before; see [`Demosaic::close_row`].
    pub fn next_row(&mut self) -> &mut [f32] {
        self.rows.rotate_left(1);
        let stride = self.rows[2].len();
        &mut self.rows[2][1..stride - 1]
    }

    /// Ends a row that [`Demosaic::next_row`] gave: beyond its ends it is mirrored, so that the filters go on.
    pub fn close_row(&mut self) {
        let row = &mut self.rows[2];
        let n = row.len();
        if n >= 4 {
            (row[0], row[n - 1]) = (row[2], row[n - 3]);
        }
    }

    /// Takes the image's second row for the one above its first.
    pub fn mirror_above(&mut self) {
        let [above, _, below] = &mut self.rows;
        above.copy_from_slice(below);
    }

    /// Takes the image's last row but one for the one below its last.
    pub fn mirror_below(&mut self) {
        self.rows.rotate_left(1);
        let [above, _, below] = &mut self.rows;
        below.copy_from_slice(above);
    }

    /// R, G, and B, each for itself, of the middle one of the last three rows, which is that of this number.
    pub fn interpolate(&self, row: usize, out: &mut [Vec<f32>; 3]) {
        let rows = self.rows.each_ref().map(Vec::as_slice);
        let (evens, odds) = (&self.turns[..], &self.turns[1..]);
        let [red, green, blue] = out;
        // In odd rows blue is measured where red is in even ones, one column further.
        if row.is_multiple_of(2) {
            interpolate(rows, evens, odds, red, green, blue);
        } else {
            interpolate(rows, odds, evens, blue, green, red);
        }
    }
}

/// The color that every second pixel of a row measures, green, and the color that the rows above and below measure. `is_first`: 1 where
/// the row's color is measured; `is_green`: 1 where green is.
#[apply(for_wide_registers)]
fn interpolate(
    rows: [&[f32]; 3],
    is_first: &[f32],
    is_green: &[f32],
    first: &mut [f32],
    green: &mut [f32],
    third: &mut [f32],
) {
    let n = first.len();
    let [[a, b, c], [d, e, f], [g, h, i]]: [[&[f32]; 3]; 3] =
        array_of(|row| array_of(|column| &rows[row][column..][..n]));
    let (green, third) = (&mut green[..n], &mut third[..n]);
    let (is_first, is_green) = (&is_first[..n], &is_green[..n]);
    for k in 0..n {
        first[k] = is_first[k] * e[k] + is_green[k] * (0.5 * (d[k] + f[k]));
    }
    for k in 0..n {
        let (beside, above_below) = (d[k] + f[k], b[k] + h[k]);
        green[k] = is_green[k] * e[k] + is_first[k] * (0.25 * (beside + above_below));
    }
    for k in 0..n {
        let (above_below, corners) = (b[k] + h[k], (a[k] + c[k]) + (g[k] + i[k]));
        third[k] = is_green[k] * (0.5 * above_below) + is_first[k] * (0.25 * corners);
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const RGB: usize = 3;

    /// The mosaic of an image and its interpolation.
    fn seen(width: usize, height: usize, at: impl Fn(usize, usize, usize) -> f32) -> Vec<f32> {
        let mut demosaic = Demosaic::new(width);
        let mut colors = [(); RGB].map(|()| vec![0.0; width]);
        let mut out = vec![0.0; width * height * RGB];
        let put = |demosaic: &mut Demosaic, y: usize| {
            for (x, v) in demosaic.next_row().iter_mut().enumerate() {
                *v = at(x, y, FILTERS[y % 2][x % 2]);
            }
            demosaic.close_row();
        };
        put(&mut demosaic, 0);
        for y in 0..height {
            if y + 1 < height {
                put(&mut demosaic, y + 1);
            } else {
                demosaic.mirror_below();
            }
            if y == 0 {
                demosaic.mirror_above();
            }
            demosaic.interpolate(y, &mut colors);
            for (i, v) in out[y * width * RGB..][..width * RGB].iter_mut().enumerate() {
                *v = colors[i % RGB][i / RGB];
            }
        }
        out
    }

    #[test]
    fn even_light_and_even_slopes_stay_as_they_are() {
        let plane = |x: usize, y: usize, c: usize| 10.0 + 3.0 * x as f32 + 2.0 * y as f32 + 40.0 * c as f32;
        let (w, h) = (10, 7);
        let out = seen(w, h, plane);
        for (i, v) in out.iter().enumerate() {
            let (x, y, c) = (i / RGB % w, i / RGB / w, i % RGB);
            let is_inside = (1..w - 1).contains(&x) && (1..h - 1).contains(&y);
            assert!(!is_inside || (v - plane(x, y, c)).abs() < 1e-4, "{x} {y} {c}: {v}");
        }
        assert!(seen(5, 3, |_, _, c| c as f32).iter().enumerate().all(|(i, v)| *v == (i % RGB) as f32));
    }

    #[test]
    fn a_pixel_measures_one_color_and_lends_it_to_its_neighbors() {
        let (w, h) = (9, 9);
        // Bayer's filters by hand: R where row and column are even, B where both are odd, else G.
        for (x0, y0, color) in [(4, 4, 0), (5, 5, 2), (4, 5, 1), (5, 4, 1)] {
            let out = seen(w, h, |x, y, _| f32::from(u8::from((x, y) == (x0, y0))));
            for (i, v) in out.iter().enumerate() {
                let (dx, dy) = ((i / RGB % w).abs_diff(x0), (i / RGB / w).abs_diff(y0));
                let want = match (i % RGB == color, color, dx, dy) {
                    (true, _, 0, 0) => 1.0,
                    (true, 1, 0, 1) | (true, 1, 1, 0) => 0.25,
                    (true, 0 | 2, 0, 1) | (true, 0 | 2, 1, 0) => 0.5,
                    (true, 0 | 2, 1, 1) => 0.25,
                    _ => 0.0,
                };
                assert!((v - want).abs() < 1e-6, "{x0} {y0}: {dx} {dy} {}: {v} {want}", i % RGB);
            }
        }
    }
}
