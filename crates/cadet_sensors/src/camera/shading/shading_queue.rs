//! What waits to be shaded by one shader variant: pairs of pixels, grouped by face.
//!
//! A pair is two pixels side by side, as far as they show one face: light and air are found once for both, the texture for each
//! (coarse pixel shading: Vaidyanathan et al., HPG 2014). The pairs that show one face in one block of the image are a fragment
//! group.

use crate::camera::visibility::CoverageMask;
use crate::wide_registers::array_of;

/// Pairs that fill a register: steps go over whole ones.
pub const REGISTER: usize = 16;
/// Pairs that are shaded together.
pub const BATCH_SIZE: usize = 304;
/// Room for runs that end beyond the last pair; arrays a power of two apart would share the sets of the cache.
pub const BATCH_STRIDE: usize = BATCH_SIZE + REGISTER;
/// One number a pair.
pub type BatchScalar = [f32; BATCH_STRIDE];

/// Pairs of pixels side by side in a block, and rows of them.
pub const PAIRS_ACROSS: usize = 4;
pub const PAIRS_DOWN: usize = 4;
/// Bits of a column of pixels in a coverage mask.
const COLUMN_BITS: usize = 2 * PAIRS_DOWN;
/// Number of a block's pixels, for what is seen through its transparent surfaces, row by row.
pub const BACKGROUND_PIXELS: usize = 2 * PAIRS_ACROSS * PAIRS_DOWN;
/// From a row of them to the next.
pub const BACKGROUND_STRIDE: u32 = 2 * PAIRS_ACROSS as u32;

/// What the pairs of one face in one block share.
#[derive(Debug, Clone, Copy)]
pub struct FragmentGroup {
    /// Index of the face.
    pub face: u32,
    /// Index of its ambient terms; see [`super::ambient_cache::AmbientCache::terms`].
    pub ambient: u32,
    /// Pixel to which the color of the block's first pixel is added.
    pub target: u32,
    /// From there to the pixel below.
    pub stride: u32,
    /// Of transparent surfaces: the first of [`BACKGROUND_PIXELS`] pixels that have the colors of what is seen through them.
    pub background: u32,
    /// Image point between the samples of the block's first pixel.
    pub u: f32,
    /// See `u`.
    pub v: f32,
    /// 1 / z there, 1/m, and its change by column and by row.
    pub inverse_depth_per_m: [f32; 3],
    /// What a pixel's color counts, if both samples show the face.
    pub weight: f32,
}

/// Which samples of a pair of pixels show a face, and where it stands in its block.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub struct PixelPair(pub u32);

impl PixelPair {
    /// Bits of the pair's column and row in the block.
    pub const COLUMN: u32 = 3;
    /// See `COLUMN`.
    pub const ROW_SHIFT: u32 = 2;
    /// First and second sample of the left pixel, then of the right one.
    pub const SAMPLES_SHIFT: u32 = 4;
    /// All samples of a pair.
    pub const ALL: u32 = 15;

    #[inline(always)]
    fn new(samples: u32, row: usize, column: usize) -> Self {
        Self(samples << Self::SAMPLES_SHIFT | (row << Self::ROW_SHIFT | column) as u32)
    }
}

/// A fragment group and the pair with which it begins.
#[derive(Debug, Clone, Copy)]
pub struct QueuedGroup {
    pub first_pair: usize,
    pub group: FragmentGroup,
}

/// Fragment groups that wait for one shader variant. Pairs from `count` on mean nothing.
#[derive(Debug, Clone)]
pub struct ShadingQueue {
    pub count: usize,
    pub groups: Vec<QueuedGroup>,
    pub pairs: [u32; BATCH_STRIDE],
}

impl ShadingQueue {
    pub const NONE: Self = Self { count: 0, groups: Vec::new(), pairs: [0; BATCH_STRIDE] };

    /// True if there is no room for another group.
    #[inline]
    pub fn is_full(&self) -> bool {
        self.count > BATCH_SIZE - PAIRS_ACROSS * PAIRS_DOWN
    }

    /// Adds a group. There must be room.
    #[inline]
    pub fn push(&mut self, group: &FragmentGroup, coverage: CoverageMask) {
        let start = self.count.min(BATCH_SIZE - PAIRS_ACROSS * PAIRS_DOWN);
        self.groups.push(QueuedGroup { first_pair: start, group: *group });
        let Some(pairs) = self.pairs[start..].first_chunk_mut::<{ PAIRS_ACROSS * PAIRS_DOWN }>() else { return };
        let columns: [u64; PAIRS_ACROSS] = array_of(|column| coverage >> (2 * COLUMN_BITS * column));
        // Row by row, so that neighbors stand together. Without branches: what is seen cannot be foretold.
        let mut count = 0;
        for row in 0..PAIRS_DOWN {
            for (column, samples) in columns.iter().enumerate() {
                let (left, right) = (samples >> (2 * row) & 3, samples >> (2 * row + COLUMN_BITS) & 3);
                let seen = (left | right << 2) as u32;
                pairs[count % (PAIRS_ACROSS * PAIRS_DOWN)] = PixelPair::new(seen, row, column).0;
                count += usize::from(seen != 0);
            }
        }
        self.count = start + count;
    }

    /// Forgets what waits.
    pub fn clear(&mut self) {
        self.count = 0;
        self.groups.clear();
    }

    /// The pairs of each group, if the first `n` pairs matter.
    #[inline(always)]
    pub fn pairs_of(&self, group: usize, n: usize) -> std::ops::Range<usize> {
        let end = self.groups.get(group + 1).map_or(n, |next| next.first_pair);
        self.groups[group].first_pair..end
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const GROUP: FragmentGroup = FragmentGroup {
        face: 7,
        ambient: 9,
        target: 100,
        stride: 9,
        background: 0,
        u: 40.25,
        v: 3.25,
        inverse_depth_per_m: [0.5, 0.01, 0.02],
        weight: 1.0,
    };

    /// The bit of a sample, the first or the second of a pixel.
    fn sample(column: usize, row: usize, which: usize) -> CoverageMask {
        1 << (8 * column + 2 * row + which)
    }

    #[test]
    fn a_group_has_its_pairs_row_by_row() {
        let mut queue = ShadingQueue::NONE;
        let samples = sample(0, 0, 0) | sample(0, 0, 1) | sample(1, 0, 0) | sample(7, 1, 1) | sample(2, 3, 0);
        queue.push(&GROUP, samples);
        queue.push(&GROUP, CoverageMask::MAX);
        assert_eq!((queue.count, queue.pairs_of(0, 19), queue.pairs_of(1, 19)), (19, 0..3, 3..19));
        let pair = |samples, row, column| PixelPair::new(samples, row, column).0;
        assert_eq!(queue.pairs[..3], [pair(0b0111, 0, 0), pair(0b1000, 1, 3), pair(0b0001, 3, 1)]);
        let all = (0..4).flat_map(|row| (0..4).map(move |column| pair(PixelPair::ALL, row, column)));
        assert!(queue.pairs[3..19].iter().copied().eq(all));
    }

    #[test]
    fn every_sample_is_in_one_pair() {
        for seed in 0..200_u64 {
            let samples = seed.wrapping_mul(0x9E37_79B9_7F4A_7C15) & seed.wrapping_mul(0xD1B5_4A32_D192_ED03);
            let mut queue = ShadingQueue::NONE;
            queue.push(&GROUP, samples);
            let mut back = 0;
            for pair in &queue.pairs[..queue.count] {
                let (column, row) = (pair & PixelPair::COLUMN, pair >> PixelPair::ROW_SHIFT & 3);
                for bit in 0..4 {
                    let is_seen = pair >> PixelPair::SAMPLES_SHIFT >> bit & 1 == 1;
                    let of = sample((2 * column + bit / 2) as usize, row as usize, (bit % 2) as usize);
                    assert_eq!(back & of, 0);
                    back |= if is_seen { of } else { 0 };
                }
            }
            assert_eq!(back, samples);
        }
    }

    #[test]
    fn there_is_room_for_a_group_until_it_is_full() {
        let mut queue = ShadingQueue::NONE;
        while !queue.is_full() {
            let before = queue.count;
            queue.push(&GROUP, CoverageMask::MAX >> 8);
            assert_eq!(queue.count, before + 16);
        }
        assert!(queue.count <= BATCH_SIZE);
    }
}
