//! Where there is something in the blocks of a square map, as a summed-area table (Crow, SIGGRAPH 1984): any rectangle of
//! blocks is one query.

/// Blocks of a map that have something.
#[derive(Debug, Clone)]
pub struct BlockSums {
    /// Blocks along a side.
    side: usize,
    blocks_per_m: f32,
    /// Their number over all blocks before a row and a column.
    sums: Vec<u16>,
}

impl BlockSums {
    /// `has(x, y)` tells whether a block has something; `side` is below 256.
    pub fn of(side: usize, block_m: f32, has: impl Fn(usize, usize) -> bool) -> Self {
        let stride = side + 1;
        let mut sums = vec![0; stride * stride];
        for y in 0..side {
            let mut row = 0;
            for x in 0..side {
                row += u16::from(has(x, y));
                sums[(y + 1) * stride + x + 1] = sums[y * stride + x + 1] + row;
            }
        }
        Self { side, blocks_per_m: 1.0 / block_m, sums }
    }

    /// True if some block between two places has something; meters from the map's corner. What lies beyond the map counts
    /// as its rim.
    #[inline]
    pub fn any(&self, low_m: [f32; 2], high_m: [f32; 2]) -> bool {
        let block = |v: f32| ((v * self.blocks_per_m).max(0.0) as usize).min(self.side - 1);
        self.any_between(low_m.map(block), high_m.map(block))
    }

    /// True if some block between two of the map, both included, has something.
    #[inline]
    fn any_between(&self, [x0, y0]: [usize; 2], [x1, y1]: [usize; 2]) -> bool {
        let at = |x: usize, y: usize| self.sums[y * (self.side + 1) + x];
        at(x1 + 1, y1 + 1).wrapping_add(at(x0, y0)) != at(x1 + 1, y0).wrapping_add(at(x0, y1 + 1))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_rectangle_knows_whether_it_has_something() {
        let marked = [(2, 3), (9, 0), (7, 7)];
        let sums = BlockSums::of(10, 2.0, |x, y| marked.contains(&(x, y)));
        for (x0, y0) in (0..10).flat_map(|x| (0..10).map(move |y| (x, y))) {
            for (x1, y1) in (x0..10).flat_map(|x| (y0..10).map(move |y| (x, y))) {
                let want = marked.iter().any(|(x, y)| (x0..=x1).contains(x) && (y0..=y1).contains(y));
                let middle = |i: usize| i as f32 * 2.0 + 1.0;
                assert_eq!(sums.any([middle(x0), middle(y0)], [middle(x1), middle(y1)]), want);
                assert_eq!(sums.any_between([x0, y0], [x1, y1]), want);
            }
        }
        assert!(sums.any([-50.0, 6.5], [900.0, 6.6]) && !sums.any([-50.0, 8.5], [900.0, 9.6]));
    }
}
