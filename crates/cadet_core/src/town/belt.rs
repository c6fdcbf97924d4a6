//! What closes the horizon: trees in the middles of large blocks, and a belt about the town.

use super::frontage::Frontage;
use super::occupancy::{MAX_MARGIN_M, Occupancy};
use super::placer::Placer;
use crate::assets::scenery::TreeKind;
use crate::math::DVec2;
use crate::rng::Stream;

/// One tree a cell at most.
const CELL_M: f64 = 8.0;
/// Plots reach about this far from the street; behind them the trees stand closer.
const PLOTS_M: f64 = 27.0;

/// Plants what neither streets nor plots need, up to `belt_m` behind the plots.
pub(super) fn plant(
    s: &mut Stream,
    greenery: f64,
    belt_m: f64,
    frontages: &[Frontage],
    taken: &Occupancy,
    placer: &mut Placer,
) {
    let (min, max) = (placer.site.min, placer.site.max);
    let streets: Vec<DVec2> = frontages.iter().flat_map(|f| f.points.iter().step_by(8).copied()).collect();
    let reach = DVec2::splat(PLOTS_M + belt_m);
    let cells = ((max - min + reach * 2.0) / CELL_M).ceil();
    for i in 0..cells.x as usize {
        for j in 0..cells.y as usize {
            // The same draws whether or not the place is taken: a plot more does not change the wood behind it.
            let jitter = DVec2::new(s.range(0.1, 0.9), s.range(0.1, 0.9));
            let (luck, kind) = (s.unit(), s.weighted(&[0.62, 0.2, 0.18]));
            let kind = [TreeKind::Wood, TreeKind::Conifer, TreeKind::Garden][kind];
            let at = min - reach + (DVec2::new(i as f64, j as f64) + jitter) * CELL_M;
            let nearest = streets.iter().map(|p| (*p - at).length_squared()).fold(f64::INFINITY, f64::min).sqrt();
            if nearest > PLOTS_M + belt_m {
                continue;
            }
            let share = if nearest > PLOTS_M { 0.6 } else { 0.3 };
            let wanted = luck < share * greenery.min(1.5);
            if wanted && placer.site.is_clear(at, MAX_MARGIN_M * 0.95) && taken.is_free_at(at, 2.5) {
                let _ = placer.plant(kind, s, at);
            }
        }
    }
}
