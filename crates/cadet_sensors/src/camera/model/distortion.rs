//! Lens distortion by OpenCV's model, and the wider pinhole image from which a distorted one is taken.

use std::ops::Range;

use cadet_base::error::{Error, Result};

/// Where a ray of slope (x, y) comes through the lens: k1, k2, p1, p2, k3 as in OpenCV's `distCoeffs`.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Distortion {
    /// k1, k2, k3.
    pub radial: [f64; 3],
    /// p1, p2.
    pub tangential: [f64; 2],
}

/// Steps of the iteration that inverts a lens, and how well it must have met its aim, in slopes.
const MOST_STEPS: usize = 100;
const TOLERANCE: f64 = 1e-9;
/// A lens whose slopes change less than this, squared, folds.
const LEAST_DETERMINANT: f64 = 1e-9;
/// Places along a ray at which a lens is tested for folds.
const FOLD_STEPS: i32 = 64;
/// The largest side of a pinhole image, pixels.
const MAX_SIDE_PX: f64 = 8192.0;

impl Distortion {
    /// OpenCV's order: k1, k2, p1, p2, k3. `None` for a lens without distortion.
    #[must_use]
    pub fn from_opencv([k1, k2, p1, p2, k3]: [f64; 5]) -> Option<Self> {
        ([k1, k2, p1, p2, k3] != [0.0; 5]).then_some(Self { radial: [k1, k2, k3], tangential: [p1, p2] })
    }

    /// The slopes at which a ray of slopes (x, y) leaves the lens.
    #[must_use]
    pub fn apply(&self, [x, y]: [f64; 2]) -> [f64; 2] {
        let ([k1, k2, k3], [p1, p2]) = (self.radial, self.tangential);
        let r2 = x * x + y * y;
        let radial = 1.0 + r2 * (k1 + r2 * (k2 + r2 * k3));
        [
            x * radial + 2.0 * p1 * x * y + p2 * (r2 + 2.0 * x * x),
            y * radial + p1 * (r2 + 2.0 * y * y) + 2.0 * p2 * x * y,
        ]
    }

    /// The slopes at which any ray leaves the lens: beyond where the image would fold back, it goes on outwards as it
    /// is there.
    #[must_use]
    pub fn apply_within_reach(&self, [x, y]: [f64; 2]) -> [f64; 2] {
        if self.is_single_valued([x, y]) {
            return self.apply([x, y]);
        }
        // The farthest place on the way out that does not fold.
        let (mut inside, mut outside) = (0.0, 1.0);
        for _ in 0..40 {
            let middle = 0.5 * (inside + outside);
            if self.is_single_valued([x * middle, y * middle]) { inside = middle } else { outside = middle }
        }
        let edge = self.apply([x * inside, y * inside]);
        [edge[0] + x * (1.0 - inside), edge[1] + y * (1.0 - inside)]
    }

    /// The slopes of the ray that leaves the lens at (x, y), and `None` where there is none.
    #[must_use]
    pub fn invert(&self, [x, y]: [f64; 2]) -> Option<[f64; 2]> {
        const STEP: f64 = 1e-6;
        let mut at = [x, y];
        // Newton's method with differences: the model is smooth, and starts near its solution.
        for _ in 0..MOST_STEPS {
            let [u, v] = self.apply(at);
            let miss = [u - x, v - y];
            if miss[0].abs().max(miss[1].abs()) < TOLERANCE {
                return self.is_single_valued(at).then_some(at);
            }
            let [ux, vx] = self.apply([at[0] + STEP, at[1]]);
            let [uy, vy] = self.apply([at[0], at[1] + STEP]);
            let [a, b, c, d] = [(ux - u) / STEP, (uy - u) / STEP, (vx - v) / STEP, (vy - v) / STEP];
            let determinant = a * d - b * c;
            if determinant.is_nan() || determinant.abs() < LEAST_DETERMINANT {
                return None;
            }
            at[0] -= (d * miss[0] - b * miss[1]) / determinant;
            at[1] -= (a * miss[1] - c * miss[0]) / determinant;
        }
        None
    }

    /// Whether the image still goes outwards there with the ray: beyond, a polynomial folds back.
    fn is_single_valued(&self, [x, y]: [f64; 2]) -> bool {
        let [k1, k2, k3] = self.radial;
        let steps = FOLD_STEPS;
        (0..=steps).all(|i| {
            let r2 = (x * x + y * y) * (f64::from(i) / f64::from(steps));
            1.0 + r2 * (3.0 * k1 + r2 * (5.0 * k2 + r2 * 7.0 * k3)) > 0.0
        })
    }
}

/// How a distorted image is taken from a pinhole camera's that sees a little more.
#[derive(Debug, Clone, PartialEq)]
pub struct Warp {
    /// Size of the pinhole image.
    pub width: usize,
    /// Its rows.
    pub height: usize,
    /// How many columns and rows the pinhole image begins before the distorted one: both have the same focal lengths.
    pub before_px: [f64; 2],
    /// Columns of the distorted image.
    image_width: usize,
    /// Where each pixel of the distorted image lies in the pinhole one, row-major.
    places: Vec<[f32; 2]>,
}

impl Warp {
    /// The warp of an image of `width` x `height` pixels with (fx, fy, cx, cy).
    ///
    /// # Errors
    /// A lens that folds the image, or that needs a pinhole image of more than 8192 pixels.
    pub fn new(lens: &Distortion, [fx, fy, cx, cy]: [f64; 4], width: usize, height: usize) -> Result<Self> {
        let refused = |why: &str| Error::OutOfRange {
            what: "distortion",
            value: format!("{:?} {:?}", lens.radial, lens.tangential),
            expected: why.to_owned(),
        };
        let mut straight = Vec::with_capacity(width * height);
        for v in 0..height {
            for u in 0..width {
                let slopes = lens.invert([(u as f64 - cx) / fx, (v as f64 - cy) / fy]);
                let [x, y] = slopes.ok_or_else(|| refused("a lens that does not fold the image"))?;
                straight.push([x * fx + cx, y * fy + cy]);
            }
        }
        let least =
            straight.iter().fold([f64::MAX; 2], |m, p| [m[0].min(p[0]), m[1].min(p[1])]).map(|x| x.floor() - 1.0);
        let most = straight.iter().fold([f64::MIN; 2], |m, p| [m[0].max(p[0]), m[1].max(p[1])]).map(|x| x.ceil() + 1.0);
        let size = [most[0] - least[0] + 1.0, most[1] - least[1] + 1.0];
        if size.iter().any(|s| *s > MAX_SIDE_PX) {
            return Err(refused("one that keeps the image within 8192 pixels when it is straightened"));
        }
        let places = straight.iter().map(|p| [(p[0] - least[0]) as f32, (p[1] - least[1]) as f32]).collect();
        Ok(Self {
            width: size[0] as usize,
            height: size[1] as usize,
            before_px: least.map(|l| -l),
            image_width: width,
            places,
        })
    }

    /// Columns and rows of the distorted image.
    #[must_use]
    pub fn image_size(&self) -> (usize, usize) {
        (self.image_width, self.places.len() / self.image_width)
    }

    /// The distorted image of an interleaved RGB pinhole image, between its pixels by their distances.
    #[must_use]
    pub fn colors(&self, rgb: &[f32]) -> Vec<f32> {
        let mut out = Vec::with_capacity(self.places.len() * 3);
        self.append_colors(0..self.image_size().1, 0, rgb, &mut out);
        out
    }

    /// Some rows of the distorted image, of a pinhole image that begins at row `first_row`.
    pub(crate) fn append_colors(&self, rows: Range<usize>, first_row: usize, rgb: &[f32], out: &mut Vec<f32>) {
        for [u, v] in self.places_of(rows) {
            let (column, row) = (*u as usize, *v as usize);
            let (right, below) = (u - column as f32, v - row as f32);
            let first = ((row - first_row) * self.width + column) * 3;
            let second = first + self.width * 3;
            for k in 0..3 {
                let mix = |at: usize| rgb[at + k] * (1.0 - right) + rgb[at + 3 + k] * right;
                out.push(mix(first) * (1.0 - below) + mix(second) * below);
            }
        }
    }

    /// The distorted map of a pinhole image's: of each pixel the nearest; none of none.
    #[must_use]
    pub fn nearest<T: Copy>(&self, values: &[T]) -> Vec<T> {
        if values.is_empty() {
            return Vec::new();
        }
        let mut out = Vec::with_capacity(self.places.len());
        self.append_nearest(0..self.image_size().1, 0, values, &mut out);
        out
    }

    /// As [`Warp::append_colors`].
    pub(crate) fn append_nearest<T: Copy>(&self, rows: Range<usize>, first_row: usize, values: &[T], out: &mut Vec<T>) {
        let at = |[u, v]: &[f32; 2]| ((v + 0.5) as usize - first_row) * self.width + (u + 0.5) as usize;
        out.extend(self.places_of(rows).iter().map(|place| values[at(place)]));
    }

    fn places_of(&self, rows: Range<usize>) -> &[[f32; 2]] {
        &self.places[rows.start * self.image_width..rows.end * self.image_width]
    }

    /// The rows of the pinhole image that some rows of the distorted one show.
    pub(crate) fn rows_needed(&self, rows: Range<usize>) -> Range<usize> {
        let rows = self.places_of(rows).iter().map(|[_, v]| *v as usize);
        let (first, last) = rows.fold((usize::MAX, 0), |(first, last), row| (first.min(row), last.max(row)));
        first..last + 2
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A wide-angle lens of a common calibration.
    fn barrel() -> Distortion {
        Distortion::from_opencv([-0.28, 0.07, 1.2e-4, -3.0e-4, -0.008]).expect("distorts")
    }

    #[test]
    fn the_inverse_takes_back_what_the_lens_does() {
        for x in [-0.8, -0.3, 0.0, 0.1, 0.7] {
            for y in [-0.4, 0.0, 0.35] {
                let back = barrel().invert(barrel().apply([x, y])).expect("single-valued");
                assert!((back[0] - x).abs() < 1e-8 && (back[1] - y).abs() < 1e-8, "{back:?} {x} {y}");
            }
        }
        assert!(Distortion::from_opencv([0.0; 5]).is_none());
    }

    #[test]
    fn opencvs_terms_have_opencvs_signs() {
        let of = |c: [f64; 5]| Distortion::from_opencv(c).expect("distorts").apply([0.5, -0.2]);
        let r2: f64 = 0.29;
        let close = |got: [f64; 2], x: f64, y: f64| assert!((got[0] - x).abs() < 1e-12 && (got[1] - y).abs() < 1e-12);
        close(of([0.1, 0.0, 0.0, 0.0, 0.0]), 0.5 * (1.0 + 0.1 * r2), -0.2 * (1.0 + 0.1 * r2));
        close(of([0.0, 0.0, 0.01, 0.0, 0.0]), 0.5 + 0.02 * 0.5 * -0.2, -0.2 + 0.01 * (r2 + 2.0 * 0.04));
        close(of([0.0, 0.0, 0.0, 0.01, 0.0]), 0.5 + 0.01 * (r2 + 2.0 * 0.25), -0.2 + 0.02 * 0.5 * -0.2);
        close(of([0.0, 0.0, 0.0, 0.0, 1.0]), 0.5 * (1.0 + r2 * r2 * r2), -0.2 * (1.0 + r2 * r2 * r2));
    }

    #[test]
    fn lenses_that_fold_the_image_are_refused() {
        let folding = Distortion::from_opencv([-1.0, 0.0, 0.0, 0.0, 0.0]).expect("distorts");
        let text = Warp::new(&folding, [200.0, 200.0, 199.5, 99.5], 400, 200).expect_err("folds").to_string();
        assert!(text.contains("distortion") && text.contains("fold"), "{text}");
    }

    #[test]
    fn a_pixel_shows_what_lies_where_its_ray_comes_from() {
        let (intrinsics, width, height) = ([300.0, 310.0, 199.0, 98.0], 400, 200);
        let warp = Warp::new(&barrel(), intrinsics, width, height).expect("a lens");
        assert!(warp.width > width && warp.height > height, "a barrel sees more than the pinhole");
        // Colors that say where in the pinhole image they lie.
        let own: Vec<f32> =
            (0..warp.height).flat_map(|v| (0..warp.width).flat_map(move |u| [u as f32, v as f32, 0.0])).collect();
        let image = warp.colors(&own);
        let nearest = warp.nearest(&(0..warp.width * warp.height).collect::<Vec<_>>());
        for (u, v) in [(0, 0), (399, 0), (17, 150), (200, 98), (399, 199)] {
            let [x, y] = [f64::from(image[(v * width + u) * 3]), f64::from(image[(v * width + u) * 3 + 1])];
            let slopes = [(x - warp.before_px[0] - 199.0) / 300.0, (y - warp.before_px[1] - 98.0) / 310.0];
            let [a, b] = barrel().apply(slopes);
            assert!((a * 300.0 + 199.0 - u as f64).abs() < 1e-3 && (b * 310.0 + 98.0 - v as f64).abs() < 1e-3);
            let place = nearest[v * width + u];
            let (column, row) = ((place % warp.width) as f64, (place / warp.width) as f64);
            assert!((column - x).abs() <= 0.501 && (row - y).abs() <= 0.501);
        }
    }
}
