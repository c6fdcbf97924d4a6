//! What every sample of an image sees, as the number of a drawn face (the "visibility buffer" of Burns and Hunt, JCGT
//! 2013), panes apart from what is solid.

use std::ops::Range;

use super::grid::Window;
use super::kernel::NO_HIT;

/// Samples that are worked on together.
pub(super) const LANES: usize = 8;
/// Samples along a side of a block of the depth hierarchy.
const BLOCK: usize = 8;
/// How much nearer than a bound's nearness a sample must be to hide what the bound stands for.
const CLEARLY: f32 = 1.000_01;

/// A face that was drawn.
#[derive(Debug, Clone, Copy)]
pub struct DrawnFace {
    /// Index into [`super::PosedScene::instances`].
    pub instance: u32,
    /// Face of the instance's mesh.
    pub face: u32,
    /// Its plane in the camera's frame, turned towards the camera: z = volume / (normal · (x, y, 1)).
    pub(super) normal: [f64; 3],
    pub(super) volume: f64,
}

/// The nearest surface of one kind at each sample.
#[derive(Debug, Default)]
pub struct Surfaces {
    /// 1 / z, 0 where there is none; rows of [`VisibilityBuffer::stride`].
    pub nearness: Vec<f32>,
    /// The number of the face in [`VisibilityBuffer::faces`]; means nothing where the nearness is 0.
    pub face: Vec<u32>,
}

/// What the samples of an image see.
#[derive(Debug, Default)]
pub struct VisibilityBuffer {
    /// Rows of samples.
    pub rows: usize,
    /// Columns of samples.
    pub columns: usize,
    /// From a sample to the one below.
    pub stride: usize,
    /// What is solid.
    pub solid: Surfaces,
    /// Panes; those behind what is solid count as absent.
    pub panes: Surfaces,
    /// The faces that were drawn, seen or not.
    pub faces: Vec<DrawnFace>,
    /// Each row's columns outside of which there is no pane.
    pub pane_columns: Vec<Range<usize>>,
    /// For each block a nearness that all of its solid samples reach.
    floors: Vec<f32>,
    /// Blocks whose floor may have risen.
    stale: Vec<bool>,
}

impl VisibilityBuffer {
    /// Makes room for an image and forgets what was seen; memory is used again.
    pub(super) fn reset(&mut self, rows: usize, columns: usize) {
        // A row's last lanes may reach beyond its end.
        let stride = (columns + LANES).next_multiple_of(BLOCK);
        let padded_rows = rows.next_multiple_of(BLOCK);
        self.faces.clear();
        if (self.rows, self.columns) == (rows, columns) {
            for row in 0..rows {
                self.solid.nearness[row * stride..row * stride + columns].fill(0.0);
                let used = std::mem::take(&mut self.pane_columns[row]);
                self.panes.nearness[row * stride..][used].fill(0.0);
            }
        } else {
            (self.rows, self.columns, self.stride) = (rows, columns, stride);
            // Nothing is nearer than the padding, so that nothing is drawn there.
            let mut nearness = vec![f32::INFINITY; padded_rows * stride];
            for row in 0..rows {
                nearness[row * stride..row * stride + columns].fill(0.0);
            }
            self.panes = Surfaces { nearness: nearness.clone(), face: vec![NO_HIT; nearness.len()] };
            self.solid = Surfaces { face: vec![NO_HIT; nearness.len()], nearness };
            self.pane_columns = vec![0..0; rows];
        }
        let blocks = stride / BLOCK * (padded_rows / BLOCK);
        self.floors.clear();
        self.floors.resize(blocks, 0.0);
        self.stale.clear();
        self.stale.resize(blocks, false);
    }

    /// True if all samples of a window have met something solid that is nearer than `z_m` (a depth below that of
    /// every point in question).
    #[inline(always)]
    pub(super) fn is_hidden(&mut self, window: &Window, z_m: f32) -> bool {
        let blocks_across = self.stride / BLOCK;
        for block_row in window.rows.start / BLOCK..=(window.rows.end - 1) / BLOCK {
            for block_column in window.columns.start / BLOCK..=(window.columns.end - 1) / BLOCK {
                let block = block_row * blocks_across + block_column;
                if self.floors[block] * z_m > CLEARLY {
                    continue;
                }
                let (top, left) = (block_row * BLOCK, block_column * BLOCK);
                if self.stale[block] {
                    self.stale[block] = false;
                    self.floors[block] = self.floor_of(top, left);
                    if self.floors[block] * z_m > CLEARLY {
                        continue;
                    }
                }
                let rows = window.rows.start.max(top)..window.rows.end.min(top + BLOCK);
                let columns = window.columns.start.max(left) - left..window.columns.end.min(left + BLOCK) - left;
                if rows.len() == BLOCK && columns.len() == BLOCK {
                    return false;
                }
                for row in rows {
                    let Some(samples) = self.solid.nearness[row * self.stride + left..].first_chunk::<BLOCK>() else {
                        return false;
                    };
                    let mut open = 0;
                    for i in 0..BLOCK {
                        let asked = (i >= columns.start) & (i < columns.end);
                        open |= u32::from(asked & (samples[i] * z_m <= CLEARLY));
                    }
                    if open != 0 {
                        return false;
                    }
                }
            }
        }
        true
    }

    #[inline(always)]
    fn floor_of(&self, top: usize, left: usize) -> f32 {
        let mut least = [f32::INFINITY; BLOCK];
        for row in top..top + BLOCK {
            if let Some(samples) = self.solid.nearness[row * self.stride + left..].first_chunk::<BLOCK>() {
                for i in 0..BLOCK {
                    least[i] = if samples[i] < least[i] { samples[i] } else { least[i] };
                }
            }
        }
        least.into_iter().fold(f32::INFINITY, |a, b| if b < a { b } else { a })
    }

    /// Notes that something solid was drawn into a window.
    #[inline(always)]
    pub(super) fn mark_stale(&mut self, window: &Window) {
        let blocks_across = self.stride / BLOCK;
        for block_row in window.rows.start / BLOCK..=(window.rows.end - 1) / BLOCK {
            let start = block_row * blocks_across;
            let blocks = window.columns.start / BLOCK..(window.columns.end - 1) / BLOCK + 1;
            self.stale[start + blocks.start..start + blocks.end].fill(true);
        }
    }

    /// Notes that a pane was drawn into a window.
    #[inline(always)]
    pub(super) fn mark_panes(&mut self, window: &Window) {
        for range in &mut self.pane_columns[window.rows.clone()] {
            *range = if range.is_empty() {
                window.columns.clone()
            } else {
                range.start.min(window.columns.start)..range.end.max(window.columns.end)
            };
        }
    }

    /// The face that a sample sees first, be it a pane or solid; `None` for the sky.
    #[inline]
    #[must_use]
    pub fn front(&self, row: usize, column: usize) -> Option<&DrawnFace> {
        let at = row * self.stride + column;
        let (solid, pane) = (self.solid.nearness[at], self.panes.nearness[at]);
        let face = if pane > solid { self.panes.face[at] } else { self.solid.face[at] };
        (pane > 0.0 || solid > 0.0).then(|| &self.faces[face as usize])
    }
}
