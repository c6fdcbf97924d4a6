//! A shadow map, and which of its tiles the camera sees.

use cadet_base::math::lesser;

/// Texels along a side of each map.
pub(super) const SIZE: usize = 1536;
/// Texels along a side of a tile: what shades no tile that the camera sees is not drawn.
pub(super) const TILE: usize = 16;
pub(super) const TILES: usize = SIZE / TILE;
/// From a row of texels to the next: an odd number of cache lines, else neighbors would crowd in a few of its sets.
pub(super) const STRIDE: usize = SIZE + 16;
/// The height of what nothing was drawn on.
pub(super) const EMPTY: i16 = i16::MIN;

/// One orthographic map: for each texel the coordinate towards the sun of the first surface that its light meets.
#[derive(Debug, Clone)]
pub(super) struct Map {
    /// Light coordinates of the texel corner (0, 0).
    pub(super) min_m: [f32; 2],
    /// The light coordinate of height 0.
    pub(super) middle_z: f32,
    pub(super) texel_m: f32,
    pub(super) texels_per_m: f32,
    pub(super) steps_per_m: f32,
    /// Of leaves that are drawn together one in so many casts a shadow.
    pub(super) leaf_step: usize,
    pub(super) height: Vec<i16>,
    pub(super) receivers: ReceiverTiles,
    /// The columns between which something was drawn, for each row of tiles.
    pub(super) drawn: Vec<[usize; 2]>,
}

/// How low the camera sees receivers on the tiles of a map and on those around them: what is nowhere higher shades
/// nothing there.
#[derive(Debug, Clone, Default)]
pub(super) struct ReceiverTiles {
    /// Steps; of squares of 1, 2, 4 .. tiles that begin in each tile. Infinite where nothing is seen.
    pub(super) lowest_steps: Vec<Vec<f32>>,
    /// The columns of texels between the first and the last seen tile, for each row of tiles.
    pub(super) spans: Vec<[usize; 2]>,
}

impl ReceiverTiles {
    /// `lowest_steps`: of each tile alone.
    pub(super) fn around(lowest_steps: &[f32]) -> Self {
        let mut two = joined(&lowest_steps[..TILES * TILES], 1);
        // Of three by three, those of the tiles before a tile as well.
        let mut one = two.clone();
        for (row, two) in one.chunks_exact_mut(TILES).zip(two.chunks_exact(TILES)) {
            lower(&mut row[1..], two);
        }
        two.clone_from(&one);
        lower(&mut one[TILES..], &two);
        let span = |row: &[f32]| {
            let is_seen = |low: &f32| *low < f32::INFINITY;
            match (row.iter().position(is_seen), row.iter().rposition(is_seen)) {
                (Some(first), Some(last)) => [first * TILE, (last + 1) * TILE],
                _ => [SIZE, 0],
            }
        };
        let spans = one.chunks(TILES).map(span).collect();
        let mut levels = vec![one];
        for level in 0..TILES.ilog2() {
            levels.push(joined(&levels[level as usize], 1 << level));
        }
        Self { lowest_steps: levels, spans }
    }

    /// True if something that reaches up to a height may shade something seen on the tiles between two texels (both
    /// included).
    #[inline]
    pub(super) fn any(&self, from: [usize; 2], to: [usize; 2], highest_steps: f32) -> bool {
        let ([x0, y0], [x1, y1]) = (from.map(|texel| texel / TILE), to.map(|texel| texel / TILE));
        let level = (x1 - x0).max(y1 - y0);
        if level < 2 {
            return self.lowest_steps[level][y0 * TILES + x0] < highest_steps;
        }
        let level = (level + 1).ilog2() as usize;
        let (lowest, side) = (&self.lowest_steps[level], 1 << level);
        let (x1, y1) = ((x1 + 1).saturating_sub(side).max(x0), (y1 + 1).saturating_sub(side).max(y0));
        let at = |x: usize, y: usize| lowest[y * TILES + x] < highest_steps;
        at(x0, y0) || at(x1, y0) || at(x0, y1) || at(x1, y1)
    }
}

/// Of squares of tiles those that lie `by` tiles further along rows, columns and both are taken in.
fn joined(lowest: &[f32], by: usize) -> Vec<f32> {
    let mut out = lowest.to_vec();
    for (out, row) in out.chunks_exact_mut(TILES).zip(lowest.chunks_exact(TILES)) {
        lower(out, &row[by..]);
    }
    let rows = out.clone();
    lower(&mut out, &rows[by * TILES..]);
    out
}

/// Lowers numbers to others, as far as there are any.
fn lower(out: &mut [f32], to: &[f32]) {
    for (out, to) in out.iter_mut().zip(to) {
        *out = lesser(*out, *to);
    }
}

/// Heights of points end here, steps.
pub(super) const HIGHEST_STEPS: f32 = 32_000.0;

/// The nearest step to a height that sixteen bits can hold, in the lower half of a number.
#[inline(always)]
pub(super) fn steps(z: f32) -> i32 {
    const LARGE: f32 = 12_582_912.0; // 1.5 * 2^23, whose own lower half is 0
    (z + LARGE).to_bits() as i32
}
