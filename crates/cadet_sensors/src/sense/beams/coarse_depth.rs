//! A coarse map of how far beams have come, which tells what is hidden.

use crate::sense::grids::{BeamGrid, Window};
use crate::wide_registers::array_of;
use cadet_base::math::greater;

/// Beams of a row that share a bound.
const BOUND_COLUMNS: usize = 16;

/// For each [`BOUND_COLUMNS`] beams of a row a depth that none of them exceeds: it decides most questions about what is hidden
/// without a look at the beams. Depths only shrink, so a bound from before still holds.
#[derive(Debug)]
pub(super) struct CoarseDepth {
    per_row: usize,
    bounds: Vec<f32>,
}

impl CoarseDepth {
    /// Bounds that always hold.
    pub(super) fn new(rows: usize, columns: usize) -> Self {
        let per_row = columns.div_ceil(BOUND_COLUMNS);
        Self { per_row, bounds: vec![f32::INFINITY; rows * per_row] }
    }

    /// True if all beams of the window have met something nearer than `near_m`.
    #[inline(always)]
    pub(super) fn hides<G: BeamGrid>(&mut self, grid: &G, depths_m: &[f32], window: &Window, near_m: f32) -> bool {
        let columns = grid.columns();
        let (first, last) =
            (window.columns.start / BOUND_COLUMNS, window.columns.end.saturating_sub(1) / BOUND_COLUMNS);
        for row in window.rows.clone() {
            let bounds = &mut self.bounds[row * self.per_row..][first..=last];
            for (bound, block) in bounds.iter_mut().zip(first..).filter(|(bound, _)| **bound >= near_m) {
                let row_depths = &depths_m[grid.row_start(row)..][..columns];
                let (from, to) = (block * BOUND_COLUMNS, ((block + 1) * BOUND_COLUMNS).min(columns));
                *bound = farthest(&row_depths[from..to]);
                if *bound >= near_m {
                    let inside = &row_depths[from.max(window.columns.start)..to.min(window.columns.end)];
                    for depth in inside {
                        if *depth >= near_m {
                            return false;
                        }
                    }
                }
            }
        }
        true
    }
}

#[inline(always)]
fn farthest(depths: &[f32]) -> f32 {
    if let Ok(block) = <&[f32; BOUND_COLUMNS]>::try_from(depths) {
        let mut most = [0.0_f32; 8];
        for i in 0..8 {
            most[i] = greater(block[i], block[i + 8]);
        }
        let four: [f32; 4] = array_of(|i| greater(most[i], most[i + 4]));
        return greater(greater(four[0], four[2]), greater(four[1], four[3]));
    }
    depths.iter().copied().fold(0.0, greater)
}
