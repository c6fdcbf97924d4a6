//! What closes the horizon: trees in the middles of large blocks, and a belt about the town.

use std::collections::BTreeMap;

use crate::placement::{MAX_MARGIN_M, Occupancy, Placer};
use crate::plots::Frontage;
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
    let streets = StreetPoints::new(frontages.iter().flat_map(|f| f.line.points().iter().step_by(8).copied()), reach_m);
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

/// Points of the streets, sorted into squares whose side is the farthest distance that matters.
pub(crate) struct StreetPoints {
    side_m: f64,
    squares: BTreeMap<(i64, i64), Vec<DVec2>>,
}

impl StreetPoints {
    /// The points, to be looked for within a distance.
    pub(crate) fn new(points: impl Iterator<Item = DVec2>, reach_m: f64) -> Self {
        let mut streets = Self { side_m: reach_m.max(CELL_M), squares: BTreeMap::new() };
        for point in points {
            streets.squares.entry(streets.square(point)).or_default().push(point);
        }
        streets
    }

    fn square(&self, p: DVec2) -> (i64, i64) {
        ((p.x / self.side_m).floor() as i64, (p.y / self.side_m).floor() as i64)
    }

    /// Distance to the nearest point; infinite or beyond the reach where none lies within it.
    pub(crate) fn distance_m(&self, p: DVec2) -> f64 {
        let (x, y) = self.square(p);
        let near = (x - 1..=x + 1).flat_map(|i| self.squares.range((i, y - 1)..=(i, y + 1)));
        near.flat_map(|(_, points)| points).map(|q| (*q - p).length_squared()).fold(f64::INFINITY, f64::min).sqrt()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_nearest_point_within_reach_is_found_as_by_looking_at_all() {
        let mut s = cadet_base::rng::StreamKey { seed: 3, episode: 0, attempt: 0 }.stream("belt test");
        let mut point = || DVec2::new(s.range(-300.0, 300.0), s.range(-300.0, 300.0));
        let points: Vec<DVec2> = (0..60).map(|_| point()).collect();
        let streets = StreetPoints::new(points.iter().copied(), 47.0);
        for at in (0..2000).map(|_| point()) {
            let nearest = points.iter().map(|p| (*p - at).length_squared()).fold(f64::INFINITY, f64::min).sqrt();
            let found = streets.distance_m(at);
            assert!(found == nearest || (found > 47.0 && nearest > 47.0), "{at}: {found}, {nearest}");
        }
    }
}
