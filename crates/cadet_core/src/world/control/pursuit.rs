//! The steering wheel: pure pursuit of the route.

use crate::math::{self, DVec2};
use crate::world::roads::Roads;
use crate::world::route::Route;

/// Longer than any car's or van's.
const LONG_WHEELBASE_M: f64 = 4.4;
/// The farthest that one aims on a motorway.
const FAST_REACH_M: f64 = 28.0;

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
    // A long vehicle looks past its front axle.
    let (least_m, most_m) =
        if wheelbase_m > LONG_WHEELBASE_M { (0.85 * wheelbase_m, 1.9 * wheelbase_m) } else { (3.0, 9.0) };
    let most_m = if roads.is_fast(route.lanes[0]) { FAST_REACH_M } else { most_m };
    let reach_m = (0.55 * speed_mps.abs() + 1.6).clamp(least_m, most_m);
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
