//! What every sample of an image sees, as the number of a drawn face (the "visibility buffer" of Burns and Hunt, JCGT
//! 2013), transparent surfaces apart from opaque ones.

use std::ops::Range;

use crate::sense::grids::Window;
use crate::wide_registers::array_of;
use cadet_base::math::{DVec3, lesser};

/// Samples along a side of a block.
pub const BLOCK: usize = 8;
/// How much nearer than a bound's inverse depth a sample must be to hide what the bound stands for.
pub(super) const CLEARLY_NEARER_RATIO: f32 = 1.000_01;

/// A face that was drawn.
#[derive(Debug, Clone, Copy)]
pub struct DrawnFace {
    /// Index into [`crate::sense::PosedScene::instances`].
    pub instance: u32,
    /// Face of the instance's mesh; the first of two that are drawn as one ([`cadet_base::geometry::ClusterPiece`]).
    pub face: u32,
    /// It was drawn with its partner.
    pub is_quad: bool,
    /// Its plane in the camera's frame: z = volume / (normal · (x, y, 1)).
    pub(super) normal: [f64; 3],
    pub(super) volume6_m3: f64,
}

impl DrawnFace {
    /// z in meters of the face's plane at x / z, y / z.
    #[inline]
    #[must_use]
    pub fn depth_m_at(&self, x: f64, y: f64) -> f32 {
        self.exact_depth_m_at(x, y) as f32
    }

    /// As [`DrawnFace::depth_m_at`], in double precision.
    #[inline]
    #[must_use]
    pub fn exact_depth_m_at(&self, x: f64, y: f64) -> f64 {
        let [a, b, c] = self.normal;
        self.volume6_m3 / (a * x + (b * y + c))
    }

    /// The unit normal of the face's plane on the camera's side, in the camera's frame.
    #[must_use]
    pub fn normal_cam(&self) -> DVec3 {
        let away = DVec3::from_array(self.normal) * self.volume6_m3;
        -away / away.length()
    }

    /// 1 / z of the face's plane at pixel (0, 0), and its changes to the next column and row, for a camera's fx, fy, cx, cy.
    #[must_use]
    pub fn inverse_depth_per_m_on_image(&self, [fx, fy, cx, cy]: [f64; 4]) -> [f64; 3] {
        let inverse = 1.0 / self.volume6_m3;
        let (by_column, by_row) = (self.normal[0] * inverse / fx, self.normal[1] * inverse / fy);
        [self.normal[2] * inverse - by_column * cx - by_row * cy, by_column, by_row]
    }
}

/// The nearest surface of one kind at the samples of a block, row by row.
#[derive(Debug, Clone)]
pub struct Block {
    /// 1 / z in 1/m, 0 where there is none.
    pub inverse_depth_per_m: [[f32; BLOCK]; BLOCK],
    /// The number of the face in [`VisibilityBuffer::faces`]; means nothing where the inverse depth is 0.
    pub face: [[u32; BLOCK]; BLOCK],
}

impl Block {
    /// Reads something of each cache line.
    #[inline]
    #[must_use]
    pub fn prefetch(&self) -> u32 {
        let line = |row: usize| self.inverse_depth_per_m[row][0].to_bits() ^ self.face[row][0];
        line(0) ^ line(2) ^ line(4) ^ line(6)
    }

    /// The number of the face that a sample sees first, of two layers of a block, and its inverse depth; `None` for the sky.
    #[inline(always)]
    #[must_use]
    pub fn front(opaque: &Self, transparent: Option<&Self>, row: usize, column: usize) -> Option<(u32, f32)> {
        let at = |layer: &Self| (layer.face[row][column], layer.inverse_depth_per_m[row][column]);
        let (mut number, mut inverse_depth) = at(opaque);
        if let Some((other, nearer)) = transparent.map(at).filter(|(_, other)| *other > inverse_depth) {
            (number, inverse_depth) = (other, nearer);
        }
        (inverse_depth > 0.0).then_some((number, inverse_depth))
    }

    pub(super) const EMPTY: Self = Self { inverse_depth_per_m: [[0.0; BLOCK]; BLOCK], face: [[0; BLOCK]; BLOCK] };
}

/// What the samples of an image see, in blocks of 8 x 8: neighbors stand together in memory, and what lies behind a
/// whole block is found with one comparison.
#[derive(Debug, Default)]
pub struct VisibilityBuffer {
    /// Rows of samples.
    pub rows: usize,
    /// Columns of samples.
    pub columns: usize,
    /// Blocks side by side.
    pub blocks_across: usize,
    /// The faces that were drawn, seen or not.
    pub faces: Vec<DrawnFace>,
    /// Opaque surfaces; means nothing where nothing has been met.
    opaque: Vec<Block>,
    /// Transparent surfaces of the few blocks that have any; those from `num_transparent` on are free.
    transparent: Vec<Block>,
    /// Where a block's transparent surfaces are, or [`NONE`].
    transparent_of: Vec<u32>,
    /// How many blocks have some.
    num_transparent: u32,
    pub(super) states: Vec<BlockState>,
    /// The number of the face that all of a block's opaque samples see, or [`SEVERAL`].
    only: Vec<u32>,
}

/// No number of a face.
const SEVERAL: u32 = u32::MAX;
/// No transparent surfaces.
const NONE: u32 = u32::MAX;
/// What a block sees where nothing was drawn.
static NOTHING: Block = Block::EMPTY;

/// State of a block's opaque samples.
#[derive(Debug, Clone, Copy, Default)]
pub(super) struct BlockState {
    /// Samples that have met something, a bit each: column by column, from the top.
    pub met: u64,
    /// An inverse depth that all samples reach.
    pub least_inverse_depth_per_m: f32,
    /// The least inverse depth may have risen.
    pub is_stale: bool,
}

/// The rows, or the columns, that a block has of a range which it meets, counted from its own first.
#[inline(always)]
pub(super) fn within_block(range: &Range<usize>, block: usize) -> Range<usize> {
    let first = block * BLOCK;
    range.start.max(first) - first..range.end.min(first + BLOCK) - first
}

/// The bits of a block's samples in [`BlockState::met`].
#[inline(always)]
fn bits_of(rows: &Range<usize>, columns: &Range<usize>) -> u64 {
    // Ranges are not empty and end at `BLOCK` at most.
    let of_column = (u64::MAX >> (64 - (rows.end - rows.start))) << rows.start & 0xFF;
    let columns = (u64::MAX >> (64 - BLOCK * (columns.end - columns.start))) << (BLOCK * columns.start);
    (of_column * 0x0101_0101_0101_0101) & columns
}

impl VisibilityBuffer {
    /// Makes room for an image and forgets what was seen; memory is used again.
    pub(super) fn reset(&mut self, rows: usize, columns: usize) {
        let (down, across) = (rows.div_ceil(BLOCK), columns.div_ceil(BLOCK));
        (self.rows, self.columns, self.blocks_across) = (rows, columns, across);
        let blocks = down * across;
        self.faces.clear();
        // Blocks are emptied when they are first drawn on.
        self.opaque.resize(blocks, Block::EMPTY);
        self.only.resize(blocks, SEVERAL);
        self.transparent_of.clear();
        self.transparent_of.resize(blocks, NONE);
        self.num_transparent = 0;
        self.states.clear();
        self.states.resize(blocks, BlockState::default());
    }

    /// The opaque surfaces of a block.
    #[inline]
    #[must_use]
    pub fn opaque(&self, block: usize) -> &Block {
        if self.states[block].met == 0 { &NOTHING } else { &self.opaque[block] }
    }

    /// The transparent surfaces of a block, if it has any; those behind opaque ones count as absent.
    #[inline]
    #[must_use]
    pub fn transparent(&self, block: usize) -> Option<&Block> {
        self.transparent.get(self.transparent_of[block] as usize)
    }

    /// The number of the face that all of a block's samples see, if it has no transparent surfaces.
    #[inline]
    #[must_use]
    pub fn only_face(&self, block: usize) -> Option<u32> {
        let only = self.only[block];
        (only != SEVERAL && self.states[block].met != 0 && self.transparent_of[block] == NONE).then_some(only)
    }

    /// Number of blocks.
    #[inline]
    #[must_use]
    pub fn num_blocks(&self) -> usize {
        self.states.len()
    }

    /// A block to draw on; see [`VisibilityBuffer::note_drawn`].
    #[inline(always)]
    pub(super) fn block_mut(&mut self, block: usize, is_transparent: bool) -> &mut Block {
        let (layer, index, is_fresh) = if is_transparent {
            let known = self.transparent_of[block];
            // The next free one, which becomes the block's when something is drawn on it.
            let index = known.min(self.num_transparent) as usize;
            if index == self.transparent.len() {
                self.transparent.push(Block::EMPTY);
            }
            (&mut self.transparent, index, known == NONE)
        } else {
            (&mut self.opaque, block, self.states[block].met == 0)
        };
        let block = &mut layer[index];
        if is_fresh {
            block.inverse_depth_per_m = Block::EMPTY.inverse_depth_per_m;
        }
        block
    }

    /// Notes what a block's samples see now: face `id` where bits are set, as in [`BlockState::met`].
    #[inline(always)]
    pub(super) fn note_drawn(&mut self, block: usize, is_transparent: bool, id: u32, drawn: u64) {
        if drawn == 0 {
            return;
        }
        if is_transparent {
            if self.transparent_of[block] == NONE {
                self.transparent_of[block] = self.num_transparent;
                self.num_transparent += 1;
            }
        } else {
            let state = &mut self.states[block];
            state.met |= drawn;
            state.is_stale = true;
            self.only[block] = if drawn == u64::MAX { id } else { SEVERAL };
        }
    }

    /// True if all samples of a block have met something opaque that is nearer than `z_m`.
    #[inline(always)]
    pub(super) fn is_block_hidden(&mut self, block: usize, z_m: f32) -> bool {
        let state = &mut self.states[block];
        if state.least_inverse_depth_per_m * z_m > CLEARLY_NEARER_RATIO {
            return true;
        }
        if !state.is_stale || state.met != u64::MAX {
            return false;
        }
        let mut least = [f32::INFINITY; BLOCK];
        for row in &self.opaque[block].inverse_depth_per_m {
            least = array_of(|i| lesser(row[i], least[i]));
        }
        state.is_stale = false;
        state.least_inverse_depth_per_m = least.into_iter().fold(f32::INFINITY, |least, value| lesser(value, least));
        state.least_inverse_depth_per_m * z_m > CLEARLY_NEARER_RATIO
    }

    /// True if all samples of a window have met something opaque that is nearer than `z_m` (a depth below that of
    /// every point in question).
    #[inline(always)]
    pub(super) fn is_hidden(&mut self, window: &Window, z_m: f32) -> bool {
        for block_row in window.rows.start / BLOCK..=(window.rows.end - 1) / BLOCK {
            let rows = within_block(&window.rows, block_row);
            for block_column in window.columns.start / BLOCK..=(window.columns.end - 1) / BLOCK {
                let block = block_row * self.blocks_across + block_column;
                if self.states[block].least_inverse_depth_per_m * z_m > CLEARLY_NEARER_RATIO {
                    continue;
                }
                let columns = within_block(&window.columns, block_column);
                let window_bits = bits_of(&rows, &columns);
                if window_bits & !self.states[block].met != 0 {
                    return false;
                }
                if self.is_block_hidden(block, z_m) {
                    continue;
                }
                if window_bits == u64::MAX {
                    return false;
                }
                for row in &self.opaque[block].inverse_depth_per_m[rows.clone()] {
                    let mut open = [0; BLOCK];
                    for i in 0..BLOCK {
                        let is_within = (i as u32).wrapping_sub(columns.start as u32) < columns.len() as u32;
                        open[i] = u32::from(row[i] * z_m <= CLEARLY_NEARER_RATIO) & u32::from(is_within);
                    }
                    if open.iter().fold(0, |all, o| all | o) != 0 {
                        return false;
                    }
                }
            }
        }
        true
    }

    /// The blocks that a window meets, and its rows and columns in each.
    pub fn blocks_within(
        &self,
        rows: Range<usize>,
        columns: Range<usize>,
    ) -> impl Iterator<Item = (usize, Range<usize>, Range<usize>)> {
        let of = |all: &Range<usize>| all.start / BLOCK..all.end.div_ceil(BLOCK);
        of(&rows).flat_map(move |block_row| {
            let (rows, columns) = (within_block(&rows, block_row), columns.clone());
            of(&columns).map(move |block_column| {
                (block_row * self.blocks_across + block_column, rows.clone(), within_block(&columns, block_column))
            })
        })
    }

    #[inline]
    fn block_at(&self, row: usize, column: usize) -> usize {
        row / BLOCK * self.blocks_across + column / BLOCK
    }

    /// The number of the face that a sample sees first, transparent or opaque, and its inverse depth; `None` for the sky.
    #[inline]
    #[must_use]
    pub fn front_number(&self, row: usize, column: usize) -> Option<(u32, f32)> {
        let block = self.block_at(row, column);
        Block::front(self.opaque(block), self.transparent(block), row % BLOCK, column % BLOCK)
    }

    /// The face that a sample sees first and its inverse depth; `None` for the sky.
    #[inline]
    #[must_use]
    pub fn front(&self, row: usize, column: usize) -> Option<(&DrawnFace, f32)> {
        self.front_number(row, column).map(|(number, inverse_depth)| (&self.faces[number as usize], inverse_depth))
    }

    /// How many samples of a row see anything, and the columns from the first of them to the last.
    #[must_use]
    pub fn covered(&self, row: usize) -> (usize, Range<usize>) {
        let (mut count, mut span) = (0, self.columns..0);
        for block_column in 0..self.blocks_across {
            let block = row / BLOCK * self.blocks_across + block_column;
            let opaque = &self.opaque(block).inverse_depth_per_m[row % BLOCK];
            let transparent = self.transparent(block).map(|transparent| &transparent.inverse_depth_per_m[row % BLOCK]);
            // Blocks may reach beyond the image.
            for i in 0..BLOCK.min(self.columns - block_column * BLOCK) {
                if opaque[i] > 0.0 || transparent.is_some_and(|p| p[i] > 0.0) {
                    let column = block_column * BLOCK + i;
                    count += 1;
                    span = span.start.min(column)..column + 1;
                }
            }
        }
        (count, span)
    }
}
