//! Lines through points in the plane, by the distance along them.

use crate::math::DVec2;

/// A line through points.
#[derive(Debug, Clone)]
pub struct Polyline {
    points: Vec<DVec2>,
    /// Distance along the line of each point; the first is 0.
    s_m: Vec<f64>,
}

impl Polyline {
    /// The line through at least two points.
    pub fn new(points: Vec<DVec2>) -> Self {
        let s_m = distances_along(points.iter().copied());
        Self { points, s_m }
    }

    /// Its points, in order.
    pub fn points(&self) -> &[DVec2] {
        &self.points
    }

    /// Distance along the line of each point; the first is 0.
    pub fn s_m(&self) -> &[f64] {
        &self.s_m
    }

    /// Its length from end to end.
    pub fn length_m(&self) -> f64 {
        self.s_m.last().copied().unwrap_or(0.0)
    }

    /// The place at a distance along the line; beyond its ends it goes straight on.
    #[inline]
    pub fn at(&self, s_m: f64) -> DVec2 {
        let (i, share) = piece_at(&self.s_m, s_m);
        self.points[i - 1] + (self.points[i] - self.points[i - 1]) * share
    }

    /// Unit vector along the line there; x where it stays where it is.
    #[inline]
    pub fn tangent(&self, s_m: f64) -> DVec2 {
        let (i, _) = piece_at(&self.s_m, s_m);
        (self.points[i] - self.points[i - 1]).normalize_or(DVec2::X)
    }

    /// Distance along the line of the point, of those that it leads through, nearest to a place; `None` without points.
    pub fn s_of_nearest_point(&self, place: DVec2) -> Option<f64> {
        let away = |p: &DVec2| (*p - place).length_squared();
        let points = self.points.iter().zip(&self.s_m);
        points.min_by(|(p, _), (q, _)| away(p).total_cmp(&away(q))).map(|(_, s_m)| *s_m)
    }

    /// The points strictly between two distances.
    pub fn between(&self, from_m: f64, to_m: f64) -> &[DVec2] {
        let (i, j) = (self.s_m.partition_point(|v| *v <= from_m), self.s_m.partition_point(|v| *v < to_m));
        &self.points[i.min(j)..j]
    }
}

/// Distance along a line of each of its points; the first is 0.
fn distances_along(points: impl IntoIterator<Item = DVec2>) -> Vec<f64> {
    let mut last: Option<(DVec2, f64)> = None;
    let points = points.into_iter().map(|p| {
        let s_m = last.map_or(0.0, |(q, s_m)| s_m + (p - q).length());
        last = Some((p, s_m));
        s_m
    });
    points.collect()
}

/// The piece of a line on which a distance along it lies, by the index of the point where it ends, and the share of the
/// piece that lies before; below 0 before the line's start, above 1 beyond its end.
pub fn piece_at(s_m: &[f64], at_m: f64) -> (usize, f64) {
    let i = s_m.partition_point(|v| *v <= at_m).clamp(1, s_m.len() - 1);
    let length_m = s_m[i] - s_m[i - 1];
    (i, if length_m > 0.0 { (at_m - s_m[i - 1]) / length_m } else { 0.0 })
}

/// Distance along a line of its point nearest to a place, and how far away that is.
pub fn nearest(points: impl IntoIterator<Item = DVec2>, s_m: &[f64], place: DVec2) -> (f64, f64) {
    let mut best = (s_m.first().copied().unwrap_or(0.0), f64::INFINITY);
    let mut points = points.into_iter().zip(s_m);
    let Some((mut from, mut from_m)) = points.next() else { return best };
    for (to, to_m) in points {
        let (p, d) = (place - from, to - from);
        let share = (p.dot(d) / d.length_squared().max(1e-18)).clamp(0.0, 1.0);
        let distance_m = (p - d * share).length();
        if distance_m < best.1 {
            best = (from_m + (to_m - from_m) * share, distance_m);
        }
        (from, from_m) = (to, to_m);
    }
    best
}

#[cfg(test)]
mod tests {
    use super::*;

    fn corner() -> Polyline {
        Polyline::new(vec![DVec2::ZERO, DVec2::new(3.0, 0.0), DVec2::new(3.0, 0.0), DVec2::new(3.0, 4.0)])
    }

    #[test]
    fn places_lie_on_the_line_and_straight_on_beyond_its_ends() {
        let line = corner();
        assert_eq!(line.length_m(), 7.0);
        let places = [-1.0, 0.0, 1.5, 3.0, 5.0, 7.0, 8.0].map(|s_m| line.at(s_m));
        let expected = [(-1.0, 0.0), (0.0, 0.0), (1.5, 0.0), (3.0, 0.0), (3.0, 2.0), (3.0, 4.0), (3.0, 5.0)];
        assert_eq!(places, expected.map(|(x, y)| DVec2::new(x, y)));
        assert_eq!([1.0, 4.0, 9.0].map(|s_m| line.tangent(s_m)), [DVec2::X, DVec2::Y, DVec2::Y]);
        assert_eq!(line.between(0.0, 3.0), &[] as &[DVec2]);
        assert_eq!(line.between(0.0, 3.5).len(), 2);
    }

    #[test]
    fn the_nearest_point_is_that_of_dense_samples() {
        let line = corner();
        for k in 0..40 {
            let place = DVec2::new(f64::from(k % 8) - 2.0, f64::from(k / 8) * 1.5 - 1.0);
            let (s_m, distance_m) = nearest(line.points().iter().copied(), line.s_m(), place);
            let samples = (0..=7000).map(|i| line.at(f64::from(i) / 1000.0));
            let least_m = samples.map(|p| (p - place).length()).fold(f64::INFINITY, f64::min);
            assert!(
                (distance_m - least_m).abs() < 1e-3 && ((line.at(s_m) - place).length() - distance_m).abs() < 1e-12
            );
        }
    }
}
