//! Vehicles swing out in tight turns, long ones most: who is in their way.

use std::collections::VecDeque;

use super::on_route::OnRoute;
use super::stop_line::line_m;
use crate::driving::predicted_way::PredictedWay;
use crate::footprint::Footprint;
use crate::params::CRAWLS_MPS;
use crate::slot::Slot;
use crate::streets::{Ahead, LaneGraph, Route};
use crate::traffic_state::{TrafficState, VehicleAt};
use cadet_base::math::DVec2;
use cadet_town::LaneId;

/// The room that those who turn need beside who crawls or stands.
const SWEEP_ROOM_M: f64 = 0.06;
/// Room that turning trams need beside what crawls or stands; the chord of their heading, as a share of their length.
const TRAM_SWEEP_ROOM_M: f64 = 0.3;
const CHORD_OF_LENGTH: f64 = 0.8;
/// Steering is run ahead from so far before the junction, at this speed at least.
const BEFORE_M: f64 = 8.0;
const LEAST_MPS: f64 = 2.0;
/// Distance to the junction below which an oncoming vehicle is reckoned with as if it stood at its line.
const STOPS_SOON_M: f64 = 65.0;
/// Nobody farther than this beside the line is met.
const BESIDE_M: f64 = 4.0;

/// The vehicle that stands, or is about to stop, where this one would swing into the oncoming lane: at the line of an
/// arm that it turns into, or on the way there. Nose to nose, neither would get past the other. Cyclists swing nowhere.
pub(crate) fn vehicle_in_swept_path(own: &OnRoute<'_>, chain: &[LaneId], start_m: f64) -> Option<Slot> {
    let (around, graph) = (own.around, own.graph);
    if own.axles.is_none() && own.train_m.is_none() {
        return None;
    }
    let length_m = 2.0 * own.footprint.half_length_m;
    let across_m: f64 = chain.iter().map(|lane| graph.lane(*lane).length_m()).sum();
    let line: Vec<Ahead> =
        (0..(across_m + length_m) as u32).map(|k| own.route.ahead(start_m + f64::from(k), graph)).collect();
    let reach_m = STOPS_SOON_M + across_m + length_m;
    let stands_or_stops = |v: &VehicleAt| {
        let stands = v.footprint.velocity.length() < CRAWLS_MPS;
        if stands { Some(v.footprint) } else { at_its_line(v, chain[0], around, graph) }
    };
    let is_beside = |o: &Footprint| {
        let near_m = o.half_length_m + own.footprint.half_length_m + BESIDE_M;
        line.iter().any(|a| o.heading.dot(a.tangent) < 0.0 && (o.center - a.at).length() < near_m)
    };
    let others: Vec<(Slot, Footprint)> = around
        .vehicles
        .iter()
        .filter(|v| v.agent != own.slot && (v.footprint.center - line[0].at).length() < reach_m)
        .filter_map(|v| Some((v.agent, stands_or_stops(v).filter(is_beside)?)))
        .collect();
    let met = |center: DVec2, heading: DVec2, room_m: f64| {
        let swept = Footprint { center, heading, ..*own.footprint }.grown(room_m);
        others.iter().find(|(_, o)| o.heading.dot(heading) < 0.0 && swept.overlaps(o)).map(|(agent, _)| *agent)
    };
    if others.is_empty() {
        return None;
    }
    let Some(axles) = own.axles else {
        return line.iter().find_map(|there| {
            let behind = own.route.ahead((there.distance_m - CHORD_OF_LENGTH * length_m).max(0.0), graph);
            met(there.at, (there.at - behind.at).normalize_or(there.tangent), TRAM_SWEEP_ROOM_M)
        });
    };
    let allowed_mps = chain.iter().flat_map(|lane| graph.allowed_mps(*lane)).copied().fold(f64::INFINITY, f64::min);
    let from_m = (start_m - BEFORE_M).max(0.0);
    let way = PredictedWay::from(own.route, from_m, axles, allowed_mps.max(LEAST_MPS), graph);
    let steps = (start_m - from_m + across_m + length_m) / PredictedWay::STEP_M;
    way.take(steps as usize).find_map(|(center, heading)| met(center, heading, SWEEP_ROOM_M))
}

/// Where who comes toward the junction of a lane will stand, if it has no right to enter it.
fn at_its_line(other: &VehicleAt, lane: LaneId, around: &TrafficState, graph: &LaneGraph) -> Option<Footprint> {
    let on = around.lane_use.of(other.agent).filter(|on| graph.lane(on.at.lane).junction.is_none())?;
    let mut to_junction_m = graph.lane(on.at.lane).length_m() - on.at.s_m;
    let mut lanes = VecDeque::from([on.at.lane]);
    let mut next = graph.lane(on.at.lane).successors.first()?;
    while graph.lane(*next).junction.is_none() {
        to_junction_m += graph.lane(*next).length_m();
        lanes.push_back(*next);
        next = graph.lane(*next).successors.first()?;
        if to_junction_m > STOPS_SOON_M {
            return None;
        }
    }
    let goes_m = to_junction_m - line_m(lanes[lanes.len() - 1], graph) - on.half_length_m;
    let is_ours = graph.lane(*next).junction == graph.lane(lane).junction;
    if !is_ours || goes_m < 0.0 || to_junction_m > STOPS_SOON_M || around.junctions.holds_any(other.agent) {
        return None;
    }
    Some(Route::along(lanes, on.at.s_m).ahead(goes_m, graph).moved(&other.footprint))
}

#[cfg(test)]
mod tests {
    use super::super::idm::IdmParameters;
    use super::super::pursuit::Axles;
    use super::*;
    use crate::junctions::Request;
    use crate::lane_use::{LaneUse, OnLane};
    use crate::params::CAR;
    use crate::params::junctions::STOP_LINE_M;
    use crate::streets::{LanePosition, Needs};
    use crate::tests::towns::crossing;
    use cadet_base::math::DVec3;
    use cadet_base::plane::heading_rad;
    use cadet_base::rng::Stream;

    const BUS_LWH: DVec3 = DVec3::new(12.0, 2.6, 3.0);

    /// The vehicle in the way of a turn by about a right angle to the right, 12 m before a crossing, while a car is on
    /// the lane that comes toward it out of the arm that it turns into, `oncoming_m` before the junction. The car may
    /// cross if it `holds` the junction.
    fn in_the_way(size_lwh: DVec3, needs: Needs, oncoming_m: f64, mps: f64, holds: bool) -> Option<Slot> {
        let comes = Oncoming { size_lwh: DVec3::new(4.4, 1.8, 1.5), apart_m: 3.0, mps, holds };
        in_the_way_of(size_lwh, needs, oncoming_m, comes)
    }

    /// A vehicle that comes toward the turning one on a line `apart_m` beside the one that it follows.
    struct Oncoming {
        size_lwh: DVec3,
        apart_m: f64,
        mps: f64,
        holds: bool,
    }

    fn in_the_way_of(size_lwh: DVec3, needs: Needs, oncoming_m: f64, comes: Oncoming) -> Option<Slot> {
        let graph = LaneGraph::new(crossing());
        let into = graph.lanes().iter().find(|l| l.junction.is_none() && l.successors.len() == 3).unwrap();
        let turns_right = |route: &Route| {
            let c = &graph.lane(route.lanes[1]).center;
            (c[1] - c[0]).truncate().perp_dot((c[c.len() - 1] - c[0]).truncate()) < -1.0
        };
        let routes = (0..99).map(|seed| {
            let at = LanePosition { lane: into.id, s_m: into.length_m() - 12.0, left_m: 0.0 };
            Route::with_needs(at, 1e-9, needs, Stream::from_seed("ways", seed), &graph)
        });
        let route = routes.into_iter().find(turns_right).unwrap();
        let chain = [route.lanes[1]];
        let footprint = route.ahead(0.0, &graph).covered_by(size_lwh, 2.0);
        // The lane that leads into the junction beside the one that is left on.
        let exit = route.ahead(12.0 + graph.lane(chain[0]).length_m() + oncoming_m, &graph);
        let beside = exit.at + exit.tangent.perp() * comes.apart_m;
        let oncoming = Ahead { at: beside, tangent: -exit.tangent, ..exit }.covered_by(comes.size_lwh, comes.mps);
        let vehicle = |agent, footprint| VehicleAt { agent, footprint, is_cycle: false };
        let heading_rad = heading_rad(oncoming.heading);
        let at = graph.nearest(oncoming.center.extend(0.0), Some(heading_rad), 1.0).unwrap();
        let mut around = TrafficState::new(&graph);
        around.vehicles = vec![vehicle(1, footprint), vehicle(2, oncoming)];
        around.lane_use.push(OnLane { agent: 2, at, half_length_m: 2.2, speed_mps: comes.mps });
        if comes.holds {
            around.junctions.resolve(&[Request::of_car(2, &chain)], &LaneUse::default(), &graph, 0);
        }
        let axles = Some(Axles { wheelbase_m: 0.62 * size_lwh.x, rear_m: 0.3 * size_lwh.x });
        let idm = IdmParameters::draw(&CAR, &mut Stream::from_seed("idm", 1));
        let (route, footprint) = (&route, &footprint);
        let (around, graph) = (&around, &graph);
        let (train_m, reduced_clearance, step) = (None, false, 0);
        let idm = &idm;
        let own = OnRoute { slot: 1, route, footprint, idm, axles, train_m, reduced_clearance, around, graph, step };
        vehicle_in_swept_path(&own, &chain, 12.0)
    }

    #[test]
    fn a_bus_turns_into_a_narrow_arm_when_nobody_stands_where_it_swings_out() {
        let needs = Needs::of_truck(BUS_LWH);
        let at_line_m = STOP_LINE_M + 2.2;
        let [line, on_its_way] = [at_line_m, at_line_m + 12.0];
        assert_eq!(in_the_way(BUS_LWH, needs, line, 0.0, false), Some(2));
        assert_eq!(in_the_way(BUS_LWH, needs, line, 3.0, true), None, "who may cross makes way");
        assert_eq!(in_the_way(BUS_LWH, needs, on_its_way, 5.0, false), Some(2), "it will stop at its line");
        assert_eq!(in_the_way(BUS_LWH, needs, 20.0, 0.0, false), None, "far from the junction");
        let car = DVec3::new(4.4, 1.8, 1.5);
        assert_eq!(in_the_way(car, Needs::default(), line, 0.0, false), None, "a car stays in its lane");
    }

    #[test]
    fn a_car_waits_for_a_wide_van_at_the_line_of_a_narrow_arm() {
        let car = DVec3::new(4.4, 1.67, 1.6);
        let at_line = |size_lwh: DVec3| {
            let comes = Oncoming { size_lwh, apart_m: 2.4, mps: 0.0, holds: false };
            in_the_way_of(car, Needs::default(), STOP_LINE_M + size_lwh.x / 2.0, comes)
        };
        assert_eq!(at_line(DVec3::new(5.3, 2.27, 2.5)), Some(2), "a van that fills its lane");
        assert_eq!(at_line(DVec3::new(4.4, 1.75, 1.5)), None, "cars pass each other");
    }
}
