//! Sidewalks as walkers know them: lines to walk along, and where one leads on to another.

use std::sync::Arc;

use crate::params::LEVEL_M;
use cadet_base::math::{DVec2, DVec3};
use cadet_base::plane::{Polyline, bounds};
use cadet_town::{Town, Walkway};

/// Ends nearer to each other than this are one corner.
const CORNER_M: f64 = 2.5;

/// The walkways of a town with distances along them.
pub(crate) struct Sidewalks {
    town: Arc<Town>,
    middles: Vec<Polyline>,
    /// Walkways that go on at the (start, end) of each: (walkway, +1 from its start or -1 from its end).
    onward: Vec<[Vec<(usize, f64)>; 2]>,
    bounds: Vec<(DVec2, DVec2)>,
    /// Loops, which have no ends.
    is_closed: Vec<bool>,
}

/// A place on a walkway.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Spot {
    pub at: DVec2,
    /// Height of the ground there, or of the point of the line before.
    pub z_m: f64,
    /// Unit vector along the line.
    pub tangent: DVec2,
}

impl Sidewalks {
    pub fn new(town: Arc<Town>) -> Self {
        let lines = &town.walkways;
        let middles: Vec<Polyline> =
            lines.iter().map(|w| Polyline::new(w.center.iter().map(|p| p.truncate()).collect())).collect();
        let ends = |w: &Walkway| [w.center.first(), w.center.last()].map(|p| p.copied());
        let onward = lines
            .iter()
            .enumerate()
            .map(|(i, w)| {
                ends(w).map(|here| {
                    let Some(here) = here else { return Vec::new() };
                    let mut next = Vec::new();
                    for (j, other) in lines.iter().enumerate().filter(|(j, _)| *j != i) {
                        for (end, direction) in ends(other).into_iter().zip([1.0, -1.0]) {
                            let is_here =
                                |e: DVec3| (e - here).truncate().length() < CORNER_M && (e - here).z.abs() < LEVEL_M;
                            if end.is_some_and(is_here) {
                                next.push((j, direction));
                            }
                        }
                    }
                    next
                })
            })
            .collect();
        let bounds = middles.iter().map(|line| bounds(line.points().iter().copied())).collect();
        let is_closed = lines
            .iter()
            .map(|w| match ends(w) {
                [Some(a), Some(b)] => w.center.len() > 3 && (a - b).truncate().length() < 0.05,
                _ => false,
            })
            .collect();
        Self { town, middles, onward, bounds, is_closed }
    }

    /// Indices of the walkways that can be walked: with a length.
    pub fn usable(&self) -> impl Iterator<Item = usize> {
        (0..self.middles.len()).filter(|i| self.length_m(*i) > 4.0)
    }

    pub fn length_m(&self, walkway: usize) -> f64 {
        self.middles[walkway].length_m()
    }

    /// The most that a walker keeps off the middle line.
    pub fn room_m(&self, walkway: usize) -> f64 {
        (self.town.walkways[walkway].width_m / 2.0 - 0.1).max(0.0)
    }

    pub fn onward(&self, walkway: usize, at_end: bool) -> &[(usize, f64)] {
        &self.onward[walkway][usize::from(at_end)]
    }

    /// A distance along a walkway brought back onto it: round and round on a loop, `None` beyond the ends of another.
    pub fn wrapped(&self, walkway: usize, s_m: f64) -> Option<f64> {
        let length_m = self.length_m(walkway);
        if (0.0..=length_m).contains(&s_m) {
            Some(s_m)
        } else {
            self.is_closed[walkway].then(|| s_m - length_m * (s_m / length_m).floor())
        }
    }

    /// The place at distance `s_m` along a walkway (clamped to it, unless it is a loop).
    pub fn spot(&self, walkway: usize, s_m: f64) -> Spot {
        let line = &self.middles[walkway];
        let s_m = self.wrapped(walkway, s_m).unwrap_or(s_m).clamp(0.0, line.length_m());
        Spot { at: line.at(s_m), z_m: self.z_m(walkway, s_m), tangent: line.tangent(s_m) }
    }

    fn z_m(&self, walkway: usize, s_m: f64) -> f64 {
        let after = self.middles[walkway].s_m().partition_point(|s| *s <= s_m);
        self.town.walkways[walkway].center[after.max(1) - 1].z
    }

    /// The nearest other walkway straight across from a place: (walkway, distance along it, point), 5 to 18 m away and
    /// within about 15 degrees of the direction `across`.
    pub fn opposite(&self, walkway: usize, position: DVec3, across: DVec2) -> Option<(usize, f64, DVec2)> {
        let from = position.truncate();
        let mut best: Option<(usize, f64, DVec2, f64)> = None;
        for i in self.usable().filter(|i| *i != walkway) {
            let (lo, hi) = self.bounds[i];
            if (from - from.clamp(lo, hi)).length() > 18.0 {
                continue;
            }
            for (pair, s_m) in self.middles[i].points().windows(2).zip(self.middles[i].s_m()) {
                let (a, d) = (pair[0], pair[1] - pair[0]);
                let t = ((from - a).dot(d) / d.length_squared().max(1e-9)).clamp(0.0, 1.0);
                let to = a + d * t - from;
                let distance = to.length();
                let is_level = (self.z_m(i, *s_m) - position.z).abs() < LEVEL_M;
                let straight = is_level && to.dot(across) > 0.966 * distance;
                if straight && (5.0..18.0).contains(&distance) && best.is_none_or(|b| distance < b.3) {
                    best = Some((i, s_m + t * d.length(), a + d * t, distance));
                }
            }
        }
        best.map(|(i, s, at, _)| (i, s, at))
    }
}
