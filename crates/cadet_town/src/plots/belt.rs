//! What closes the horizon: trees in the middles of large blocks, and a belt about the town.

use crate::placement::{MAX_MARGIN_M, Occupancy, Placer};
use crate::plots::{Frontage, distance_from_streets};
use cadet_assets::scenery::TreeKind;
use cadet_base::math::DVec2;
use cadet_base::rng::Stream;

/// One tree a cell at most.
const CELL_M: f64 = 8.0;
/// Plots reach about this far from the street; behind them the trees stand closer.
const PLOTS_M: f64 = 27.0;

/// Plants what neither streets nor plots need, up to `belt_m` behind the plots.
pub(crate) fn plant(
    s: &mut Stream,
    greenery: f64,
    belt_m: f64,
    frontages: &[Frontage],
    taken: &Occupancy,
    placer: &mut Placer,
) {
    let (min, max) = (placer.site.min, placer.site.max);
    let reach_m = PLOTS_M + belt_m;
    let streets = distance_from_streets(frontages, 8, reach_m);
    let reach = DVec2::splat(reach_m);
    let cells = ((max - min + reach * 2.0) / CELL_M).ceil();
    for i in 0..cells.x as usize {
        for j in 0..cells.y as usize {
            // The same draws whether or not the place is taken: a plot more does not change the wood behind it.
            let jitter = DVec2::new(s.range(0.1, 0.9), s.range(0.1, 0.9));
            let (luck, kind) = (s.unit(), s.weighted(&[0.62, 0.2, 0.18]));
            let kind = [TreeKind::Wood, TreeKind::Conifer, TreeKind::Garden][kind];
            let at = min - reach + (DVec2::new(i as f64, j as f64) + jitter) * CELL_M;
            let nearest = streets.distance_m(at);
            if nearest > reach_m {
                continue;
            }
            let share = if nearest > PLOTS_M { 0.7 } else { 0.4 };
            let wanted = luck < share * greenery.min(1.5);
            if wanted && placer.site.is_clear(at, MAX_MARGIN_M * 0.95) && taken.is_free_at(at, 2.5) {
                let _ = placer.plant(kind, s, at);
            }
        }
    }
}
