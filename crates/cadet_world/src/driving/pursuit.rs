//! The steering wheel: pure pursuit of the route.

use crate::streets::{LaneGraph, Route};
use cadet_base::math::{self, DVec2};

/// Longer than any car's or van's.
const LONG_WHEELBASE_M: f64 = 4.4;
/// The farthest that one aims on a motorway.
const FAST_REACH_M: f64 = 28.0;

/// Where the axles of a vehicle are.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Axles {
    pub wheelbase_m: f64,
    /// From the middle of the box back to the rear axle.
    pub rear_m: f64,
}

/// Steering angle of pure pursuit: the arc from the rear axle through a point of the route ahead of the place where the
/// vehicle's middle is, so far along it.
pub(crate) fn pursue(
    rear_axle: DVec2,
    heading: DVec2,
    axles: Axles,
    speed_mps: f64,
    (route, from_m): (&Route, f64),
    graph: &LaneGraph,
) -> f64 {
    let Axles { wheelbase_m, rear_m } = axles;
    // A long vehicle looks past its front axle.
    let (least_m, most_m) =
        if wheelbase_m > LONG_WHEELBASE_M { (0.85 * wheelbase_m, 1.9 * wheelbase_m) } else { (3.0, 9.0) };
    let most_m = if graph.is_fast(route.lanes[0]) { FAST_REACH_M } else { most_m };
    let reach_m = (0.55 * speed_mps.abs() + 1.6).clamp(least_m, most_m);
    // The route measures from the box's middle, pursuit from the axle behind it.
    let place = route.ahead(from_m + reach_m - rear_m, graph);
    // The middle of the car is to follow the line, so in a bend the axle runs inside of it.
    let (before, after) = (route.ahead(place.distance_m - 1.0, graph), route.ahead(place.distance_m + 1.0, graph));
    let curvature = before.tangent.perp_dot(after.tangent) / 2.0;
    let inwards = place.tangent.perp() * (curvature * rear_m * rear_m / 2.0);
    let target = place.at + inwards - rear_axle;
    let sideways = heading.perp_dot(target);
    math::atan(2.0 * wheelbase_m * sideways / target.length_squared().max(1.0))
}
