//! The color filters over the sensor's pixels: each pixel measures one of R, G, B, and its neighbors lend it the others.
//!
//! Details as fine as the pixels, such as the stones of asphalt, leaves, and edges, thus get false colors, as in
//! KITTI's images.

use macro_rules_attribute::apply;

/// Values of a pixel, R, G, B, side by side.
const RGB: usize = 3;

/// What the measured values about a pixel count for in a value of it: its own, those beside it, those above and below it, and
/// those across its corners. One number for each value of a row.
struct Shares {
    own: Vec<f32>,
    beside: Vec<f32>,
    above_below: Vec<f32>,
    corners: Vec<f32>,
}

/// Bilinear interpolation of Bayer's mosaic (US patent 3,971,065): R and G alternate in even rows, G and B in odd ones.
pub struct Demosaic {
    even: Shares,
    odd: Shares,
    /// The rows above, here, and below, each with a pixel more at both ends.
    rows: [Vec<f32>; 3],
}

impl Demosaic {
    /// For rows of so many pixels.
    #[must_use]
    pub fn new(width: usize) -> Self {
        let shares = |row: usize| {
            let is_measured = |i: usize, dx: usize, dy: usize| {
                let (x, y) = ((i / RGB + dx) % 2, (row + dy) % 2);
                i % RGB == x + y
            };
            let of = |i: usize| {
                let [own, beside, above_below, corners] =
                    [(0, 0), (1, 0), (0, 1), (1, 1)].map(|(dx, dy)| is_measured(i, dx, dy));
                if own {
                    [1.0, 0.0, 0.0, 0.0]
                } else if beside && above_below {
                    [0.0, 0.25, 0.25, 0.0]
                } else {
                    let one = |is: bool, count: f32| if is { 1.0 / count } else { 0.0 };
                    [0.0, one(beside, 2.0), one(above_below, 2.0), one(corners, 4.0)]
                }
            };
            let column = |k: usize| (0..width * RGB).map(|i| of(i)[k]).collect();
            Shares { own: column(0), beside: column(1), above_below: column(2), corners: column(3) }
        };
        let row = || vec![0.0; (width + 2) * RGB];
        Self { even: shares(0), odd: shares(1), rows: [row(), row(), row()] }
    }

    /// Room for the values of the row that follows those given before; see [`Demosaic::close_row`].
    pub fn next_row(&mut self) -> &mut [f32] {
        self.rows.rotate_left(1);
        let stride = self.rows[2].len();
        &mut self.rows[2][RGB..stride - RGB]
    }

    /// Ends a row that [`Demosaic::next_row`] gave: beyond its ends it is mirrored, so that the filters go on.
    pub fn close_row(&mut self) {
        let row = &mut self.rows[2];
        let n = row.len();
        if n >= 4 * RGB {
            row.copy_within(2 * RGB..3 * RGB, 0);
            row.copy_within(n - 3 * RGB..n - 2 * RGB, n - RGB);
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

    /// The colors of the middle one of the last three rows, which is that of this number.
    pub fn interpolate(&self, row: usize, out: &mut [f32]) {
        let [above, here, below] = &self.rows;
        interpolate(if row.is_multiple_of(2) { &self.even } else { &self.odd }, [above, here, below], out);
    }
}

#[apply(for_wide_registers)]
fn interpolate(shares: &Shares, rows: [&[f32]; 3], out: &mut [f32]) {
    let n = out.len();
    let [[a, b, c], [d, e, f], [g, h, i]] = rows.map(|row| [&row[..n], &row[RGB..][..n], &row[2 * RGB..][..n]]);
    let (own, beside) = (&shares.own[..n], &shares.beside[..n]);
    let (above_below, corners) = (&shares.above_below[..n], &shares.corners[..n]);
    for k in 0..n {
        out[k] = own[k] * e[k]
            + beside[k] * (d[k] + f[k])
            + above_below[k] * (b[k] + h[k])
            + corners[k] * ((a[k] + c[k]) + (g[k] + i[k]));
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// The mosaic of an image and its interpolation.
    fn seen(width: usize, height: usize, at: impl Fn(usize, usize, usize) -> f32) -> Vec<f32> {
        let mut demosaic = Demosaic::new(width);
        let mut out = vec![0.0; width * height * RGB];
        let put = |demosaic: &mut Demosaic, y: usize| {
            for (i, v) in demosaic.next_row().iter_mut().enumerate() {
                *v = at(i / RGB, y, i % RGB);
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
            demosaic.interpolate(y, &mut out[y * width * RGB..][..width * RGB]);
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
