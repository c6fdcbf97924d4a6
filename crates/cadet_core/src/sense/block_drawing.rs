//! Draws one triangle on one block of the visibility buffer.
//!
//! Samples are told apart in single precision, from the block's middle; those too near to an edge for that, and
//! triangles too steep for it, are looked at with the kernel's own test in double precision, so that the outcome is the
//! same as if all were.

use std::ops::Range;

use multiversion::multiversion;

use super::edges::EdgePlanes;
use super::pinhole::PinholeGrid;
use super::visibility_buffer::{BLOCK, Block, DrawnFace};
use crate::math::DVec3;

/// The three edges and, last, the nearness.
const WAYS: usize = 4;
const NEARNESS: usize = 3;
type Ways = [f32; WAYS];

/// A row and the next.
type TwoRows = [f32; 2 * BLOCK];
/// Their bits, before they are shifted to the row.
const ROW_BITS: [u32; 2 * BLOCK] = [1, 1, 1, 1, 1, 1, 1, 1, 2, 2, 2, 2, 2, 2, 2, 2];

/// From a block's middle to its first sample, columns or rows.
const HALF: f32 = (BLOCK - 1) as f32 / 2.0;
/// Of a block's columns, from half a column left of the first: no two of them are opposite, as the compiler would halve
/// the registers.
const COLUMNS: TwoRows = [0.5, 1.5, 2.5, 3.5, 4.5, 5.5, 6.5, 7.5, 0.5, 1.5, 2.5, 3.5, 4.5, 5.5, 6.5, 7.5];
/// Samples nearer to an edge than this, in samples, are looked at exactly: ten times what single precision errs there.
const DOUBT: f32 = 1e-5;
/// Edges so far from the middle of the image, in samples, are looked at exactly.
const FAR: f64 = 1e8;
/// How often the least nearness that is drawn may be contained in the block's; what is steeper is computed exactly.
const STEEP: f32 = 4.0;

/// A triangle as four functions that are affine on the image: how far a sample lies inside of each edge, in samples, and
/// its nearness, 1/m.
pub(super) struct FaceOnImage {
    /// Towards the inside, not scaled.
    edges: [DVec3; 3],
    /// Turned towards the camera, and volume: nearness = normal · (x, y, 1) / volume.
    normal: DVec3,
    volume: f64,
    /// By x / z, by y / z, and the rest.
    by_x: [f64; WAYS],
    by_y: [f64; WAYS],
    rest: [f64; WAYS],
    /// By column and by row.
    across: Ways,
    down: Ways,
    /// What changes at most from a block's middle to its samples.
    reach: Ways,
    /// A nearness that all of the triangle reaches.
    least_nearness: f32,
    /// Half of how far the samples of odd rows lie further right, columns.
    shift: f32,
    /// Single precision tells on which side of the edges samples lie.
    is_plain: bool,
}

impl FaceOnImage {
    /// The functions of a triangle; `None` if the camera lies in its plane.
    ///
    /// `most_z_m`: the largest z of its corners, to a thousandth.
    #[inline(always)]
    pub(super) fn new(planes: &EdgePlanes, grid: &PinholeGrid, most_z_m: f32) -> Option<Self> {
        if planes.volume == 0.0 {
            return None;
        }
        let sign = if planes.volume > 0.0 { 1.0 } else { -1.0 };
        let edges = planes.cross.map(|n| n * sign);
        let normal = planes.normal * sign;
        let volume = planes.volume.abs();
        let [a, b, c] = edges;
        let (mut by_x, mut by_y) = ([a.x, b.x, c.x, normal.x], [a.y, b.y, c.y, normal.y]);
        let mut rest = [a.z, b.z, c.z, normal.z];
        let (column, row) = (1.0 / grid.column_scale, 1.0 / grid.row_scale);
        let mut slope = [0.0; WAYS];
        for k in 0..WAYS {
            let (x, y) = ((by_x[k] * column).abs(), (by_y[k] * row).abs());
            slope[k] = if x > y { x } else { y };
        }
        slope[NEARNESS] = volume;
        let mut most = [0.0; WAYS];
        let shift = grid.odd_shift * 0.5;
        let (mut across, mut down, mut reach) = ([0.0; WAYS], [0.0; WAYS], [0.0; WAYS]);
        for k in 0..WAYS {
            let scale = 1.0 / slope[k];
            by_x[k] *= scale;
            by_y[k] *= scale;
            rest[k] *= scale;
            most[k] = by_x[k].abs() + by_y[k].abs() + rest[k].abs();
            let (x, y) = (by_x[k] * column, by_y[k] * row);
            (across[k], down[k]) = (x as f32, y as f32);
            let half = f64::from(HALF);
            reach[k] = ((x.abs() * (half + shift) + y.abs() * half) * 1.000_01) as f32;
        }
        // Not where any is NaN.
        let is_plain = (most[0] < FAR) & (most[1] < FAR) & (most[2] < FAR);
        let (least_nearness, shift) = (1.0 / most_z_m, shift as f32);
        Some(Self { edges, normal, volume, by_x, by_y, rest, across, down, reach, least_nearness, shift, is_plain })
    }

    /// What is kept of a face that was drawn.
    pub(super) fn drawn(&self, [instance, face]: [u32; 2]) -> DrawnFace {
        DrawnFace { instance, face, normal: self.normal.to_array(), volume: self.volume }
    }

    /// The functions at the middle of a block, given by x / z and y / z.
    #[inline(always)]
    pub(super) fn at(&self, x: f64, y: f64) -> Ways {
        let mut at = [0.0; WAYS];
        for k in 0..WAYS {
            at[k] = (self.by_x[k] * x + (self.by_y[k] * y + self.rest[k])) as f32;
        }
        at
    }

    /// A nearness that the triangle's plane does not reach on a block.
    #[inline(always)]
    pub(super) fn most_nearness(&self, at: &Ways) -> f32 {
        if self.is_flat(at) { at[NEARNESS] + self.reach[NEARNESS] } else { f32::INFINITY }
    }

    /// True if single precision tells the nearness on a block to a millionth.
    #[inline(always)]
    fn is_flat(&self, at: &Ways) -> bool {
        let (nearness, reach) = (at[NEARNESS], self.reach[NEARNESS]);
        let least = nearness - reach;
        let least = if least > self.least_nearness { least } else { self.least_nearness };
        nearness.abs() + reach < STEEP * least
    }

    /// The x / z between which the middles of blocks may lie that the triangle meets, in a row of blocks whose middles
    /// lie at this y / z.
    #[inline(always)]
    pub(super) fn span(&self, y: f64) -> [f64; 2] {
        let (mut from, mut to) = (f64::NEG_INFINITY, f64::INFINITY);
        if self.is_plain {
            for k in 0..NEARNESS {
                let least = -f64::from(self.reach[k] + DOUBT) - (self.by_y[k] * y + self.rest[k]);
                // A little more, for rounding.
                let least = least - 1e-6 * (1.0 + least.abs());
                let cut = least / self.by_x[k];
                if self.by_x[k] > 0.0 {
                    from = if cut > from { cut } else { from };
                } else if self.by_x[k] < 0.0 {
                    to = if cut < to { cut } else { to };
                }
            }
        }
        [from, to]
    }

    /// True if no sample of a block lies inside.
    #[inline(always)]
    pub(super) fn misses(&self, at: &Ways) -> bool {
        let outside = |k: usize| at[k] + self.reach[k] < -DOUBT;
        self.is_plain && (outside(0) | outside(1) | outside(2))
    }

    /// Draws the triangle, as face `id`, on some rows of a block; returns where it is the nearest so far, a bit a sample:
    /// column by column, from the top.
    ///
    /// `at`: see [`FaceOnImage::at`].
    #[inline(always)]
    pub(super) fn draw(
        &self,
        block: &mut Block,
        rows: &Range<usize>,
        at: &Ways,
        id: u32,
        exact: &ExactBlock<'_>,
    ) -> u64 {
        if !(self.is_plain & self.is_flat(at)) {
            return self.draw_exactly(block, id, u64::MAX, exact);
        }
        let inside = |k: usize| at[k] - self.reach[k] > DOUBT;
        if inside(0) & inside(1) & inside(2) {
            return self.draw_all(block, at, id);
        }
        let (mut nearer, mut doubt) = ([0; 2 * BLOCK], [0; 2 * BLOCK]);
        draw_within(self, block, rows, at, id, &mut nearer, &mut doubt);
        let drawn = bits(&nearer);
        if any(&doubt) { drawn | self.draw_exactly(block, id, bits(&doubt), exact) } else { drawn }
    }

    /// The function `k` in an even row of a block and in the next, and its change two rows down.
    #[inline(always)]
    fn rows(&self, at: &Ways, k: usize, row: usize) -> (TwoRows, f32) {
        let first = at[k] + self.down[k] * (row as f32 - HALF) - self.across[k] * (HALF + 0.5);
        let (odd, shift) = (self.down[k], self.across[k] * self.shift);
        let (even, odd) = (first - shift, first + odd + shift);
        let mut values = [0.0; 2 * BLOCK];
        for i in 0..2 * BLOCK {
            let first = if i < BLOCK { even } else { odd };
            values[i] = first + self.across[k] * COLUMNS[i];
        }
        (values, self.down[k] * 2.0)
    }

    /// Draws on a block that lies inside of all edges.
    #[inline(always)]
    fn draw_all(&self, block: &mut Block, at: &Ways, id: u32) -> u64 {
        let mut nearer = [0_u32; 2 * BLOCK];
        let (mut value, step) = self.rows(at, NEARNESS, 0);
        for row in (0..BLOCK).step_by(2) {
            let mut bits = [0; 2 * BLOCK];
            for i in 0..2 * BLOCK {
                bits[i] = value[i].to_bits();
            }
            keep_nearer(block, row, &bits, id, &mut nearer);
            for v in &mut value {
                *v += step;
            }
        }
        bits(&nearer)
    }

    /// Draws the samples whose bits are set by the kernel's test ([`super::BeamGrid::cover`]), bit for bit.
    #[cold]
    #[inline(never)]
    fn draw_exactly(&self, block: &mut Block, id: u32, asked: u64, exact: &ExactBlock<'_>) -> u64 {
        let mut nearer = 0;
        let inverse = 1.0 / self.volume;
        for (row, y) in exact.rows_y.iter().enumerate() {
            let rests = self.edges.map(|e| e.y * y + e.z);
            let facing = self.normal.y * y + self.normal.z;
            for (i, x) in exact.columns_x[row % 2].iter().enumerate() {
                let bit = 1 << (BLOCK * i + row);
                if asked & bit == 0 {
                    continue;
                }
                let is_in = (0..3).all(|k| self.edges[k].x * x + rests[k] >= 0.0);
                let value = ((self.normal.x * x + facing) * inverse) as f32;
                let old = &mut block.nearness[row][i];
                if is_in && value > *old {
                    (*old, block.face[row][i]) = (value, id);
                    nearer |= bit;
                }
            }
        }
        nearer
    }
}

/// Sets the rows' bits where the triangle is nearer, and where single precision does not tell. Rows are drawn by twos.
///
/// A function of its own, without the packing of bits: so the compiler takes whole registers.
#[multiversion(targets("x86_64+avx512f+avx512bw+avx512dq+avx512vl", "x86_64+avx2"))]
fn draw_within(
    face: &FaceOnImage,
    block: &mut Block,
    rows: &Range<usize>,
    at: &Ways,
    id: u32,
    nearer: &mut [u32; 2 * BLOCK],
    doubt: &mut [u32; 2 * BLOCK],
) {
    let start = rows.start & !1;
    let (mut first, first_step) = face.rows(at, 0, start);
    let (mut second, second_step) = face.rows(at, 1, start);
    let (mut third, third_step) = face.rows(at, 2, start);
    let (mut value, value_step) = face.rows(at, NEARNESS, start);
    for row in (start..rows.end.min(BLOCK)).step_by(2) {
        let mut bits = [0; 2 * BLOCK];
        let mut least = [0.0; 2 * BLOCK];
        for i in 0..2 * BLOCK {
            least[i] = if first[i] < second[i] { first[i] } else { second[i] };
        }
        for i in 0..2 * BLOCK {
            least[i] = if least[i] < third[i] { least[i] } else { third[i] };
        }
        for i in 0..2 * BLOCK {
            bits[i] = mask(least[i] >= DOUBT) & value[i].to_bits();
        }
        for i in 0..2 * BLOCK {
            doubt[i] |= mask(least[i].abs() < DOUBT) & (ROW_BITS[i] << row);
        }
        keep_nearer(block, row, &bits, id, nearer);
        for (values, step) in
            [(&mut first, first_step), (&mut second, second_step), (&mut third, third_step), (&mut value, value_step)]
        {
            for v in values {
                *v += step;
            }
        }
    }
}

/// Where the samples of a block lie: x / z of the columns of even and of odd rows, y / z of the rows.
pub(super) struct ExactBlock<'a> {
    pub columns_x: [&'a [f64; BLOCK]; 2],
    pub rows_y: &'a [f64; BLOCK],
}

/// Keeps what is nearer in an even row and the next: `bits` are those of positive numbers, or 0.
///
/// Numbers are compared by their bits: the compiler would make slow masked stores of a choice.
#[inline(always)]
fn keep_nearer(block: &mut Block, row: usize, bits: &[u32; 2 * BLOCK], id: u32, nearer: &mut [u32; 2 * BLOCK]) {
    let (Some(nearness), Some(face)) = (
        block.nearness.as_flattened_mut()[row * BLOCK..].first_chunk_mut::<{ 2 * BLOCK }>(),
        block.face.as_flattened_mut()[row * BLOCK..].first_chunk_mut::<{ 2 * BLOCK }>(),
    ) else {
        return;
    };
    // One step a loop: so the compiler takes whole registers. `map` might become a function of its own.
    let (mut old, old_ids) = ([0; 2 * BLOCK], *face);
    for i in 0..2 * BLOCK {
        old[i] = nearness[i].to_bits();
    }
    let (mut is_nearer, mut new, mut new_ids) = ([0; 2 * BLOCK], [0.0; 2 * BLOCK], [0; 2 * BLOCK]);
    for i in 0..2 * BLOCK {
        is_nearer[i] = (old[i].wrapping_sub(bits[i]) as i32 >> 31) as u32;
    }
    for i in 0..2 * BLOCK {
        new[i] = f32::from_bits(if bits[i] > old[i] { bits[i] } else { old[i] });
    }
    for i in 0..2 * BLOCK {
        new_ids[i] = (id ^ old_ids[i]) & is_nearer[i] ^ old_ids[i];
    }
    for i in 0..2 * BLOCK {
        nearer[i] |= is_nearer[i] & (ROW_BITS[i] << row);
    }
    (*nearness, *face) = (new, new_ids);
}

#[inline(always)]
fn mask(is: bool) -> u32 {
    u32::from(is).wrapping_neg()
}

#[inline(always)]
fn any(lanes: &[u32; 2 * BLOCK]) -> bool {
    lanes.iter().fold(0, |all, lane| all | lane) != 0
}

/// The low bytes of columns, of even and of odd rows; the others must be 0.
#[inline(never)]
fn bits(lanes: &[u32; 2 * BLOCK]) -> u64 {
    const SHIFTS: [u32; BLOCK] = [0, 8, 16, 24, 0, 8, 16, 24];
    let mut placed = [0; BLOCK];
    for i in 0..BLOCK {
        placed[i] = (lanes[i] | lanes[BLOCK + i]) << SHIFTS[i];
    }
    let [a, b, c, d, e, f, g, h] = placed;
    u64::from((a | b) | (c | d)) | u64::from((e | f) | (g | h)) << 32
}
