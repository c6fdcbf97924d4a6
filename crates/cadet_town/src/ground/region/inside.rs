//! What lies inside a set of rings.

use super::shapes::Ring;
use cadet_base::math::DVec2;
use cadet_base::plane::edges;

/// Tells what lies inside a set of rings, by the even-odd rule, with the edges sorted into rows.
#[derive(Debug, Clone)]
pub(crate) struct Inside {
    min_y: f64,
    row_m: f64,
    /// The easternmost first.
    rows: Vec<Vec<(DVec2, DVec2)>>,
}

impl Inside {
    pub(crate) fn new(rings: &[Ring]) -> Self {
        let ys = || rings.iter().flatten().map(|p| p.y);
        let (min_y, max_y) = (ys().fold(f64::INFINITY, f64::min), ys().fold(f64::NEG_INFINITY, f64::max));
        let span = (max_y - min_y).max(0.0);
        let row_m = (span / 4000.0).max(1.0);
        let count = if span.is_finite() { (span / row_m) as usize + 1 } else { 0 };
        let mut rows = vec![Vec::new(); count];
        for [a, b] in rings.iter().flat_map(|ring| edges(ring)) {
            let (lo, hi) = ((a.y.min(b.y) - min_y) / row_m, (a.y.max(b.y) - min_y) / row_m);
            for row in rows.iter_mut().take(hi as usize + 1).skip(lo as usize) {
                row.push((a, b));
            }
        }
        for row in &mut rows {
            row.sort_by(|a, b| farthest_x(b).total_cmp(&farthest_x(a)));
        }
        Self { min_y, row_m, rows }
    }

    pub(crate) fn contains(&self, p: DVec2) -> bool {
        let row = (p.y - self.min_y) / self.row_m;
        if row.is_nan() || row < 0.0 {
            return false;
        }
        let Some(row) = self.rows.get(row as usize) else { return false };
        let crosses = |(a, b): &(DVec2, DVec2)| {
            (a.y > p.y) != (b.y > p.y) && p.x < a.x + (b.x - a.x) * ((p.y - a.y) / (b.y - a.y))
        };
        // What ends well before the point is not to its right.
        row.iter().take_while(|edge| farthest_x(edge) > p.x - 1e-3).filter(|edge| crosses(edge)).count() % 2 == 1
    }
}

fn farthest_x((a, b): &(DVec2, DVec2)) -> f64 {
    a.x.max(b.x)
}
