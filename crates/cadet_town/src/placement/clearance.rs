//! Distances to the outline of the streets on a grid of one resolution, however large the town is.

use crate::ground::region::Ring;
use cadet_base::math::DVec2;
use cadet_base::plane::{bounds, edges};

/// The largest distance that the grid tells.
pub(crate) const MAX_MARGIN_M: f64 = 6.0;
/// From one point to the next.
const STEP_M: f64 = 0.75;
/// Points along a tile's side.
const TILE: usize = 32;

/// A grid of values in square tiles, of which only those exist that were written to.
#[derive(Debug)]
struct Tiles<T> {
    /// What all points have that were not written to.
    usual: T,
    columns: usize,
    tiles: Vec<Option<Box<[T]>>>,
}

impl<T: Copy> Tiles<T> {
    /// Makes a grid of so many points.
    fn new(columns: usize, rows: usize, usual: T) -> Self {
        let columns = columns.div_ceil(TILE);
        let count = columns * rows.div_ceil(TILE);
        Self { usual, columns, tiles: std::iter::repeat_with(|| None).take(count).collect() }
    }

    /// The tile of a point, and where in it the point is.
    fn place(&self, column: usize, row: usize) -> (usize, usize) {
        (row / TILE * self.columns + column / TILE, row % TILE * TILE + column % TILE)
    }

    fn at(&self, column: usize, row: usize) -> T {
        let (tile, point) = self.place(column, row);
        self.tiles[tile].as_ref().map_or(self.usual, |points| points[point])
    }

    fn at_mut(&mut self, column: usize, row: usize) -> &mut T {
        let (tile, point) = self.place(column, row);
        let usual = self.usual;
        &mut self.tiles[tile].get_or_insert_with(|| vec![usual; TILE * TILE].into())[point]
    }

    fn map<U>(self, f: impl Fn(T) -> U) -> Tiles<U> {
        let tiles = self.tiles.into_iter().map(|tile| tile.map(|points| points.iter().map(|v| f(*v)).collect()));
        Tiles { usual: f(self.usual), columns: self.columns, tiles: tiles.collect() }
    }
}

/// Distance to an outline at each grid point, negative inside, at most [`MAX_MARGIN_M`].
#[derive(Debug)]
pub(crate) struct ClearanceGrid {
    origin: DVec2,
    columns: usize,
    rows: usize,
    clearance_m: Tiles<f32>,
}

impl ClearanceGrid {
    /// Measures the distances to rings, of which inner ones are holes.
    pub fn new(outline: &[Ring]) -> Self {
        let (min, max) = bounds(outline.iter().flatten().copied());
        let origin = min - DVec2::splat(MAX_MARGIN_M + 1.0);
        let size = ((max + DVec2::splat(MAX_MARGIN_M + 1.0) - origin) / STEP_M).ceil();
        let (columns, rows) = (size.x as usize + 1, size.y as usize + 1);
        let mut squared_m2 = Tiles::new(columns, rows, MAX_MARGIN_M * MAX_MARGIN_M);
        let mut crossings: Vec<Vec<f64>> = vec![Vec::new(); rows];
        for ring in outline {
            for [a, b] in edges(ring) {
                lower_about([a - origin, b - origin], [columns, rows], &mut squared_m2);
                let (low, high) = if a.y < b.y { (a, b) } else { (b, a) };
                let row_of = |y: f64| ((y - origin.y) / STEP_M).ceil() as usize;
                for (row, list) in crossings.iter_mut().enumerate().take(row_of(high.y)).skip(row_of(low.y)) {
                    let y = origin.y + row as f64 * STEP_M;
                    list.push(low.x + (high.x - low.x) * (y - low.y) / (high.y - low.y));
                }
            }
        }
        let mut clearance_m = squared_m2.map(|v| v.sqrt() as f32);
        for (row, mut list) in crossings.into_iter().enumerate() {
            list.sort_by(f64::total_cmp);
            for pair in list.chunks_exact(2) {
                let column_of = |x: f64| ((x - origin.x) / STEP_M).ceil() as usize;
                for column in column_of(pair[0])..column_of(pair[1]) {
                    let value = clearance_m.at_mut(column, row);
                    *value = -*value;
                }
            }
        }
        Self { origin, columns, rows, clearance_m }
    }

    /// Distance from a place to the outline, between the grid's points by their distances.
    pub fn at(&self, p: DVec2) -> f64 {
        let at = (p - self.origin) / STEP_M;
        if at.x < 0.0 || at.y < 0.0 || at.x >= (self.columns - 1) as f64 || at.y >= (self.rows - 1) as f64 {
            return MAX_MARGIN_M;
        }
        let (i, j) = (at.x as usize, at.y as usize);
        let (u, v) = (at.x - i as f64, at.y - j as f64);
        let value = |i: usize, j: usize| f64::from(self.clearance_m.at(i, j));
        let low = value(i, j) * (1.0 - u) + value(i + 1, j) * u;
        low * (1.0 - v) + (value(i, j + 1) * (1.0 - u) + value(i + 1, j + 1) * u) * v
    }
}

/// Lowers the squares of the clearances about an edge of the outline, whose ends are relative to the grid's origin.
fn lower_about([a, b]: [DVec2; 2], [columns, rows]: [usize; 2], squared_m2: &mut Tiles<f64>) {
    let (d, length_2) = (b - a, (b - a).length_squared().max(1e-12));
    let points = |low_m: f64, high_m: f64, count: usize| {
        let [first, last] = [(low_m - MAX_MARGIN_M) / STEP_M, (high_m + MAX_MARGIN_M) / STEP_M];
        first.ceil().max(0.0) as usize..=(last.floor() as usize).min(count - 1)
    };
    for row in points(a.y.min(b.y), a.y.max(b.y), rows) {
        let y = row as f64 * STEP_M;
        // The x of the part of the edge within reach of the row: the whole edge where it runs along the rows.
        let ends = [y - MAX_MARGIN_M, y + MAX_MARGIN_M].map(|y| ((y - a.y) / d.y).clamp(0.0, 1.0));
        let [from, to] = if d.y.abs() > 1e-9 { ends } else { [0.0, 1.0] }.map(|t| a.x + d.x * t);
        for column in points(from.min(to), from.max(to), columns) {
            let p = DVec2::new(column as f64, row as f64) * STEP_M - a;
            let t = (p.dot(d) / length_2).clamp(0.0, 1.0);
            let known = squared_m2.at_mut(column, row);
            *known = known.min((p - d * t).length_squared());
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use cadet_base::rng::Stream;

    /// A band along the diagonal from the origin, 9 m wide, and a square hole in it at `hole_m` along it.
    fn band(length_m: f64, hole_m: f64) -> Vec<Ring> {
        let along = DVec2::ONE.normalize();
        let rect = |[a0, a1]: [f64; 2], half_m: f64| -> Ring {
            let corners = [(a0, -half_m), (a1, -half_m), (a1, half_m), (a0, half_m)];
            corners.map(|(a, l)| along * a + along.perp() * l).into()
        };
        vec![rect([0.0, length_m], 4.5), rect([hole_m - 1.0, hole_m + 1.0], 1.0)]
    }

    #[test]
    fn a_map_of_ten_kilometers_has_the_clearances_of_one_of_one() {
        let along = DVec2::ONE.normalize();
        for (length_m, hole_m) in [(1000.0, 700.0), (14_000.0, 9800.0)] {
            let grid = ClearanceGrid::new(&band(length_m, hole_m));
            let tiles = grid.clearance_m.tiles.iter().flatten().count() as f64;
            assert!(tiles < 0.2 * length_m, "{tiles} tiles of {length_m} m");
            let mut s = Stream::from_seed("clearance", 1);
            for _ in 0..2000 {
                let (a_m, left_m) = (s.range(-15.0, 15.0), s.range(-15.0, 15.0));
                let (beside_m, from_hole) = (left_m.abs() - 4.5, DVec2::new(a_m.abs() - 1.0, left_m.abs() - 1.0));
                let exact_m = if beside_m > 0.0 {
                    beside_m
                } else if from_hole.max_element() < 0.0 {
                    -from_hole.max_element()
                } else {
                    -from_hole.max(DVec2::ZERO).length().min(-beside_m)
                };
                let told_m = grid.at(along * (hole_m + a_m) + along.perp() * left_m);
                // Between four points the distance is within half a step's diagonal of straight.
                assert!((told_m - exact_m.min(6.0)).abs() < 0.4, "{a_m} {left_m}: {told_m}, {exact_m}");
            }
        }
    }
}
