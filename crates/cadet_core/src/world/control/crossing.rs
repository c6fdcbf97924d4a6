//! Where people cross a road, and when.

use super::avoidance::SHOULDER_M;
use super::motion::Motion;
use crate::math::{DVec2, DVec3};
use crate::world::streets::Streets;
use crate::world::surroundings::Surroundings;

/// Gap in traffic, in seconds before the car arrives, that people accept beyond the time they need.
const MARGIN_S: f64 = 2.0;
pub(super) const CROSSING_MPS: f64 = 1.5;

/// The wait before crossing straight over from a place of a walkway: to a sidewalk with a driving lane between and nothing
/// parked in the way.
pub(super) fn way_across(
    position: DVec3,
    walkway: usize,
    s_m: f64,
    around: &Surroundings,
    streets: &Streets,
) -> Option<Motion> {
    let spot = streets.sidewalks.spot(walkway, s_m);
    let from = position.truncate();
    [spot.tangent.perp(), -spot.tangent.perp()].into_iter().find_map(|across| {
        let (other, other_s_m, to) = streets.sidewalks.opposite(walkway, from, across)?;
        let way = |t: f64| from.lerp(to, t);
        let is_clear = (0..=20)
            .map(|k| way(f64::from(k) / 20.0))
            .all(|p| around.standing.iter().all(|o| (o.closest_point(p) - p).length() > SHOULDER_M + 0.1));
        let leads_over_a_lane = (1..10)
            .map(|k| way(f64::from(k) / 10.0))
            .any(|p| streets.roads.nearest(p.extend(position.z), None, 1.0).is_some());
        (is_clear && leads_over_a_lane).then_some(Motion::Waits { from, to, walkway: other, s_m: other_s_m })
    })
}

/// Whether no vehicle will be on the way across before one is over.
pub(super) fn is_free_to_cross(from: DVec2, to: DVec2, around: &Surroundings) -> bool {
    let need_s = (to - from).length() / CROSSING_MPS + MARGIN_S;
    let way = to - from;
    let distance_to_way = |p: DVec2| {
        let t = ((p - from).dot(way) / way.length_squared()).clamp(0.0, 1.0);
        (from + way * t - p).length()
    };
    around.vehicles.iter().all(|vehicle| {
        let footprint = &vehicle.footprint;
        let speed = footprint.velocity.length();
        let standing = speed < 0.2;
        let half_m = footprint.half_length_m;
        if distance_to_way(footprint.center) < half_m + 1.2 {
            return false;
        }
        let ahead = around.way_ahead(vehicle.agent).iter();
        ahead.filter(|a| distance_to_way(a.at) < footprint.half_width_m + 0.6).all(|a| {
            let gap_m = a.distance_m - half_m;
            if standing { gap_m > 2.5 } else { gap_m > speed * need_s }
        })
    })
}
