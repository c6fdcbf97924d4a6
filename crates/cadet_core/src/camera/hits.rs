//! What waits to be shaded: faces of one shader variant together, lane by lane.
//!
//! A lane is two pixels side by side, as far as they show one face: light and air are found once for both, the texture for each
//! (coarse pixel shading: Vaidyanathan et al., HPG 2014). The lanes that show one face in one block of the image are a patch.

/// Lanes that are shaded together.
pub const LANES: usize = 304;
/// Room for runs that end beyond the last lane; arrays a power of two apart would share the sets of the cache.
pub const STRIDE: usize = LANES + 16;
/// One number a lane.
pub type Lane = [f32; STRIDE];

/// Pairs of pixels side by side in a block, and rows of them.
pub const ACROSS: usize = 4;
pub const DOWN: usize = 4;
/// What is seen through a block's transparent surfaces: its pixels row by row.
pub const BEHIND: usize = 2 * ACROSS * DOWN;
/// From a row of them to the next.
pub const BEHIND_STRIDE: u32 = 2 * ACROSS as u32;

/// The samples of a block of 8 x 4 pixels, two a pixel, a bit each: column by column, from the top; the first of a pixel, which
/// lies on its center, comes before the second.
pub type SampleBits = u64;

/// What the lanes of one face in one block share.
#[derive(Debug, Clone, Copy)]
pub struct Patch {
    /// Index of the face.
    pub face: u32,
    /// Index of the sky's visibility; see [`super::faces::Faces::open`].
    pub open: u32,
    /// Pixel to which the color of the block's first pixel is added.
    pub target: u32,
    /// From there to the pixel below.
    pub stride: u32,
    /// Of transparent surfaces: the first of [`BEHIND`] pixels that have the colors of what is seen through them.
    pub behind: u32,
    /// Image point between the samples of the block's first pixel.
    pub u: f32,
    /// See `u`.
    pub v: f32,
    /// 1 / z there, 1/m, and its change by column and by row.
    pub inverse_depth: [f32; 3],
    /// What a pixel's color counts, if both samples show the face.
    pub weight: f32,
}

/// What of a pair of pixels shows a face, and where it stands in its block.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub struct Cell(pub u32);

impl Cell {
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

/// Patches of one shader variant. Lanes from `count` on mean nothing.
#[derive(Debug, Clone)]
pub struct Hits {
    pub count: usize,
    /// With the lanes in which they begin.
    pub patches: Vec<(usize, Patch)>,
    pub cells: [u32; STRIDE],
}

impl Hits {
    pub const NONE: Self = Self { count: 0, patches: Vec::new(), cells: [0; STRIDE] };

    /// True if there is no room for another patch.
    #[inline]
    pub fn is_full(&self) -> bool {
        self.count > LANES - ACROSS * DOWN
    }

    /// Adds a patch. There must be room.
    #[inline]
    pub fn push(&mut self, patch: &Patch, samples: SampleBits) {
        let start = self.count.min(LANES - ACROSS * DOWN);
        self.patches.push((start, *patch));
        let Some(cells) = self.cells[start..].first_chunk_mut::<{ ACROSS * DOWN }>() else { return };
        let pairs: [u64; ACROSS] = std::array::from_fn(|column| samples >> (16 * column));
        // Row by row, so that neighbors stand together. Without branches: what is seen cannot be foretold.
        let mut count = 0;
        for row in 0..DOWN {
            for (column, pair) in pairs.iter().enumerate() {
                let (left, right) = (pair >> (2 * row) & 3, pair >> (2 * row + 8) & 3);
                let seen = (left | right << 2) as u32;
                cells[count % (ACROSS * DOWN)] = Cell::new(seen, row, column).0;
                count += usize::from(seen != 0);
            }
        }
        self.count = start + count;
    }

    /// Forgets what waits.
    pub fn clear(&mut self) {
        self.count = 0;
        self.patches.clear();
    }

    /// The lanes of each patch, if the first `n` lanes matter.
    #[inline(always)]
    pub fn lanes_of(&self, patch: usize, n: usize) -> std::ops::Range<usize> {
        let end = self.patches.get(patch + 1).map_or(n, |(start, _)| *start);
        self.patches[patch].0..end
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const PATCH: Patch = Patch {
        face: 7,
        open: 9,
        target: 100,
        stride: 9,
        behind: 0,
        u: 40.25,
        v: 3.25,
        inverse_depth: [0.5, 0.01, 0.02],
        weight: 1.0,
    };

    /// The bit of a sample, the first or the second of a pixel.
    fn sample(column: usize, row: usize, which: usize) -> SampleBits {
        1 << (8 * column + 2 * row + which)
    }

    #[test]
    fn the_lanes_of_a_patch_are_its_pairs_row_by_row() {
        let mut hits = Hits::NONE;
        let samples = sample(0, 0, 0) | sample(0, 0, 1) | sample(1, 0, 0) | sample(7, 1, 1) | sample(2, 3, 0);
        hits.push(&PATCH, samples);
        hits.push(&PATCH, SampleBits::MAX);
        assert_eq!((hits.count, hits.lanes_of(0, 19), hits.lanes_of(1, 19)), (19, 0..3, 3..19));
        let cell = |samples, row, column| Cell::new(samples, row, column).0;
        assert_eq!(hits.cells[..3], [cell(0b0111, 0, 0), cell(0b1000, 1, 3), cell(0b0001, 3, 1)]);
        let all = (0..4).flat_map(|row| (0..4).map(move |column| cell(Cell::ALL, row, column)));
        assert!(hits.cells[3..19].iter().copied().eq(all));
    }

    #[test]
    fn every_sample_is_in_one_lane() {
        for seed in 0..200_u64 {
            let samples = seed.wrapping_mul(0x9E37_79B9_7F4A_7C15) & seed.wrapping_mul(0xD1B5_4A32_D192_ED03);
            let mut hits = Hits::NONE;
            hits.push(&PATCH, samples);
            let mut back = 0;
            for cell in &hits.cells[..hits.count] {
                let (column, row) = (cell & Cell::COLUMN, cell >> Cell::ROW_SHIFT & 3);
                for bit in 0..4 {
                    let is_seen = cell >> Cell::SAMPLES_SHIFT >> bit & 1 == 1;
                    let of = sample((2 * column + bit / 2) as usize, row as usize, (bit % 2) as usize);
                    assert_eq!(back & of, 0);
                    back |= if is_seen { of } else { 0 };
                }
            }
            assert_eq!(back, samples);
        }
    }

    #[test]
    fn there_is_room_for_a_patch_until_it_is_full() {
        let mut hits = Hits::NONE;
        while !hits.is_full() {
            let before = hits.count;
            hits.push(&PATCH, SampleBits::MAX >> 8);
            assert_eq!(hits.count, before + 16);
        }
        assert!(hits.count <= LANES);
    }
}
