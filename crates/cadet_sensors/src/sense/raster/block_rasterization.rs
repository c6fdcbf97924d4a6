//! Draws one triangle or quadrilateral on one block of the visibility buffer.
//!
//! Samples are told apart in single precision, from the block's middle; those too near to an edge for that, and
//! triangles too steep for it, are looked at with the kernel's own test in double precision, so that the outcome is the
//! same as if all were.

use std::ops::Range;

use macro_rules_attribute::apply;

use super::depth_test::{ROW_BITS, any, bits_by_column, keep_nearer, mask};
use super::outline::FacePlanes;
use super::visibility_buffer::{BLOCK, Block, DrawnFace};
use crate::sense::grids::PinholeGrid;
use crate::wide_registers::array_of;
use cadet_base::math::{DVec3, greater, lesser};

/// The most edges.
const EDGES: usize = 4;

/// Values at a place of the functions that are affine on the image.
#[derive(Clone, Copy)]
pub(super) struct AffineValues {
    /// How far inside of each edge, in samples.
    edges: [f32; EDGES],
    /// 1/m.
    inverse_depth: f32,
}

/// A row and the next.
type TwoRows = [f32; 2 * BLOCK];

/// From a block's middle to its first sample, columns or rows.
const HALF: f32 = (BLOCK - 1) as f32 / 2.0;
/// Of a block's columns, from half a column left of the first: no two of them are opposite, as the compiler would halve
/// the registers.
const COLUMNS: TwoRows = [0.5, 1.5, 2.5, 3.5, 4.5, 5.5, 6.5, 7.5, 0.5, 1.5, 2.5, 3.5, 4.5, 5.5, 6.5, 7.5];
/// Samples nearer to an edge than this, in samples, are looked at exactly: ten times what single precision errs there.
const DOUBT: f32 = 1e-5;
/// Edges so far from the middle of the image, in samples, are looked at exactly.
const FAR: f64 = 1e8;
/// How often the least inverse depth that is drawn may be contained in the block's; what is steeper is computed exactly.
const STEEP: f32 = 4.0;

/// A triangle or a flat convex quadrilateral as functions that are affine on the image: how far a sample lies inside of
/// each edge, in samples, and its inverse depth, 1/m.
pub(super) struct FaceOnImage {
    /// Towards the inside, not scaled.
    edges: [DVec3; EDGES],
    is_quad: bool,
    /// Turned towards the camera, and volume: inverse depth = normal · (x, y, 1) / volume.
    normal: DVec3,
    volume6_m3: f64,
    /// Of the edges, by x / z, by y / z, and the rest.
    by_x: [f64; EDGES],
    by_y: [f64; EDGES],
    rest: [f64; EDGES],
    /// Of the inverse depth.
    inverse_depth: [f64; 3],
    /// By column and by row.
    across: AffineValues,
    down: AffineValues,
    /// What changes at most from a block's middle to its samples.
    reach: AffineValues,
    /// An inverse depth that all of the face reaches.
    least_inverse_depth: f32,
    /// Half of how far the samples of odd rows lie further right, columns.
    shift: f32,
    /// Single precision tells on which side of the edges samples lie.
    is_plain: bool,
}

impl FaceOnImage {
    /// The functions of a face; `None` if the camera lies in its plane.
    ///
    /// `most_z_m`: the largest z of its corners, to a thousandth.
    #[inline(always)]
    pub(super) fn new(outline: &FacePlanes, grid: &PinholeGrid, most_z_m: f32) -> Option<Self> {
        if outline.volume6_m3 == 0.0 {
            return None;
        }
        let sign = if outline.volume6_m3 > 0.0 { 1.0 } else { -1.0 };
        let edges: [DVec3; EDGES] = array_of(|k| outline.edges[k] * sign);
        let normal = outline.normal * sign;
        let volume = outline.volume6_m3.abs();
        let [a, b, c, d] = edges;
        let (mut by_x, mut by_y) = ([a.x, b.x, c.x, d.x], [a.y, b.y, c.y, d.y]);
        let mut rest = [a.z, b.z, c.z, d.z];
        let (column, row) = (1.0 / grid.column_scale, 1.0 / grid.row_scale);
        let (shift, half) = (grid.odd_shift_columns * 0.5, f64::from(HALF));
        let mut most = [0.0; EDGES];
        let (mut across, mut down, mut reach) = ([0.0_f32; EDGES], [0.0_f32; EDGES], [0.0_f32; EDGES]);
        for k in 0..EDGES {
            let (x, y) = ((by_x[k] * column).abs(), (by_y[k] * row).abs());
            let scale = 1.0 / if x > y { x } else { y };
            by_x[k] *= scale;
            by_y[k] *= scale;
            rest[k] *= scale;
            most[k] = by_x[k].abs() + by_y[k].abs() + rest[k].abs();
            let (x, y) = (by_x[k] * column, by_y[k] * row);
            (across[k], down[k]) = (x as f32, y as f32);
            reach[k] = ((x.abs() * (half + shift) + y.abs() * half) * 1.000_01) as f32;
        }
        // Not where any is NaN.
        let is_plain = most.iter().all(|most| *most < FAR);
        let inverse_depth = (normal * (1.0 / volume)).to_array();
        let (x, y) = (inverse_depth[0] * column, inverse_depth[1] * row);
        let reach_near = ((x.abs() * (half + shift) + y.abs() * half) * 1.000_01) as f32;
        Some(Self {
            edges,
            is_quad: outline.is_quad,
            normal,
            volume6_m3: volume,
            by_x,
            by_y,
            rest,
            inverse_depth,
            across: AffineValues { edges: across, inverse_depth: x as f32 },
            down: AffineValues { edges: down, inverse_depth: y as f32 },
            reach: AffineValues { edges: reach, inverse_depth: reach_near },
            least_inverse_depth: 1.0 / most_z_m,
            shift: shift as f32,
            is_plain,
        })
    }

    /// The record that is kept of a drawn face.
    pub(super) fn drawn(&self, [instance, face]: [u32; 2]) -> DrawnFace {
        DrawnFace { instance, face, is_quad: self.is_quad, normal: self.normal.to_array(), volume6_m3: self.volume6_m3 }
    }

    /// The functions at the middle of a block, given by x / z and y / z.
    #[inline(always)]
    pub(super) fn at(&self, x: f64, y: f64) -> AffineValues {
        let mut edges = [0.0; EDGES];
        for k in 0..EDGES {
            edges[k] = (self.by_x[k] * x + (self.by_y[k] * y + self.rest[k])) as f32;
        }
        let [by_x, by_y, rest] = self.inverse_depth;
        AffineValues { edges, inverse_depth: (by_x * x + (by_y * y + rest)) as f32 }
    }

    /// An inverse depth that the face's plane does not reach on a block.
    #[inline(always)]
    pub(super) fn most_inverse_depth_per_m(&self, at: &AffineValues) -> f32 {
        if self.is_flat(at) { at.inverse_depth + self.reach.inverse_depth } else { f32::INFINITY }
    }

    /// True if single precision tells the inverse depth on a block to a millionth.
    #[inline(always)]
    fn is_flat(&self, at: &AffineValues) -> bool {
        let (inverse_depth, reach) = (at.inverse_depth, self.reach.inverse_depth);
        let least = inverse_depth - reach;
        let least = greater(least, self.least_inverse_depth);
        inverse_depth.abs() + reach < STEEP * least
    }

    /// The x / z between which the middles of blocks may lie that the face meets, in a row of blocks whose middles lie at
    /// this y / z.
    #[inline(always)]
    pub(super) fn span(&self, y: f64) -> [f64; 2] {
        let (mut from, mut to) = (f64::NEG_INFINITY, f64::INFINITY);
        if self.is_plain {
            for k in 0..EDGES {
                let least = -f64::from(self.reach.edges[k] + DOUBT) - (self.by_y[k] * y + self.rest[k]);
                // A little more, for rounding.
                let least = least - 1e-6 * (1.0 + least.abs());
                let cut = least / self.by_x[k];
                if self.by_x[k] > 0.0 {
                    from = greater(cut, from);
                } else if self.by_x[k] < 0.0 {
                    to = lesser(cut, to);
                }
            }
        }
        [from, to]
    }

    /// True if no sample of a block lies inside.
    #[inline(always)]
    pub(super) fn misses(&self, at: &AffineValues) -> bool {
        let mut is_outside = false;
        for k in 0..EDGES {
            is_outside |= at.edges[k] + self.reach.edges[k] < -DOUBT;
        }
        self.is_plain & is_outside
    }

    /// Draws the face, as number `id`, on some rows of a block; returns where it is the nearest so far, a bit a sample:
    /// column by column, from the top.
    ///
    /// `at`: see [`FaceOnImage::at`].
    #[inline(always)]
    pub(super) fn draw(
        &self,
        block: &mut Block,
        rows: &Range<usize>,
        at: &AffineValues,
        id: u32,
        exact: &ExactBlock<'_>,
    ) -> u64 {
        if !(self.is_plain & self.is_flat(at)) {
            return self.draw_exactly(block, id, u64::MAX, exact);
        }
        let mut is_inside = true;
        for k in 0..EDGES {
            is_inside &= at.edges[k] - self.reach.edges[k] > DOUBT;
        }
        if is_inside {
            return self.draw_all(block, at, id);
        }
        let (mut nearer, mut doubt) = ([0; 2 * BLOCK], [0; 2 * BLOCK]);
        if self.is_quad {
            draw_within::<4>(self, block, rows, at, id, &mut nearer, &mut doubt);
        } else {
            draw_within::<3>(self, block, rows, at, id, &mut nearer, &mut doubt);
        }
        let drawn = bits_by_column(&nearer);
        if any(&doubt) { drawn | self.draw_exactly(block, id, bits_by_column(&doubt), exact) } else { drawn }
    }

    /// A function in an even row of a block and in the next, and its change two rows down.
    #[inline(always)]
    fn rows(&self, [at, across, down]: [f32; 3], row: usize) -> (TwoRows, f32) {
        let first = at + down * (row as f32 - HALF) - across * (HALF + 0.5);
        let shift = across * self.shift;
        let (even, odd) = (first - shift, first + down + shift);
        let mut values = [0.0; 2 * BLOCK];
        for i in 0..2 * BLOCK {
            let first = if i < BLOCK { even } else { odd };
            values[i] = first + across * COLUMNS[i];
        }
        (values, down * 2.0)
    }

    #[inline(always)]
    fn edge_rows(&self, at: &AffineValues, k: usize, row: usize) -> (TwoRows, f32) {
        self.rows([at.edges[k], self.across.edges[k], self.down.edges[k]], row)
    }

    #[inline(always)]
    fn inverse_depth_rows(&self, at: &AffineValues, row: usize) -> (TwoRows, f32) {
        self.rows([at.inverse_depth, self.across.inverse_depth, self.down.inverse_depth], row)
    }

    /// Draws on a block that lies inside of all edges.
    #[inline(always)]
    fn draw_all(&self, block: &mut Block, at: &AffineValues, id: u32) -> u64 {
        let mut nearer = [0_u32; 2 * BLOCK];
        let (mut value, step) = self.inverse_depth_rows(at, 0);
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
        bits_by_column(&nearer)
    }

    /// Draws the samples whose bits are set by the kernel's test ([`crate::sense::BeamGrid::cover`]), bit for bit.
    #[cold]
    #[inline(never)]
    fn draw_exactly(&self, block: &mut Block, id: u32, mask: u64, exact: &ExactBlock<'_>) -> u64 {
        let mut nearer = 0;
        let inverse = 1.0 / self.volume6_m3;
        for (row, y) in exact.rows_y.iter().enumerate() {
            let rests = self.edges.map(|e| e.y * y + e.z);
            let facing = self.normal.y * y + self.normal.z;
            for (i, x) in exact.columns_x[row % 2].iter().enumerate() {
                let bit = 1 << (BLOCK * i + row);
                if mask & bit == 0 {
                    continue;
                }
                let is_in = (0..EDGES).all(|k| self.edges[k].x * x + rests[k] >= 0.0);
                let value = ((self.normal.x * x + facing) * inverse) as f32;
                let old = &mut block.inverse_depth_per_m[row][i];
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
#[apply(for_wide_registers)]
fn draw_within<const EDGES: usize>(
    face: &FaceOnImage,
    block: &mut Block,
    rows: &Range<usize>,
    at: &AffineValues,
    id: u32,
    nearer: &mut [u32; 2 * BLOCK],
    doubt: &mut [u32; 2 * BLOCK],
) {
    let start = rows.start & !1;
    let mut edges: [(TwoRows, f32); EDGES] = array_of(|k| face.edge_rows(at, k, start));
    let (mut value, value_step) = face.inverse_depth_rows(at, start);
    for row in (start..rows.end.min(BLOCK)).step_by(2) {
        let mut bits = [0; 2 * BLOCK];
        for i in 0..2 * BLOCK {
            let mut least = f32::INFINITY;
            for (inside, _) in &edges {
                least = lesser(least, inside[i]);
            }
            bits[i] = mask(least >= DOUBT) & value[i].to_bits();
            doubt[i] |= mask(least.abs() < DOUBT) & (ROW_BITS[i] << row);
        }
        keep_nearer(block, row, &bits, id, nearer);
        for (inside, step) in &mut edges {
            for v in inside {
                *v += *step;
            }
        }
        for v in &mut value {
            *v += value_step;
        }
    }
}

/// Where the samples of a block lie: x / z of the columns of even and of odd rows, y / z of the rows.
pub(super) struct ExactBlock<'a> {
    pub columns_x: [&'a [f64; BLOCK]; 2],
    pub rows_y: &'a [f64; BLOCK],
}
