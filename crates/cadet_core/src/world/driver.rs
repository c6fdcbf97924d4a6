//! A driver: pure pursuit along the route, the intelligent driver model for the pedals.

use super::route::{Ahead, Roads, Route};
use crate::math::{self, DVec2};
use crate::rng::Stream;

/// Comfortable deceleration.
pub(super) const COMFORTABLE_MPS2: f64 = 2.0;
const ACCELERATION_MPS2: f64 = 1.2;
/// Bumper to bumper at a standstill, and the mean time gap: of traffic, and of who drives the sensors. Of KITTI's cars
/// none is ahead in the own lane within 7 m of the camera, and one in a hundred within 20 m.
const TRAFFIC_KEEPS: (f64, f64) = (2.0, 1.2);
const EGO_KEEPS: (f64, f64) = (4.5, 2.2);
const HARDEST_BRAKING_MPS2: f64 = -7.0;

/// A driver's habits (specification of traffic, section 4.3: Gaussian desired speed and time gap).
#[derive(Debug, Clone, Copy)]
pub(super) struct Habits {
    /// Desired speed as a fraction of what limit and bends allow.
    pub eagerness: f64,
    /// Time gap to the car ahead.
    pub headway_s: f64,
    /// Bumper to bumper at a standstill.
    pub standstill_gap_m: f64,
}

impl Habits {
    pub fn draw(stream: &mut Stream) -> Self {
        Self::keeping(TRAFFIC_KEEPS, stream)
    }

    /// Of the ego's driver, who keeps away from the car ahead.
    pub fn draw_of_ego(stream: &mut Stream) -> Self {
        Self::keeping(EGO_KEEPS, stream)
    }

    fn keeping((standstill_gap_m, headway_s): (f64, f64), stream: &mut Stream) -> Self {
        Self {
            eagerness: stream.clipped_normal(1.0, 0.09),
            headway_s: stream.clipped_normal(headway_s, 0.25),
            standstill_gap_m,
        }
    }

    /// Acceleration on a free road.
    pub fn free_road(&self, speed_mps: f64, desired_mps: f64) -> f64 {
        let ratio = (speed_mps.max(0.0) / desired_mps.max(0.5)).min(2.0);
        (ACCELERATION_MPS2 * (1.0 - ratio * ratio * ratio * ratio)).max(-3.0)
    }

    /// What a gap to something ahead takes off the free road's acceleration.
    pub fn interaction(&self, speed_mps: f64, gap_m: f64, leader_mps: f64) -> f64 {
        let v = speed_mps.max(0.0);
        let closing = v * (v - leader_mps) / (2.0 * (ACCELERATION_MPS2 * COMFORTABLE_MPS2).sqrt());
        let wanted = self.standstill_gap_m + (v * self.headway_s + closing).max(0.0);
        let ratio = wanted / gap_m.max(0.2);
        -ACCELERATION_MPS2 * ratio * ratio
    }
}

/// The pedals: free road and the worst of the gaps, within what brakes can do.
pub(super) fn pedals(free_mps2: f64, worst_interaction_mps2: f64) -> f64 {
    (free_mps2 + worst_interaction_mps2).clamp(HARDEST_BRAKING_MPS2, ACCELERATION_MPS2 * 1.2)
}

/// Steering angle of pure pursuit: the arc from the rear axle through a point of the route ahead.
pub(super) fn pursue(
    rear_axle: DVec2,
    heading: DVec2,
    wheelbase_m: f64,
    rear_axle_m: f64,
    speed_mps: f64,
    route: &Route,
    roads: &Roads,
) -> f64 {
    let reach_m = (0.55 * speed_mps.abs() + 1.6).clamp(3.0, 9.0);
    // The route measures from the box's middle, pursuit from the axle behind it.
    let place = route.ahead(reach_m - rear_axle_m, roads);
    // The middle of the car is to follow the line, so in a bend the axle runs inside of it.
    let (before, after) = (route.ahead(place.distance_m - 1.0, roads), route.ahead(place.distance_m + 1.0, roads));
    let curvature = before.tangent.perp_dot(after.tangent) / 2.0;
    let inwards = place.tangent.perp() * (curvature * rear_axle_m * rear_axle_m / 2.0);
    let target = place.at + inwards - rear_axle;
    let sideways = heading.perp_dot(target);
    math::atan(2.0 * wheelbase_m * sideways / target.length_squared().max(1.0))
}

/// Something in the way: a rectangle on the road.
#[derive(Debug, Clone, Copy)]
pub(super) struct Obstacle {
    pub center: DVec2,
    /// Unit vector along its length.
    pub heading: DVec2,
    pub half_length_m: f64,
    pub half_width_m: f64,
    pub velocity: DVec2,
}

impl Obstacle {
    /// The point of the rectangle nearest to `p`.
    pub fn closest_point(&self, p: DVec2) -> DVec2 {
        let d = p - self.center;
        let along = d.dot(self.heading).clamp(-self.half_length_m, self.half_length_m);
        let across = d.dot(self.heading.perp()).clamp(-self.half_width_m, self.half_width_m);
        self.center + self.heading * along + self.heading.perp() * across
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

    /// The rectangle grown on all sides.
    pub fn grown(&self, by_m: f64) -> Self {
        Self { half_length_m: self.half_length_m + by_m, half_width_m: self.half_width_m + by_m, ..*self }
    }
}

/// The gap from the front bumper to the first contact with an obstacle along the route, and the obstacle's speed along
/// the route there. `corridor_m` is half the width that the car needs.
pub(super) fn gap_along(
    ahead: &[Ahead],
    spacing_m: f64,
    half_length_m: f64,
    corridor_m: f64,
    obstacle: &Obstacle,
) -> Option<(f64, f64)> {
    ahead.iter().find_map(|sample| {
        let to = obstacle.closest_point(sample.at) - sample.at;
        let along = to.dot(sample.tangent);
        let across = sample.tangent.perp_dot(to).abs();
        let gap_m = sample.distance_m + along - half_length_m;
        // What the front has passed is beside us and no longer ours to avoid.
        (along.abs() <= spacing_m && across < corridor_m && gap_m > -1.0)
            .then(|| (gap_m, obstacle.velocity.dot(sample.tangent).max(0.0)))
    })
}
