//! Distances to edges in the plane.

use std::collections::BTreeMap;

use crate::math::DVec2;

/// Distances from a set of edges.
#[derive(Debug)]
pub struct DistanceFrom {
    side_m: f64,
    /// The edges by the squares that they touch.
    squares: BTreeMap<(i64, i64), Vec<[DVec2; 2]>>,
}

impl DistanceFrom {
    /// Distances up to a reach from edges; from points where those begin and end at one place.
    pub fn new(edges: impl IntoIterator<Item = [DVec2; 2]>, reach_m: f64) -> Self {
        let mut all = Self { side_m: reach_m, squares: BTreeMap::new() };
        for [a, b] in edges {
            let ((i0, j0), (i1, j1)) = (all.square(a.min(b)), all.square(a.max(b)));
            for square in (i0..=i1).flat_map(|i| (j0..=j1).map(move |j| (i, j))) {
                all.squares.entry(square).or_default().push([a, b]);
            }
        }
        all
    }

    fn square(&self, p: DVec2) -> (i64, i64) {
        ((p.x / self.side_m).floor() as i64, (p.y / self.side_m).floor() as i64)
    }

    /// Distance to the nearest edge; beyond the reach, or infinite, where none lies within it.
    pub fn distance_m(&self, p: DVec2) -> f64 {
        let (i, j) = self.square(p);
        let near = (i - 1..=i + 1).flat_map(|i| self.squares.range((i, j - 1)..=(i, j + 1)));
        let to_edge = |[a, b]: &[DVec2; 2]| {
            let d = *b - *a;
            let t = ((p - *a).dot(d) / d.length_squared().max(1e-12)).clamp(0.0, 1.0);
            (p - *a - d * t).length_squared()
        };
        near.flat_map(|(_, edges)| edges).map(to_edge).fold(f64::INFINITY, f64::min).sqrt()
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::plane::edges;
    use crate::rng::Stream;

    #[test]
    fn distances_within_reach_are_those_of_all_edges() {
        let ring = [(0.0, 0.0), (40.0, 3.0), (37.0, 30.0), (-4.0, 22.0)].map(DVec2::from);
        let from = DistanceFrom::new(edges(&ring), 12.0);
        let mut s = Stream::from_seed("distance", 1);
        for _ in 0..500 {
            let p = DVec2::new(s.range(-30.0, 70.0), s.range(-30.0, 60.0));
            let dense = edges(&ring).flat_map(|[a, b]| (0..4500).map(move |k| a.lerp(b, f64::from(k) / 4500.0)));
            let nearest = dense.map(|q| (q - p).length()).fold(f64::INFINITY, f64::min);
            assert!((from.distance_m(p).min(12.0) - nearest.min(12.0)).abs() < 1e-3, "{p}");
        }
    }

    #[test]
    fn the_nearest_point_within_reach_is_found_as_by_looking_at_all() {
        let mut s = Stream::from_seed("points", 3);
        let mut point = || DVec2::new(s.range(-300.0, 300.0), s.range(-300.0, 300.0));
        let points: Vec<DVec2> = (0..60).map(|_| point()).collect();
        let from = DistanceFrom::new(points.iter().map(|p| [*p; 2]), 47.0);
        for at in (0..2000).map(|_| point()) {
            let nearest = points.iter().map(|p| (*p - at).length_squared()).fold(f64::INFINITY, f64::min).sqrt();
            let found = from.distance_m(at);
            assert!(found == nearest || (found > 47.0 && nearest > 47.0), "{at}: {found}, {nearest}");
        }
    }
}
