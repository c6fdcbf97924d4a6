//! Lines and rectangles in the plane.

mod distance;
mod polyline;
mod rect;

pub use distance::DistanceFrom;
pub use polyline::{Polyline, nearest, piece_at};
pub use rect::OrientedRect;

use crate::math::{self, DVec2};

/// Unit vector at an angle from x.
#[inline]
pub fn unit(heading_rad: f64) -> DVec2 {
    DVec2::new(math::cos(heading_rad), math::sin(heading_rad))
}

/// The edges of a closed line whose first point is not repeated.
pub fn edges<T: Copy>(ring: &[T]) -> impl Iterator<Item = [T; 2]> {
    ring.iter().zip(ring.iter().cycle().skip(1)).map(|(a, b)| [*a, *b])
}

/// The angle from x of a direction, in [-pi, pi].
#[inline]
pub fn heading_rad(direction: DVec2) -> f64 {
    math::atan2(direction.y, direction.x)
}

/// The least and the greatest corner of a box about points: infinite, and inside out, about none.
pub fn bounds(points: impl IntoIterator<Item = DVec2>) -> (DVec2, DVec2) {
    let nowhere = (DVec2::INFINITY, DVec2::NEG_INFINITY);
    points.into_iter().fold(nowhere, |(low, high), p| (low.min(p), high.max(p)))
}
