//! Which faces a block of the visibility buffer shows, and in which samples.

use macro_rules_attribute::apply;

use crate::sense::{BLOCK, Block, ROW_BITS, bits_by_column};

/// The samples of a block of 8 x 4 pixels, two a pixel, a bit each: column by column, from the top; the first of a pixel, which
/// lies on its center, comes before the second.
pub type CoverageMask = u64;

/// A face that a block shows.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct CoveredFace {
    /// Its number in the visibility buffer.
    pub face: u32,
    /// Not empty.
    pub coverage: CoverageMask,
}

/// The first sample of each column.
const EVERY_COLUMN: CoverageMask = 0x0101_0101_0101_0101;
/// The number of what shows nothing.
pub const SKY: u32 = u32::MAX;
/// The first samples of all pixels.
pub const FIRST_SAMPLES: CoverageMask = 0x5555_5555_5555_5555;

/// The numbers of what a block's samples see, row by row.
pub type Numbers = [u32; BLOCK * BLOCK];

/// A row and the next: a register.
const TWO_ROWS: usize = 2 * BLOCK;

/// The mask of some pixel rows and columns from a block's first on.
#[inline]
pub fn samples_within(rows: usize, columns: usize) -> CoverageMask {
    let all = |bits: usize| if bits < CoverageMask::BITS as usize { (1 << bits) - 1 } else { CoverageMask::MAX };
    let of_column: CoverageMask = all(2 * rows.min(BLOCK / 2));
    (of_column * EVERY_COLUMN) & all(BLOCK * columns.min(BLOCK))
}

/// Both samples of the pixels of which any is set.
#[inline]
pub fn any_of_pixels(samples: CoverageMask) -> CoverageMask {
    let firsts = (samples | samples >> 1) & FIRST_SAMPLES;
    firsts | firsts << 1
}

/// Both samples of the pixels of which both are set.
#[inline]
pub fn whole_pixels(samples: CoverageMask) -> CoverageMask {
    let firsts = samples & samples >> 1 & FIRST_SAMPLES;
    firsts | firsts << 1
}

/// The set bits, from the lowest on.
pub fn bits_of(mut set: CoverageMask) -> impl Iterator<Item = u32> {
    std::iter::from_fn(move || {
        let bit = set.trailing_zeros();
        set &= set.wrapping_sub(1);
        (bit < CoverageMask::BITS).then_some(bit)
    })
}

/// Where something in a block is at [`Numbers`].
#[inline]
pub fn place_of(sample: u32) -> usize {
    let sample = sample as usize % (BLOCK * BLOCK);
    sample % BLOCK * BLOCK + sample / BLOCK
}

/// Reads a block; returns the pixels' second samples that see another face than the first ones, too.
#[apply(for_wide_registers)]
pub fn read_block(block: &Block) -> (Numbers, CoverageMask) {
    let (inverse_depth, face) = (block.inverse_depth_per_m.as_flattened(), block.face.as_flattened());
    let mut numbers = [SKY; BLOCK * BLOCK];
    for i in 0..BLOCK * BLOCK {
        numbers[i] = if inverse_depth[i] > 0.0 { face[i] } else { SKY };
    }
    let mut differ = [0; TWO_ROWS];
    for two_rows in 0..BLOCK / 2 {
        let at = two_rows * TWO_ROWS;
        for i in 0..BLOCK {
            let (a, b) = (numbers[at + i], numbers[at + BLOCK + i]);
            let is = (a != b) & (a != SKY) & (b != SKY);
            differ[BLOCK + i] |= u32::from(is) << (2 * two_rows + 1);
        }
    }
    (numbers, bits_by_column(&differ))
}

/// Where the samples of one block are nearer than those of another.
#[apply(for_wide_registers)]
pub fn where_nearer(block: &Block, than: &Block) -> CoverageMask {
    let (a, b) = (block.inverse_depth_per_m.as_flattened(), than.inverse_depth_per_m.as_flattened());
    let mut found = [0; TWO_ROWS];
    for two_rows in 0..BLOCK / 2 {
        let at = two_rows * TWO_ROWS;
        for i in 0..TWO_ROWS {
            found[i] |= u32::from(a[at + i] > b[at + i]).wrapping_neg() & (ROW_BITS[i] << (2 * two_rows));
        }
    }
    bits_by_column(&found)
}

/// Adds the faces that some samples show, in the order of their first samples; returns the samples that see nothing.
#[apply(for_wide_registers)]
pub fn split_by_face(numbers: &Numbers, of: CoverageMask, covered: &mut Vec<CoveredFace>) -> CoverageMask {
    let (mut left, mut sky) = (of, 0);
    while left != 0 {
        let face = numbers[place_of(left.trailing_zeros())];
        let mut found = [0; TWO_ROWS];
        for two_rows in 0..BLOCK / 2 {
            let at = two_rows * TWO_ROWS;
            for i in 0..TWO_ROWS {
                found[i] |= u32::from(numbers[at + i] == face).wrapping_neg() & (ROW_BITS[i] << (2 * two_rows));
            }
        }
        let samples = bits_by_column(&found) & left;
        left &= !samples;
        if face == SKY {
            sky = samples;
        } else {
            covered.push(CoveredFace { face, coverage: samples });
        }
    }
    sky
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A block whose samples see one of a few faces or nothing.
    fn block(seed: u32) -> Block {
        let mut block = Block { inverse_depth_per_m: [[0.0; BLOCK]; BLOCK], face: [[99; BLOCK]; BLOCK] };
        for row in 0..BLOCK {
            for column in 0..BLOCK {
                let n = (seed + 13 * row as u32 + 7 * column as u32).wrapping_mul(2_654_435_761) >> 29;
                if n < 6 {
                    (block.inverse_depth_per_m[row][column], block.face[row][column]) = (0.1 + n as f32, n);
                }
            }
        }
        block
    }

    fn bit(row: usize, column: usize) -> CoverageMask {
        1 << (BLOCK * column + row)
    }

    #[test]
    fn every_sample_is_of_one_face_or_sky() {
        for seed in 0..300 {
            let (block, mut covered) = (block(seed), vec![CoveredFace { face: 77, coverage: 1 }]);
            let (numbers, differ) = read_block(&block);
            let of = samples_within(1 + seed as usize % 4, 1 + seed as usize % 8);
            let sky = split_by_face(&numbers, of, &mut covered);
            assert_eq!(covered.remove(0), CoveredFace { face: 77, coverage: 1 });
            for row in 0..BLOCK {
                for column in 0..BLOCK {
                    let sample = bit(row, column);
                    let is_within = row / 2 <= seed as usize % 4 && column <= seed as usize % 8;
                    assert_eq!(of & sample != 0, is_within);
                    let is_sky = block.inverse_depth_per_m[row][column] == 0.0;
                    assert_eq!(sky & sample != 0, is_within && is_sky);
                    let faces: Vec<u32> = covered.iter().filter(|p| p.coverage & sample != 0).map(|p| p.face).collect();
                    let want = if is_within && !is_sky { vec![block.face[row][column]] } else { Vec::new() };
                    assert_eq!(faces, want);
                    let (a, b) = (numbers[row / 2 * 16 + column], numbers[row / 2 * 16 + 8 + column]);
                    let is_other = row % 2 == 1 && a != b && a != SKY && b != SKY;
                    assert_eq!(differ & sample != 0, is_other);
                    assert_eq!(place_of(sample.trailing_zeros()), row * BLOCK + column);
                }
            }
        }
    }

    #[test]
    fn pixels_with_nearer_samples_are_found() {
        let (front, back) = (block(3), block(5));
        let found = where_nearer(&front, &back);
        assert_eq!(bits_of(found).fold(0, |all, bit| all | 1 << bit), found);
        for row in 0..BLOCK {
            for column in 0..BLOCK {
                let is_nearer =
                    |row: usize| front.inverse_depth_per_m[row][column] > back.inverse_depth_per_m[row][column];
                assert_eq!(found & bit(row, column) != 0, is_nearer(row));
                let either = is_nearer(row / 2 * 2) || is_nearer(row / 2 * 2 + 1);
                assert_eq!(any_of_pixels(found) & bit(row, column) != 0, either);
                let both = is_nearer(row / 2 * 2) && is_nearer(row / 2 * 2 + 1);
                assert_eq!(whole_pixels(found) & bit(row, column) != 0, both);
            }
        }
    }
}
