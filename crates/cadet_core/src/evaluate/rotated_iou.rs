//! Intersection of rotated rectangles by clipping, in double precision.
//!
//! One rectangle is clipped against the other in the other's own frame, where the second one's sides are upright. So
//! coordinates stay as small as the boxes, parallel edges need no special case, and boxes that are equal share exactly
//! their area at any heading.

use cadet_base::math;

/// A box in KITTI's rectified camera frame (x right, y down, z forward): meters and radians, bottom center.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct RotatedBox {
    /// Right.
    pub x: f64,
    /// Down; the bottom face's height.
    pub y: f64,
    /// Forward.
    pub z: f64,
    /// Length, along the heading.
    pub length_m: f64,
    /// Width.
    pub width_m: f64,
    /// Height; the box reaches from y - height to y.
    pub height_m: f64,
    /// Heading about the y axis, 0 along x.
    pub rotation_y: f64,
}

impl RotatedBox {
    /// A box from `[x, y, z, l, w, h, rotation_y]`.
    #[must_use]
    pub fn from_array([x, y, z, length_m, width_m, height_m, rotation_y]: [f64; 7]) -> Self {
        Self { x, y, z, length_m, width_m, height_m, rotation_y }
    }

    /// `[x, y, z, l, w, h, rotation_y]`.
    #[must_use]
    pub fn to_array(&self) -> [f64; 7] {
        [self.x, self.y, self.z, self.length_m, self.width_m, self.height_m, self.rotation_y]
    }

    /// Area seen from above, in square meters. KITTI's -1 x -1 m mark for "unknown" has area 1.
    #[must_use]
    pub fn area_bev_m2(&self) -> f64 {
        self.length_m * self.width_m
    }

    /// Volume in cubic meters.
    #[must_use]
    pub fn volume_m3(&self) -> f64 {
        self.height_m * self.area_bev_m2()
    }

    /// The height shared with another box in meters, 0 where they only touch.
    #[must_use]
    pub fn shared_height_m(&self, other: &Self) -> f64 {
        // The least of bottom - top over both boxes, written so that equal boxes share exactly their height.
        let lower = self.y - other.y;
        self.height_m.min(other.height_m).min(self.height_m - lower).min(other.height_m + lower).max(0.0)
    }

    fn is_before(&self, other: &Self) -> bool {
        let order = self.to_array().iter().zip(other.to_array()).map(|(a, b)| a.total_cmp(&b)).find(|o| o.is_ne());
        order.is_some_and(std::cmp::Ordering::is_lt)
    }
}

/// The area in square meters that two boxes share seen from above. Exactly symmetric in its arguments.
///
/// A box whose length and width differ in sign bounds no rectangle and shares nothing.
#[must_use]
pub fn intersection_bev_m2(a: &RotatedBox, b: &RotatedBox) -> f64 {
    let (area_a, area_b) = (a.area_bev_m2(), b.area_bev_m2());
    // NaN fails too.
    if !(area_a > 0.0 && area_b > 0.0) {
        return 0.0;
    }
    let (dx, dz) = (b.x - a.x, b.z - a.z);
    let diagonal = |o: &RotatedBox| (o.length_m * o.length_m + o.width_m * o.width_m).sqrt();
    let reach = 0.5 * (diagonal(a) + diagonal(b));
    if dx * dx + dz * dz >= reach * reach {
        return 0.0;
    }
    // Rounding differs with the frame that is chosen, so the choice must not depend on the order of the arguments.
    let shared = if b.is_before(a) { clipped_area(b, a) } else { clipped_area(a, b) };
    shared.clamp(0.0, area_a.min(area_b))
}

/// Intersection over union seen from above, in [0, 1].
#[must_use]
pub fn iou_bev(a: &RotatedBox, b: &RotatedBox) -> f64 {
    ratio(intersection_bev_m2(a, b), a.area_bev_m2(), b.area_bev_m2())
}

/// Intersection over union of volumes, in [0, 1] for boxes of positive size.
#[must_use]
pub fn iou_3d(a: &RotatedBox, b: &RotatedBox) -> f64 {
    iou_3d_from(intersection_bev_m2(a, b), a, b)
}

/// [`iou_3d`] of boxes whose intersection from above is known.
#[must_use]
pub fn iou_3d_from(shared_bev_m2: f64, a: &RotatedBox, b: &RotatedBox) -> f64 {
    ratio(shared_bev_m2 * a.shared_height_m(b), a.volume_m3(), b.volume_m3())
}

/// [`iou_bev`] of boxes whose intersection from above is known.
#[must_use]
pub fn iou_bev_from(shared_bev_m2: f64, a: &RotatedBox, b: &RotatedBox) -> f64 {
    ratio(shared_bev_m2, a.area_bev_m2(), b.area_bev_m2())
}

fn ratio(shared: f64, size_a: f64, size_b: f64) -> f64 {
    if shared > 0.0 { (shared / (size_a + size_b - shared)).min(1.0) } else { 0.0 }
}

/// At most eight corners: each of the four cuts adds one to the four of a rectangle.
#[derive(Clone, Copy)]
struct Polygon {
    corners: [[f64; 2]; 8],
    count: usize,
}

impl Polygon {
    const EMPTY: Self = Self { corners: [[0.0; 2]; 8], count: 0 };

    fn push(&mut self, corner: [f64; 2]) {
        // Rounding can make a convex polygon cross a line more than twice; the surplus has no area.
        if self.count < self.corners.len() {
            self.corners[self.count] = corner;
            self.count += 1;
        }
    }

    /// Keeps what lies at `sign * coordinate <= limit`.
    fn cut(&self, axis: usize, sign: f64, limit: f64) -> Self {
        let mut kept = Self::EMPTY;
        for i in 0..self.count {
            let (from, to) = (self.corners[i], self.corners[(i + 1) % self.count]);
            let (out_from, out_to) = (sign * from[axis] - limit, sign * to[axis] - limit);
            if out_from <= 0.0 {
                kept.push(from);
            }
            if (out_from < 0.0 && out_to > 0.0) || (out_from > 0.0 && out_to < 0.0) {
                let share = out_from / (out_from - out_to);
                let mut crossing = [from[0] + share * (to[0] - from[0]), from[1] + share * (to[1] - from[1])];
                crossing[axis] = sign * limit;
                kept.push(crossing);
            }
        }
        kept
    }

    fn area(&self) -> f64 {
        // Two sums, so that those of a rectangle are exact.
        let mut twice = [0.0; 2];
        for i in 0..self.count {
            let (from, to) = (self.corners[i], self.corners[(i + 1) % self.count]);
            twice[i % 2] += from[0] * to[1] - to[0] * from[1];
        }
        0.5 * (twice[0] + twice[1]).abs()
    }
}

fn clipped_area(frame: &RotatedBox, other: &RotatedBox) -> f64 {
    let (cos, sin) = (math::cos(frame.rotation_y), math::sin(frame.rotation_y));
    let (dx, dz) = (other.x - frame.x, other.z - frame.z);
    let center = [dx * cos - dz * sin, dx * sin + dz * cos];
    let turn = other.rotation_y - frame.rotation_y;
    let (cos, sin) = (math::cos(turn), math::sin(turn));
    let (u, v) = (0.5 * other.length_m.abs(), 0.5 * other.width_m.abs());
    let mut polygon = Polygon::EMPTY;
    for (u, v) in [(u, v), (u, -v), (-u, -v), (-u, v)] {
        polygon.push([center[0] + u * cos + v * sin, center[1] - u * sin + v * cos]);
    }
    for (axis, half) in [0.5 * frame.length_m.abs(), 0.5 * frame.width_m.abs()].into_iter().enumerate() {
        polygon = polygon.cut(axis, 1.0, half).cut(axis, -1.0, half);
    }
    polygon.area()
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::f64::consts::{FRAC_PI_2, FRAC_PI_4, PI, SQRT_2};

    fn flat(x: f64, z: f64, length: f64, width: f64, rotation_y: f64) -> RotatedBox {
        RotatedBox { x, y: 1.5, z, length_m: length, width_m: width, height_m: 1.5, rotation_y }
    }

    #[test]
    fn known_polygons_have_their_areas() {
        let unit = flat(0.0, 0.0, 2.0, 2.0, 0.0);
        // A square and its copy turned by 45 degrees share a regular octagon: 8 (sqrt 2 - 1) of the circumscribed unit.
        let octagon = 8.0 * (SQRT_2 - 1.0);
        assert!((intersection_bev_m2(&unit, &flat(0.0, 0.0, 2.0, 2.0, FRAC_PI_4)) - octagon).abs() < 1e-14);
        // A quarter.
        assert_eq!(intersection_bev_m2(&unit, &flat(1.0, 1.0, 2.0, 2.0, 0.0)), 1.0);
        // A corner of the turned one reaches in: a right isosceles triangle of height 1.
        let tip = flat(1.0 + SQRT_2 - 1.0, 0.0, 2.0, 2.0, FRAC_PI_4);
        assert!((intersection_bev_m2(&unit, &tip) - 1.0).abs() < 1e-14);
        // One inside the other.
        assert!((intersection_bev_m2(&unit, &flat(0.1, -0.2, 0.5, 0.25, 1.0)) - 0.125).abs() < 1e-15);
    }

    #[test]
    fn heading_turns_length_from_x_towards_minus_z() {
        let long = flat(0.0, 0.0, 4.0, 1.0, FRAC_PI_4);
        let spot = |x, z| flat(x, z, 0.1, 0.1, 0.0);
        assert!(intersection_bev_m2(&long, &spot(1.0, -1.0)) > 0.0099);
        assert_eq!(intersection_bev_m2(&long, &spot(1.0, 1.0)), 0.0);
    }

    #[test]
    fn touching_boxes_share_nothing() {
        let unit = flat(0.0, 0.0, 2.0, 2.0, 0.0);
        assert_eq!(iou_bev(&unit, &flat(2.0, 0.0, 2.0, 2.0, 0.0)), 0.0);
        assert_eq!(iou_3d(&unit, &RotatedBox { y: 0.0, ..unit }), 0.0);
        assert_eq!(iou_3d(&unit, &RotatedBox { y: 0.75, ..unit }), 1.0 / 3.0);
    }

    #[test]
    fn nearly_parallel_edges_keep_their_area() {
        let car = flat(-3.0, 40.0, 3.9, 1.6, 0.3);
        for exponent in 1..18 {
            let tiny = (0..exponent).fold(1.0, |t: f64, _| t * 0.1);
            for turn in [0.0, FRAC_PI_2, PI] {
                let other = RotatedBox { rotation_y: 0.3 + turn + tiny, ..car };
                let square = RotatedBox { width_m: 3.9, ..car };
                let turned = RotatedBox { width_m: 3.9, ..other };
                let bound = 1.0 - 2.0 * tiny - 1e-12;
                assert!(iou_bev(&square, &turned) >= bound, "{turn} {tiny}");
                if turn != FRAC_PI_2 {
                    assert!(iou_bev(&car, &other) >= 1.0 - 6.0 * tiny - 1e-12, "{turn} {tiny}");
                }
            }
        }
    }

    #[test]
    fn kittis_mark_for_unknown_is_a_unit_square() {
        let unknown = RotatedBox::from_array([-1000.0, -1000.0, -1000.0, -1.0, -1.0, -1.0, -10.0]);
        assert_eq!(intersection_bev_m2(&unknown, &unknown), 1.0);
        assert_eq!(iou_3d(&unknown, &unknown), 0.0);
        assert_eq!(intersection_bev_m2(&unknown, &RotatedBox { length_m: 1.0, ..unknown }), 0.0);
    }
}
