//! Rectangles in the plane.

use crate::math::DVec2;

/// A rectangle in the plane, turned by any angle.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct OrientedRect {
    /// Its middle.
    pub center: DVec2,
    /// Unit vector along its x axis.
    pub axis: DVec2,
    /// Half extents along and across the axis.
    pub half: DVec2,
}

impl OrientedRect {
    /// The rectangle about the line from one place to another, which reaches `half_width_m` to both sides of it.
    pub fn about_line(from: DVec2, to: DVec2, half_width_m: f64) -> Self {
        let half = DVec2::new((to - from).length() / 2.0, half_width_m);
        Self { center: (from + to) / 2.0, axis: (to - from).normalize_or(DVec2::X), half }
    }

    /// The corners, counter-clockwise.
    #[inline]
    pub fn corners(&self) -> [DVec2; 4] {
        let (x, y) = (self.axis * self.half.x, self.axis.perp() * self.half.y);
        [self.center - x - y, self.center + x - y, self.center + x + y, self.center - x + y]
    }

    /// True where the insides meet (separating axes).
    pub fn overlaps(&self, other: &Self) -> bool {
        let apart = |axis: DVec2| {
            let reach = |r: &Self| r.axis.dot(axis).abs() * r.half.x + r.axis.perp().dot(axis).abs() * r.half.y;
            (other.center - self.center).dot(axis).abs() >= reach(self) + reach(other)
        };
        ![self.axis, self.axis.perp(), other.axis, other.axis.perp()].into_iter().any(apart)
    }

    /// True inside, or within `margin_m` of it along its axes.
    #[inline]
    pub fn contains(&self, point: DVec2, margin_m: f64) -> bool {
        let d = point - self.center;
        d.dot(self.axis).abs() <= self.half.x + margin_m && d.dot(self.axis.perp()).abs() <= self.half.y + margin_m
    }

    /// The point of the rectangle nearest to a place.
    #[inline]
    pub fn closest_point(&self, place: DVec2) -> DVec2 {
        let d = place - self.center;
        let along = d.dot(self.axis).clamp(-self.half.x, self.half.x);
        let across = d.dot(self.axis.perp()).clamp(-self.half.y, self.half.y);
        self.center + self.axis * along + self.axis.perp() * across
    }

    /// Whether a point of the rectangle is nearer to a place than a reach.
    #[inline]
    pub fn is_within(&self, place: DVec2, reach_m: f64) -> bool {
        // Most are far away: the sum of the sides tells without a look at the axis.
        let farthest_m = reach_m + self.half.x + self.half.y;
        (self.center - place).length_squared() < farthest_m * farthest_m
            && (self.closest_point(place) - place).length() < reach_m
    }

    /// The rectangle grown on all sides.
    pub fn grown(&self, by_m: f64) -> Self {
        Self { half: self.half + DVec2::splat(by_m), ..*self }
    }

    /// Points inside, at most `step_m` apart, the corners among them.
    pub fn samples(&self, step_m: f64) -> impl Iterator<Item = DVec2> + '_ {
        let count = |half: f64| ((2.0 * half / step_m).ceil() as usize).max(1);
        let (nx, ny) = (count(self.half.x), count(self.half.y));
        (0..=nx).flat_map(move |i| {
            (0..=ny).map(move |j| {
                let (u, v) = (2.0 * i as f64 / nx as f64 - 1.0, 2.0 * j as f64 / ny as f64 - 1.0);
                self.center + self.axis * (self.half.x * u) + self.axis.perp() * (self.half.y * v)
            })
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::math::{cos, sin};
    use crate::rng::Stream;

    #[test]
    fn overlap_agrees_with_dense_samples() {
        let mut s = Stream::from_seed("rects", 1);
        for _ in 0..400 {
            let mut draw = || {
                let a = s.range(0.0, 6.0);
                OrientedRect {
                    center: DVec2::new(s.range(-5.0, 5.0), s.range(-5.0, 5.0)),
                    axis: DVec2::new(cos(a), sin(a)),
                    half: DVec2::new(s.range(0.5, 4.0), s.range(0.5, 4.0)),
                }
            };
            let (p, q) = (draw(), draw());
            let sampled = p.samples(0.1).any(|x| q.contains(x, -0.01)) || q.samples(0.1).any(|x| p.contains(x, -0.01));
            if sampled {
                assert!(p.overlaps(&q), "{p:?} {q:?}");
            } else {
                let shrunk = |r: OrientedRect| OrientedRect { half: r.half - DVec2::splat(0.12), ..r };
                assert!(!shrunk(p).overlaps(&shrunk(q)), "{p:?} {q:?}");
            }
        }
    }
}
