//! What who drives or rides along a route has to brake for: traffic, people, junctions, the end of the road.

use super::junction_ahead::look_at_junction;
use super::on_route::{Cause, Constraint, OnRoute};
use crate::footprint::Footprint;
use crate::junctions::Request;
use crate::params::driver::{
    BEFORE_END_M, SIDE_MOVING_M, SIDE_MOVING_REDUCED_M, SIDE_STANDING_M, SIDE_STANDING_REDUCED_M, SWEPT_M,
};
use crate::slot::EGO;
use crate::streets::Ahead;
use cadet_base::plane::bounds;

/// What who follows a route finds ahead, and asks of the next junction.
pub(crate) struct Perceived {
    pub constraints: Vec<Constraint>,
    pub request: Option<Request>,
}

/// The traffic on the line so far to the left of the route's: in the lane that one is changing to.
pub(crate) fn traffic_aside<'a>(
    own: &'a OnRoute<'_>,
    aside_m: f64,
    ahead: &[Ahead],
) -> impl Iterator<Item = Constraint> + 'a {
    let aside: Vec<Ahead> = ahead.iter().map(|a| Ahead { at: a.at + a.tangent.perp() * aside_m, ..*a }).collect();
    let others = own.around.vehicles.iter().map(|v| (v.agent, &v.footprint));
    others
        .chain(own.around.claims())
        .filter(|(other, _)| *other != own.slot)
        .filter_map(move |(other, o)| own.gap_to(o, SIDE_MOVING_M, &aside, Cause::Vehicle(other)))
}

/// All that one has to brake for, given the places ahead on the route.
pub(crate) fn perceive(own: &OnRoute<'_>, ahead: &[Ahead]) -> Perceived {
    let junction = look_at_junction(own);
    let mut constraints = traffic_ahead(own, ahead);
    constraints.extend(road_end(own).into_iter().chain(junction.stop));
    Perceived { constraints, request: junction.request }
}

/// Vehicles and people on the route, or where the vehicle is about to sweep.
fn traffic_ahead(own: &OnRoute<'_>, ahead: &[Ahead]) -> Vec<Constraint> {
    let (footprint, around) = (own.footprint, own.around);
    let usual_m = (SIDE_STANDING_M, SIDE_MOVING_M, SWEPT_M.0);
    let (side_standing_m, side_moving_m, swept_m) =
        if own.reduced_clearance { (SIDE_STANDING_REDUCED_M, SIDE_MOVING_REDUCED_M, SWEPT_M.1) } else { usual_m };
    let (low, high) = bounds(ahead.iter().map(|a| a.at));
    let standing = || around.standing_in_lanes.iter().map(|o| (Cause::Parked, side_standing_m, o));
    // Of two side by side, the one whose front is farther on goes first: else each would wait for the other.
    let others = || around.vehicles.iter().filter(|v| v.agent != own.slot && !footprint.leads(&v.footprint));
    let moving = || others().map(|v| (Cause::Vehicle(v.agent), side_moving_m, &v.footprint));
    let people = around.people_on_road.iter().map(|o| (Cause::Person, SIDE_MOVING_M, o));
    let claims = around.claims().filter(|(other, _)| *other != own.slot);
    let claimed = claims.map(|(other, claim)| (Cause::Vehicle(other), SIDE_MOVING_M, claim));
    let mut constraints: Vec<Constraint> = standing()
        .chain(moving())
        .chain(claimed)
        .chain(people)
        .filter(|(_, side_m, o)| {
            let reach_m = o.half_length_m + o.half_width_m + footprint.half_width_m + side_m;
            (o.center - o.center.clamp(low, high)).length() < reach_m
        })
        .filter_map(|(cause, side_m, o)| own.gap_to(o, side_m, ahead, cause))
        .collect();
    // In a bend a car sweeps more than its corridor: would its rectangle meet another's a little farther on?
    let swept = [0.8, 1.6, 2.6].into_iter().find_map(|reach_m| {
        let there = own.route.ahead(reach_m, own.graph);
        let swept = there.moved(footprint).grown(swept_m);
        let meets = |o: &Footprint| {
            let to = o.center - footprint.center;
            to.length() < 14.0 && to.dot(footprint.heading) > 0.0 && swept.overlaps(o)
        };
        let (cause, ..) = standing().chain(moving()).find(|(_, _, o)| meets(o))?;
        Some(Constraint { gap_m: reach_m - 0.6, speed_mps: 0.0, cause })
    });
    constraints.extend(swept);
    constraints
}

/// The end of the road. Where it is the map's, all but the ego drive on and leave the world.
fn road_end(own: &OnRoute<'_>) -> Option<Constraint> {
    let sight_m = own.sight_m();
    let stays = own.slot == EGO || own.train_m.is_some() || !own.route.leads_off_map(sight_m, own.graph);
    let end_m = own.route.ends_in_m(own.graph).filter(|m| stays && *m < sight_m)?;
    Some(own.stop_in(end_m - own.footprint.half_length_m - BEFORE_END_M, Cause::RoadEnd))
}

#[cfg(test)]
mod tests {
    use super::super::idm::IdmParameters;
    use super::*;
    use crate::params::CAR;
    use crate::streets::{LaneGraph, Route};
    use crate::tests::towns::{ground, lane, line, town};
    use crate::traffic_state::TrafficState;
    use cadet_base::math::{DVec2, DVec3};
    use cadet_base::rng::Stream;

    #[test]
    fn a_dead_end_is_seen_where_one_can_still_stop_comfortably() {
        let mut network = cadet_town::RoadNetwork::default();
        lane(&mut network, &line(DVec2::ZERO, DVec2::new(400.0, 0.0)), None, &|_, _| 0.0);
        let graph = LaneGraph::new(town(network, ground(450.0, 10.0, &|_, _| 0.0), Vec::new()));
        let idm = IdmParameters::draw(&CAR, &mut Stream::from_seed("idm", 1));
        for speed_mps in [5.0, 14.0, 25.0, 36.0] {
            let stops_m = speed_mps * speed_mps / (2.0 * idm.comfortable_mps2);
            let route = Route::along([cadet_town::LaneId(0)].into(), 400.0 - 2.2 - stops_m);
            let own = route.ahead(0.0, &graph).covered_by(DVec3::new(4.4, 1.8, 1.5), speed_mps);
            let rider = OnRoute {
                slot: EGO,
                footprint: &own,
                route: &route,
                idm: &idm,
                axles: None,
                train_m: None,
                reduced_clearance: false,
                around: &TrafficState::new(&graph),
                graph: &graph,
                step: 0,
            };
            let (_, cause) = rider.tightest(&perceive(&rider, &rider.in_sight()).constraints);
            assert_eq!(cause, Cause::RoadEnd, "{speed_mps} m/s, {stops_m} m before the end");
        }
    }
}
