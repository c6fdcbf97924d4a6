//! How coarsely light is found, as the fast renderer promises:
//! * Light is found in the middle of those samples of two pixels side by side that see one surface, and is linear from such
//!   a pair to the next, within eight columns ("coarse pixel shading": Vaidyanathan et al., HPG 2014).
//! * The visibility of the sky is found at the corners of blocks of eight by four pixels, on the surface's plane, and is
//!   bilinear between them; of what few samples of a block see, it is that of one of them.

use std::ops::Range;

use super::shading::Surface;
use super::{COLUMNS, MIDDLE, Part, ROWS, Reference, pixels};
use crate::camera::light::SkyVisibility;
use cadet_base::math::Vec3;

/// Pixels of a block that are few.
const FEW: f32 = 6.0;

#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Rate {
    /// Light is found as coarsely as stated above.
    Coarse,
    /// Light is found in every pixel.
    Pixel,
}

impl Part {
    /// The middle of the samples of some pixels in a row.
    fn middle(&self, row: usize, columns: Range<usize>) -> [f64; 2] {
        let (mut sum, mut count) = ([0.0; 2], 0.0);
        for (column, aside) in columns.flat_map(|column| [(column, 0.0), (column, 0.5)]) {
            if self.samples[row][column][usize::from(aside > 0.0)] {
                sum = [sum[0] + (self.left + column) as f64 + aside, sum[1] + (self.top + row) as f64 + aside];
                count += 1.0;
            }
        }
        sum.map(|s| s / count)
    }
}

impl Reference {
    /// A surface's albedo in a pixel of a block, and its light: what counts with the albedo (or with what is behind), and what
    /// does not.
    pub(super) fn shaded(
        &self,
        part: &Part,
        s: &Surface<'_>,
        row: usize,
        column: usize,
        rate: Rate,
    ) -> (Vec3, [Vec3; 2]) {
        if rate == Rate::Pixel {
            let at = self.point(s, part.middle(row, column..column + 1));
            return (self.albedo(s, &at), self.light(s, &at, &self.open(s, &at)));
        }
        let light_of = |pair: usize| {
            let middle = part.middle(row, pair..pair + 2);
            let at = self.point(s, middle);
            self.light(s, &at, &if s.is_leaf { self.open(s, &at) } else { self.open_in_block(part, s, middle) })
        };
        let (pair, line) = (column / 2 * 2, &part.samples[row]);
        let is_whole = |pair: usize| line[pair..pair + 2] == [[true; 2]; 2];
        let goes_on = |to: &usize| *to < COLUMNS && is_whole(pair) && is_whole(*to);
        let here = light_of(pair);
        let before = pair.checked_sub(2).filter(goes_on).map(light_of);
        let after = Some(pair + 2).filter(goes_on).map(light_of);
        let side = if column == pair { -1.0 } else { 1.0 };
        let light = std::array::from_fn(|k| {
            let (fall, rise) = (before.map(|b| here[k] - b[k]), after.map(|a| a[k] - here[k]));
            let slope = if side < 0.0 { fall.or(rise) } else { rise.or(fall) }.unwrap_or(Vec3::ZERO);
            (here[k] + slope * 0.25 * side).max(Vec3::ZERO)
        });
        let is_in_both = part.share(row, pair) > 0.0 && part.share(row, pair + 1) > 0.0;
        let [u, v] = part.middle(row, pair..pair + 2);
        let aside = if is_in_both { 0.5 * f64::from(side) } else { 0.0 };
        (self.albedo(s, &self.point(s, [u + aside, v])), light)
    }

    /// The visibility of the sky at an image point of a block.
    fn open_in_block(&self, part: &Part, s: &Surface<'_>, [u, v]: [f64; 2]) -> SkyVisibility {
        let first = [part.left as f64 + MIDDLE, part.top as f64 + MIDDLE];
        // One of the pixels, in the middle of the columns.
        let columns = || (0..COLUMNS).filter(|column| (0..ROWS).any(|row| part.share(row, *column) > 0.0));
        let middle = (columns().min().unwrap_or(0) + columns().max().unwrap_or(0)) / 2;
        let column = columns().find(|column| *column >= middle).unwrap_or(middle);
        let row = (0..ROWS).find(|row| part.share(*row, column) > 0.0).unwrap_or(0);
        let one = self.point(s, [first[0] + column as f64, first[1] + row as f64]);
        if pixels().map(|(row, column)| part.share(row, column)).sum::<f32>() <= FEW {
            return self.open(s, &one);
        }
        let (across, down) = (((u - first[0]) / COLUMNS as f64) as f32, ((v - first[1]) / ROWS as f64) as f32);
        let mut sum = [0.0; 6];
        for (i, j) in [(0, 0), (1, 0), (0, 1), (1, 1)] {
            let corner = [first[0] + (i * COLUMNS) as f64, first[1] + (j * ROWS) as f64];
            // The plane may end, or rise to the eye, before the corner.
            let corner = self.point_within(s, corner, [0.5, 2.0].map(|k| k * f64::from(one.depth_m)));
            let weight = (if i == 1 { across } else { 1.0 - across }) * if j == 1 { down } else { 1.0 - down };
            for (sum, open) in sum.iter_mut().zip(self.open(s, &corner)) {
                *sum += weight * open;
            }
        }
        sum
    }
}
