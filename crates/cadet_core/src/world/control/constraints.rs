//! What who drives or rides along a route has to brake for: traffic, people, junctions, the end of the road.

use super::approach::Crossing;
use super::idm::{COMFORTABLE_MPS2, IdmParameters, gap_along};
use super::pursuit::Axles;
use super::stop_line::stop_line;
use crate::math::DVec2;
use crate::world::footprint::Footprint;
use crate::world::junctions::Refusal;
use crate::world::roads::Roads;
use crate::world::route::{Ahead, Route};
use crate::world::slot::{EGO, Slot};
use crate::world::traffic_state::TrafficState;

/// How far a driver looks.
const SIGHT_M: f64 = 60.0;
const SAMPLE_M: f64 = 1.25;
/// How far one looks when standing, and at least before the front bumper.
const NEAR_M: f64 = 12.0;
const BEFORE_FRONT_M: f64 = 8.0;
/// How far one looks on a motorway.
const FAST_SIGHT_M: f64 = 260.0;
/// Room kept beside what stands, and beside what moves.
pub(crate) const SIDE_STANDING_M: f64 = 0.12;
const SIDE_MOVING_M: f64 = 0.25;
/// The same beside what moves, of who has waited long: two buses pass each other in narrow lanes with less than usual.
const SIDE_MOVING_REDUCED_M: f64 = 0.08;
/// And beside a post or what else stands.
const SIDE_STANDING_REDUCED_M: f64 = 0.04;
/// What is kept in front of all of a vehicle that turns, usually and then.
const SWEPT_M: (f64, f64) = (0.1, 0.03);

/// What a driver brakes for most.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum Cause {
    /// Nothing: the road is free, or nobody drives.
    Nothing,
    /// A vehicle that stands for good in the lane.
    Parked,
    /// A vehicle that moves.
    Vehicle(Slot),
    /// A person on the road.
    Person,
    /// The end of the road.
    RoadEnd,
    /// A junction that others cross or queue behind.
    Junction(Refusal),
}

/// Who goes along a route.
pub(super) struct OnRoute<'a> {
    pub slot: Slot,
    pub footprint: &'a Footprint,
    pub route: &'a Route,
    pub idm: &'a IdmParameters,
    /// Of who steers.
    pub axles: Option<Axles>,
    /// All of a train whose first car this is.
    pub train_m: Option<f64>,
    /// Whether it makes do with little room beside others, having waited.
    pub reduced_clearance: bool,
}

/// The places ahead on a route, from the vehicle's middle on, that matter at a speed.
pub(super) fn in_sight(
    route: &Route,
    speed_mps: f64,
    half_length_m: f64,
    roads: &Roads,
) -> impl Iterator<Item = Ahead> {
    let most_m = if roads.is_fast(route.lanes[0]) { FAST_SIGHT_M } else { SIGHT_M };
    let count = (sight_m(speed_mps, half_length_m).min(most_m) / SAMPLE_M) as usize;
    (0..count).map(|k| route.ahead(k as f64 * SAMPLE_M, roads))
}

/// How far ahead of a vehicle's middle it matters at a speed what stands: where it stops comfortably, and two seconds more.
fn sight_m(speed_mps: f64, half_length_m: f64) -> f64 {
    let near_m = NEAR_M.max(half_length_m + BEFORE_FRONT_M);
    speed_mps * speed_mps / (2.0 * COMFORTABLE_MPS2) + 2.0 * speed_mps + near_m
}

/// What of the traffic on the line so far to the left of the route's takes off the acceleration, and what it is: in the
/// lane that one is changing to.
pub(super) fn traffic_aside(
    on_route: &OnRoute<'_>,
    aside_m: f64,
    ahead: &[Ahead],
    around: &TrafficState,
) -> (f64, Cause) {
    let OnRoute { slot, footprint: own, idm, .. } = *on_route;
    let speed = own.velocity.dot(own.heading);
    let aside: Vec<Ahead> = ahead.iter().map(|a| Ahead { at: a.at + a.tangent.perp() * aside_m, ..*a }).collect();
    let others = around.vehicles.iter().map(|v| (v.agent, &v.footprint));
    let claimed = around.claims().map(|(other, claim)| (other, &claim.footprint));
    others
        .chain(claimed)
        .filter(|(other, _)| *other != slot)
        .filter_map(|(other, o)| {
            let (gap_m, leader_mps) =
                gap_along(&aside, SAMPLE_M, own.half_length_m, own.half_width_m + SIDE_MOVING_M, o)?;
            Some((idm.interaction_accel(speed, gap_m, leader_mps), Cause::Vehicle(other)))
        })
        .fold((0.0, Cause::Nothing), |worst, one| if one.0 < worst.0 { one } else { worst })
}

/// What asks for the hardest braking, given the places ahead on the route: the acceleration that it takes off the free
/// road's, and what it is.
pub(super) fn tightest_constraint(
    on_route: &OnRoute<'_>,
    ahead: &[Ahead],
    around: &mut TrafficState,
    roads: &Roads,
    step: u64,
) -> (f64, Cause) {
    let OnRoute { slot, footprint: own, route, idm, axles, train_m, reduced_clearance } = *on_route;
    let usual_m = (SIDE_STANDING_M, SIDE_MOVING_M, SWEPT_M.0);
    let (side_standing_m, side_moving_m, swept_m) =
        if reduced_clearance { (SIDE_STANDING_REDUCED_M, SIDE_MOVING_REDUCED_M, SWEPT_M.1) } else { usual_m };
    let speed = own.velocity.dot(own.heading);
    let (low, high) =
        ahead.iter().fold((DVec2::INFINITY, DVec2::NEG_INFINITY), |(lo, hi), a| (lo.min(a.at), hi.max(a.at)));
    let mut worst = (0.0_f64, Cause::Nothing);
    let mut brake_for = |interaction: f64, cause: Cause| {
        if interaction < worst.0 {
            worst = (interaction, cause);
        }
    };
    let standing = || around.standing_in_lanes.iter().map(|o| (Cause::Parked, side_standing_m, o));
    // Of two side by side, the one whose front is farther on goes first: else each would wait for the other.
    let others = || around.vehicles.iter().filter(|v| v.agent != slot && !own.leads(&v.footprint));
    let moving = || others().map(|v| (Cause::Vehicle(v.agent), side_moving_m, &v.footprint));
    let people = around.people_on_road.iter().map(|o| (Cause::Person, SIDE_MOVING_M, o));
    let claims = around.claims().filter(|(other, _)| *other != slot);
    let claimed = claims.map(|(other, claim)| (Cause::Vehicle(other), SIDE_MOVING_M, &claim.footprint));
    standing().chain(moving()).chain(claimed).chain(people).for_each(|(cause, side_m, o)| {
        let reach_m = o.half_length_m + o.half_width_m + own.half_width_m + side_m;
        if (o.center - o.center.clamp(low, high)).length() < reach_m
            && let Some((gap_m, leader_mps)) =
                gap_along(ahead, SAMPLE_M, own.half_length_m, own.half_width_m + side_m, o)
        {
            brake_for(idm.interaction_accel(speed, gap_m, leader_mps), cause);
        }
    });
    // In a bend a car sweeps more than its corridor: would its rectangle meet another's a little farther on?
    for reach_m in [0.8, 1.6, 2.6] {
        let there = route.ahead(reach_m, roads);
        let swept = Footprint { center: there.at, heading: there.tangent, ..*own }.grown(swept_m);
        let meets = |o: &Footprint| {
            (o.center - own.center).length() < 14.0
                && (o.center - own.center).dot(own.heading) > 0.0
                && swept.overlaps(o)
        };
        if let Some((cause, ..)) = standing().chain(moving()).find(|(_, _, o)| meets(o)) {
            brake_for(idm.interaction_accel(speed, reach_m - 0.6, 0.0), cause);
            break;
        }
    }
    // The end of the road. Where it is the map's, all but the ego drive on and leave the world.
    let sight_m = sight_m(speed, own.half_length_m);
    let stays = slot == EGO || train_m.is_some() || !route.leads_off_map(sight_m, roads);
    if let Some(end_m) = route.ends_in_m(roads).filter(|m| stays && *m < sight_m).map(|m| m - own.half_length_m) {
        brake_for(idm.interaction_accel(speed, end_m + 1.0, 0.0), Cause::RoadEnd);
    }
    let length_m = train_m.unwrap_or(2.0 * own.half_length_m);
    let crossing = Crossing { slot, route, footprint: own, axles, length_m, is_tram: train_m.is_some() };
    if let Some((gap_m, refusal)) = stop_line(&crossing, around, roads, step) {
        brake_for(idm.interaction_accel(speed, gap_m, 0.0), Cause::Junction(refusal));
    }
    worst
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::rng::Stream;
    use crate::world::tests::towns::{ground, lane, line, town};

    #[test]
    fn a_dead_end_is_seen_where_one_can_still_stop_comfortably() {
        let mut network = crate::town::RoadNetwork::default();
        lane(&mut network, &line(DVec2::ZERO, DVec2::new(400.0, 0.0)), None, &|_, _| 0.0);
        let roads = Roads::new(town(network, ground(450.0, 10.0, &|_, _| 0.0), Vec::new()));
        let idm = IdmParameters::draw(&mut Stream::from_seed("idm", 1));
        for speed_mps in [5.0, 14.0, 25.0, 36.0] {
            let stops_m = speed_mps * speed_mps / (2.0 * COMFORTABLE_MPS2);
            let route = Route::along([crate::town::LaneId(0)].into(), 400.0 - 2.2 - stops_m);
            let at = route.ahead(0.0, &roads);
            let (half_length_m, half_width_m) = (2.2, 0.9);
            let velocity = at.tangent * speed_mps;
            let own = Footprint { center: at.at, heading: at.tangent, half_length_m, half_width_m, velocity };
            let (axles, train_m, reduced_clearance) = (None, None, false);
            let route = &route;
            let rider = OnRoute { slot: EGO, footprint: &own, route, idm: &idm, axles, train_m, reduced_clearance };
            let mut around = TrafficState::new(&roads);
            let ahead: Vec<Ahead> = in_sight(route, speed_mps, half_length_m, &roads).collect();
            let (_, cause) = tightest_constraint(&rider, &ahead, &mut around, &roads, 0);
            assert_eq!(cause, Cause::RoadEnd, "{speed_mps} m/s, {stops_m} m before the end");
        }
    }
}
