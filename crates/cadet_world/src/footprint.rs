//! Rectangles in the plane: what agents cover, and what others have to keep off.

use super::params::{COS_SAME_WAY, LEVEL_M, STEEP_SLOPE};
use cadet_base::frames;
use cadet_base::math::{DPose3, DVec2, DVec3};
use cadet_base::plane::OrientedRect;

/// A rectangle on the ground, and how it moves.
#[derive(Debug, Clone, Copy)]
pub(super) struct Footprint {
    pub center: DVec2,
    /// Unit vector along its length.
    pub heading: DVec2,
    pub half_length_m: f64,
    pub half_width_m: f64,
    /// Height of the ground below.
    pub z_m: f64,
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
            z_m: world_from_box.translation.z,
            velocity,
        }
    }

    /// What a box that stands upright at a place covers.
    pub fn of_upright(size_lwh: DVec3, at: DVec3, yaw_rad: f64) -> Self {
        Self::of_box(&frames::upright(at, yaw_rad), size_lwh, DVec2::ZERO)
    }

    /// The rectangle alone.
    pub fn rect(&self) -> OrientedRect {
        let Self { center, heading, half_length_m, half_width_m, .. } = *self;
        OrientedRect { center, axis: heading, half: DVec2::new(half_length_m, half_width_m) }
    }

    /// What stands there for good.
    pub fn standing(rect: &OrientedRect, z_m: f64) -> Self {
        let OrientedRect { center, axis: heading, half } = *rect;
        Self { center, heading, half_length_m: half.x, half_width_m: half.y, z_m, velocity: DVec2::ZERO }
    }

    /// Whether somebody at a place could meet it on one road, and is not on a bridge over it or below.
    pub fn is_level_with(&self, at: DVec2, z_m: f64) -> bool {
        (self.z_m - z_m).abs() < LEVEL_M + STEEP_SLOPE * (self.center - at).length()
    }

    /// The point of the rectangle nearest to `p`.
    pub fn closest_point(&self, p: DVec2) -> DVec2 {
        self.rect().closest_point(p)
    }

    /// How far `p` is from the rectangle; 0 inside it.
    pub fn distance_m(&self, p: DVec2) -> f64 {
        (self.closest_point(p) - p).length()
    }

    /// Whether a point of the rectangle is nearer to `p` than `reach_m`.
    pub fn is_within(&self, p: DVec2, reach_m: f64) -> bool {
        self.rect().is_within(p, reach_m)
    }

    /// Whether two rectangles overlap.
    pub fn overlaps(&self, other: &Self) -> bool {
        self.is_level_with(other.center, other.z_m) && self.rect().overlaps(&other.rect())
    }

    /// Whether it goes the same way as another and its front is farther on: of two side by side it goes first.
    pub fn leads(&self, other: &Self) -> bool {
        let front_m = |o: &Self| o.center.dot(self.heading) + o.half_length_m;
        self.heading.dot(other.heading) > COS_SAME_WAY && front_m(self) > front_m(other)
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
