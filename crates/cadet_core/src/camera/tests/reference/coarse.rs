//! The rates at which the fast renderer promises to find light: what it may leave out between pixels, as definitions.
//!
//! * Light is found in the middle of those samples of two pixels side by side that see one surface, and is linear from such
//!   a pair to the next, within eight columns ("coarse pixel shading": Vaidyanathan et al., HPG 2014).
//! * The visibility of the sky is found at the corners of blocks of eight by four pixels, on the surface's plane, and is
//!   bilinear between them; of what few samples of a block see, it is that of one of them.

use super::ambient::Open;
use super::shading::Surface;
use super::{Part, Reference, middle};
use crate::material::Pattern;
use crate::math::Vec3;

const COLUMNS: usize = 8;
const ROWS: usize = 4;
/// Samples of a block that are few.
const FEW: usize = 12;

/// Where the visibility of the sky is found.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum SkyRate {
    Block,
    Pair,
}

impl Reference {
    /// Linear radiance of four rows of pixels, from a row that four divides.
    pub fn four_rows(&self, top: usize, rate: SkyRate) -> Vec<Vec3> {
        let places = (top..top + ROWS).flat_map(|row| (0..self.view.width).map(move |column| (row, column)));
        let image =
            Rows { width: self.view.width, top, parts: places.clone().map(|(r, c)| self.parts(r, c)).collect() };
        let color = |(row, column)| {
            let shaded = |surface: &Surface<'_>, part: &Part| self.coarse(&image, row, column, surface, part, rate);
            self.color(image.at(row, column), row, column, shaded)
        };
        places.map(color).collect()
    }

    fn coarse(
        &self,
        image: &Rows,
        row: usize,
        column: usize,
        surface: &Surface<'_>,
        part: &Part,
        rate: SkyRate,
    ) -> (Vec3, [Vec3; 2]) {
        let pair = column / 2 * 2;
        let samples_of = |first: usize| [image.samples(row, first, part), image.samples(row, first + 1, part)].concat();
        let is_whole = |first: usize| samples_of(first).iter().all(|s| *s);
        let light_of = |first: usize| {
            let [u, v] = middle(first, row, &samples_of(first));
            let at = self.point(surface, u, v);
            let is_leaf = surface.material.pattern == Pattern::Leaves;
            let is_exact = rate == SkyRate::Pair || is_leaf;
            let open = if is_exact {
                self.open(surface, &at)
            } else {
                self.open_in_block(image, column, surface, part, [u, v])
            };
            self.light(surface, &at, &open)
        };
        let here = light_of(pair);
        let goes_on = |to: usize| to / COLUMNS == pair / COLUMNS && is_whole(pair) && is_whole(to);
        let before = pair.checked_sub(2).filter(|p| goes_on(*p)).map(light_of);
        let after = Some(pair + 2).filter(|p| goes_on(*p)).map(light_of);
        let is_left = column == pair;
        let light = std::array::from_fn(|k| {
            let (fall, rise) = (before.map(|b| here[k] - b[k]), after.map(|a| a[k] - here[k]));
            let slope = if is_left { fall.or(rise) } else { rise.or(fall) }.unwrap_or(Vec3::ZERO);
            (here[k] + slope * if is_left { -0.25 } else { 0.25 }).max(Vec3::ZERO)
        });
        let shows = |column: usize| image.samples(row, column, part).contains(&true);
        let aside = if !(shows(pair) && shows(pair + 1)) { 0.0 } else { 0.5 };
        let [u, v] = middle(pair, row, &samples_of(pair));
        (self.albedo(surface, &self.point(surface, if is_left { u - aside } else { u + aside }, v)), light)
    }

    fn open_in_block(&self, image: &Rows, column: usize, surface: &Surface<'_>, part: &Part, [u, v]: [f64; 2]) -> Open {
        let left = column / COLUMNS * COLUMNS;
        // Column by column, from the top.
        let places = (left..left + COLUMNS).flat_map(|c| (image.top..image.top + ROWS).map(move |r| (r, c)));
        let shown: Vec<(usize, usize)> = places.filter(|(r, c)| image.samples(*r, *c, part).contains(&true)).collect();
        let count =
            shown.iter().map(|(r, c)| image.samples(*r, *c, part).iter().filter(|s| **s).count()).sum::<usize>();
        let middle_column = (shown[0].1 + shown[shown.len() - 1].1) / 2;
        let one = shown.iter().find(|(_, c)| *c >= middle_column).expect("the last column shows it");
        let at_one = self.point(surface, one.1 as f64 + 0.25, one.0 as f64 + 0.25);
        if count <= FEW {
            return self.open(surface, &at_one);
        }
        let first = [left as f64 + 0.25, image.top as f64 + 0.25];
        let (across, down) = (((u - first[0]) / COLUMNS as f64) as f32, ((v - first[1]) / ROWS as f64) as f32);
        let mut sum = [0.0; 6];
        for (i, j) in [(0, 0), (1, 0), (0, 1), (1, 1)] {
            let [u, v] = [first[0] + (i * COLUMNS) as f64, first[1] + (j * ROWS) as f64];
            // The plane may end, or rise to the eye, before the corner.
            let corner = self.point_between(surface, u, v, [0.5, 2.0].map(|k| k * f64::from(at_one.depth_m)));
            let weight = (if i == 1 { across } else { 1.0 - across }) * if j == 1 { down } else { 1.0 - down };
            for (sum, open) in sum.iter_mut().zip(self.open(surface, &corner)) {
                *sum += weight * open;
            }
        }
        sum
    }
}

/// What the pixels of some rows see.
struct Rows {
    width: usize,
    top: usize,
    parts: Vec<Vec<Part>>,
}

impl Rows {
    fn at(&self, row: usize, column: usize) -> &[Part] {
        &self.parts[(row - self.top) * self.width + column]
    }

    /// The samples of a pixel that see what a part of another one shows; none beyond the image.
    fn samples(&self, row: usize, column: usize, part: &Part) -> [bool; 2] {
        let is_same = |p: &&Part| (p.layer, p.key) == (part.layer, part.key);
        let parts = if column < self.width { self.at(row, column) } else { &[] };
        parts.iter().find(is_same).map_or([false; 2], |p| p.samples)
    }
}
