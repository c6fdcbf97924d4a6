//! Rectangles in the plane: what agents cover, and what others have to keep off.

use super::params::SAME_WAY;
use crate::math::{DPose3, DVec2, DVec3};

/// A rectangle on the ground, and how it moves.
#[derive(Debug, Clone, Copy)]
pub(super) struct Footprint {
    pub center: DVec2,
    /// Unit vector along its length.
    pub heading: DVec2,
    pub half_length_m: f64,
    pub half_width_m: f64,
    pub velocity: DVec2,
}

impl Footprint {
    /// What a box covers in the plane.
    pub fn of_box(world_from_box: &DPose3, size_lwh: DVec3, velocity: DVec2) -> Self {
        Self {
            center: world_from_box.translation.truncate(),
            heading: (world_from_box.rotation * DVec3::X).truncate().normalize(),
            half_length_m: size_lwh.x / 2.0,
            half_width_m: size_lwh.y / 2.0,
            velocity,
        }
    }

    /// The point of the rectangle nearest to `p`.
    pub fn closest_point(&self, p: DVec2) -> DVec2 {
        let d = p - self.center;
        let along = d.dot(self.heading).clamp(-self.half_length_m, self.half_length_m);
        let across = d.dot(self.heading.perp()).clamp(-self.half_width_m, self.half_width_m);
        self.center + self.heading * along + self.heading.perp() * across
    }

    /// Whether a point of the rectangle is nearer to `p` than `reach_m`.
    pub fn is_within(&self, p: DVec2, reach_m: f64) -> bool {
        // Most are far away: the sum of the sides tells without a look at the heading.
        let farthest_m = reach_m + self.half_length_m + self.half_width_m;
        (self.center - p).length_squared() < farthest_m * farthest_m && (self.closest_point(p) - p).length() < reach_m
    }

    /// Whether two rectangles overlap (separating axes).
    pub fn overlaps(&self, other: &Self) -> bool {
        let d = other.center - self.center;
        let separated = |axis: DVec2| {
            let extent = |o: &Self| {
                o.half_length_m * o.heading.dot(axis).abs() + o.half_width_m * o.heading.perp().dot(axis).abs()
            };
            d.dot(axis).abs() > extent(self) + extent(other)
        };
        ![self.heading, self.heading.perp(), other.heading, other.heading.perp()].into_iter().any(separated)
    }

    /// Whether it goes the same way as another and its front is farther on: of two side by side it goes first.
    pub fn leads(&self, other: &Self) -> bool {
        let front_m = |o: &Self| o.center.dot(self.heading) + o.half_length_m;
        self.heading.dot(other.heading) > SAME_WAY && front_m(self) > front_m(other)
    }

    /// What it covers until so much time is over, if it goes straight on.
    pub fn swept(&self, time_s: f64) -> Self {
        let way = self.velocity * time_s;
        Self {
            center: self.center + way / 2.0,
            heading: way.normalize_or(self.heading),
            half_length_m: self.half_length_m + way.length() / 2.0,
            ..*self
        }
    }

    /// The rectangle grown on all sides.
    pub fn grown(&self, by_m: f64) -> Self {
        Self { half_length_m: self.half_length_m + by_m, half_width_m: self.half_width_m + by_m, ..*self }
    }
}
