//! What closes the horizon: trees in the blocks' middles and a belt about the town.

use super::occupancy::{MAX_MARGIN_M, Occupancy};
use super::placer::Placer;
use crate::assets::scenery::TreeKind;
use crate::math::DVec2;
use crate::rng::Stream;

/// One tree a cell at most.
const CELL_M: f64 = 8.5;

/// Plants what neither streets nor plots need; beyond the outermost lanes densely, `belt_m` deep.
pub(super) fn plant(s: &mut Stream, greenery: f64, belt_m: f64, taken: &Occupancy, placer: &mut Placer) {
    let (min, max) = (placer.site.min, placer.site.max);
    let reach = DVec2::splat(belt_m);
    let cells = ((max - min + reach * 2.0) / CELL_M).ceil();
    for i in 0..cells.x as usize {
        for j in 0..cells.y as usize {
            let jitter = DVec2::new(s.range(0.1, 0.9), s.range(0.1, 0.9));
            let at = min - reach + (DVec2::new(i as f64, j as f64) + jitter) * CELL_M;
            let outside = (at - max).max(min - at).max_element();
            let share = if outside > 26.0 { 0.8 } else { 0.22 };
            // The same draws whether or not the place is taken: a plot more does not change the wood behind it.
            let wanted = s.chance(share * greenery.min(1.25));
            let kind = match s.weighted(&[0.62, 0.2, 0.18]) {
                0 => TreeKind::Wood,
                1 => TreeKind::Conifer,
                _ => TreeKind::Garden,
            };
            if wanted && placer.site.is_clear(at, MAX_MARGIN_M) && taken.is_free_at(at, 2.5) {
                let _ = placer.plant(kind, s, at);
            }
        }
    }
}
