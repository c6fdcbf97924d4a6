//! A polyline with times.

use crate::course::Waypoint;
use cadet_base::math::DVec2;
use cadet_base::plane::Polyline;

/// A path that is known from its first time to its last.
pub(crate) struct TimedPath {
    t_s: Vec<f64>,
    line: Polyline,
}

/// Where one is at some time.
#[derive(Debug, Clone, Copy)]
pub(crate) struct OnPath {
    pub at: DVec2,
    pub velocity: DVec2,
    /// Distance along the path.
    pub s_m: f64,
}

impl TimedPath {
    /// `points` with at least two of them and rising times.
    pub fn new(points: &[Waypoint]) -> Self {
        let line = Polyline::new(points.iter().map(|p| DVec2::new(p.x_m, p.y_m)).collect());
        Self { t_s: points.iter().map(|p| p.t_s).collect(), line }
    }

    pub fn length_m(&self) -> f64 {
        self.line.length_m()
    }

    /// Linear between the points, standing before the first and after the last.
    pub fn at_time(&self, t_s: f64) -> OnPath {
        let last = self.t_s.len() - 1;
        let (points, s_m) = (self.line.points(), self.line.s_m());
        let i = self.t_s.partition_point(|t| *t <= t_s);
        if i == 0 || i > last {
            let k = i.min(last);
            return OnPath { at: points[k], velocity: DVec2::ZERO, s_m: s_m[k] };
        }
        let (t0, t1) = (self.t_s[i - 1], self.t_s[i]);
        let (way, share) = (points[i] - points[i - 1], (t_s - t0) / (t1 - t0));
        OnPath {
            at: points[i - 1] + way * share,
            velocity: way / (t1 - t0),
            s_m: s_m[i - 1] + (s_m[i] - s_m[i - 1]) * share,
        }
    }

    /// The place at a distance along the path, clamped to it.
    pub fn at_distance(&self, s_m: f64) -> DVec2 {
        self.line.at(s_m.clamp(0.0, self.length_m()))
    }

    /// Direction of the chord from `half_m` behind a place of the path to `half_m` ahead of it; `None` where the path
    /// stays where it is.
    pub fn heading(&self, s_m: f64, half_m: f64) -> Option<DVec2> {
        let chord = self.at_distance(s_m + half_m) - self.at_distance(s_m - half_m);
        (chord.length() > 1e-3 * half_m).then(|| chord.normalize())
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn path(points: &[(f64, f64, f64)]) -> TimedPath {
        let points: Vec<Waypoint> =
            points.iter().map(|(t_s, x_m, y_m)| Waypoint { t_s: *t_s, x_m: *x_m, y_m: *y_m }).collect();
        TimedPath::new(&points)
    }

    #[test]
    fn places_lie_on_the_lines_between_the_points() {
        let path = path(&[(1.0, 0.0, 0.0), (3.0, 8.0, 0.0), (4.0, 8.0, 0.0), (5.0, 8.0, 3.0)]);
        let place = |t: f64| path.at_time(t).at;
        assert_eq!([0.0, 1.0].map(place), [DVec2::ZERO; 2]);
        assert_eq!([1.5, 2.0, 3.5].map(place), [DVec2::new(2.0, 0.0), DVec2::new(4.0, 0.0), DVec2::new(8.0, 0.0)]);
        assert_eq!([4.5, 5.0, 99.0].map(place), [1.5, 3.0, 3.0].map(|y| DVec2::new(8.0, y)));
        let speed = |t: f64| path.at_time(t).velocity;
        assert_eq!([0.5, 2.0, 3.5].map(speed), [DVec2::ZERO, DVec2::new(4.0, 0.0), DVec2::ZERO]);
        assert_eq!([4.5, 5.0].map(speed), [DVec2::new(0.0, 3.0), DVec2::ZERO]);
        assert_eq!([0.5, 2.0, 3.5, 4.5, 9.0].map(|t| path.at_time(t).s_m), [0.0, 4.0, 8.0, 9.5, 11.0]);
    }

    #[test]
    fn the_heading_turns_evenly_round_a_corner() {
        let path = path(&[(0.0, 0.0, 0.0), (1.0, 5.0, 0.0), (2.0, 5.0, 5.0)]);
        assert_eq!(path.heading(0.0, 1.3), Some(DVec2::X));
        assert_eq!(path.heading(3.6, 1.3), Some(DVec2::X));
        let corner = path.heading(5.0, 1.3).unwrap();
        assert!((corner - DVec2::ONE.normalize()).length() < 1e-12);
        assert_eq!(path.heading(6.4, 1.3), Some(DVec2::Y));
        assert_eq!(path.heading(10.0, 1.3), Some(DVec2::Y));
        let still = TimedPath::new(&[0.0, 1.0].map(|t_s| Waypoint { t_s, x_m: 2.0, y_m: 2.0 }));
        assert_eq!(still.heading(0.0, 1.3), None);
    }
}
