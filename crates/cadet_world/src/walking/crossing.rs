//! Where people cross a road, and when: where it is free, or on fords when their light is green.

use super::motion::Motion;
use crate::params::CRAWLS_MPS;
use crate::params::walking::{CROSSING_MPS, FAR_M, FIRM_MPS2, MARGIN_S, REACTION_S, SHOULDER_M};
use crate::physics::DT_S;
use crate::streets::Streets;
use crate::traffic_state::TrafficState;
use cadet_base::math::{DVec2, DVec3};
use cadet_town::CrossingRule;

/// The wait before crossing straight over from a place of a walkway: to a sidewalk with a driving lane between and nothing
/// parked in the way.
pub(crate) fn way_across(
    position: DVec3,
    walkway: usize,
    s_m: f64,
    around: &TrafficState,
    streets: &Streets,
) -> Option<Motion> {
    let spot = streets.sidewalks.spot(walkway, s_m);
    let from = position.truncate();
    [spot.tangent.perp(), -spot.tangent.perp()].into_iter().find_map(|across| {
        let (other, other_s_m, to) = streets.sidewalks.opposite(walkway, position, across)?;
        if streets.graph.signals().crossing_rule(from, to) == CrossingRule::Nowhere {
            return None;
        }
        let way = |t: f64| from.lerp(to, t);
        let is_clear = (0..=20)
            .map(|k| way(f64::from(k) / 20.0))
            .all(|p| around.standing.iter().all(|o| o.distance_m(p) > SHOULDER_M + 0.1));
        let leads_over_a_lane = (1..10)
            .map(|k| way(f64::from(k) / 10.0))
            .any(|p| streets.graph.nearest(p.extend(position.z), None, 1.0).is_some());
        (is_clear && leads_over_a_lane).then_some(Motion::Waits { from, to, walkway: other, s_m: other_s_m })
    })
}

/// Whether one may step off the curb at a height: on a ford when it is green and nobody comes who could not stop, on a zebra crossing
/// when nobody comes who could not stop, elsewhere when no vehicle will be on the way.
pub(crate) fn may_start(
    (from, to): (DVec2, DVec2),
    z_m: f64,
    around: &TrafficState,
    streets: &Streets,
    step: u64,
) -> bool {
    let signals = streets.graph.signals();
    match signals.crossing_rule(from, to) {
        CrossingRule::Ford(ford) => signals.may_walk(ford, step as f64 * DT_S) && is_let_over((from, to), z_m, around),
        CrossingRule::Zebra => is_let_over((from, to), z_m, around),
        CrossingRule::Anywhere | CrossingRule::Nowhere => is_free_to_cross((from, to), z_m, around),
    }
}

fn distance_to_way(from: DVec2, to: DVec2, p: DVec2) -> f64 {
    let way = to - from;
    let t = ((p - from).dot(way) / way.length_squared()).clamp(0.0, 1.0);
    (from + way * t - p).length()
}

/// Whether no vehicle is on a ford or so near that it could not stop any more.
fn is_let_over((from, to): (DVec2, DVec2), z_m: f64, around: &TrafficState) -> bool {
    let distance_to_way = |p: DVec2| distance_to_way(from, to, p);
    around.vehicles_level_with(from, z_m).all(|vehicle| {
        let footprint = &vehicle.footprint;
        if (footprint.center - from).length() > (to - from).length() + FAR_M {
            return true;
        }
        let nearest = footprint.closest_point(from + (to - from) * 0.5);
        if distance_to_way(nearest) < 0.6 || distance_to_way(footprint.center) < footprint.half_width_m + 0.6 {
            return false;
        }
        let speed = footprint.velocity.length();
        let stops_m = speed * REACTION_S + speed * speed / (2.0 * FIRM_MPS2);
        let ahead = around.way_ahead(vehicle.agent).iter();
        let onto = ahead.filter(|a| distance_to_way(a.at) < footprint.half_width_m + 0.6);
        speed < CRAWLS_MPS || onto.into_iter().all(|a| a.distance_m - footprint.half_length_m > stops_m)
    })
}

/// Whether no vehicle will be on the way across before one is over.
fn is_free_to_cross((from, to): (DVec2, DVec2), z_m: f64, around: &TrafficState) -> bool {
    let need_s = (to - from).length() / CROSSING_MPS + MARGIN_S;
    let distance_to_way = |p: DVec2| distance_to_way(from, to, p);
    around.vehicles_level_with(from, z_m).all(|vehicle| {
        let footprint = &vehicle.footprint;
        let speed = footprint.velocity.length();
        let standing = speed < CRAWLS_MPS;
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
