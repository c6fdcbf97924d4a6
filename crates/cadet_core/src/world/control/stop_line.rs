//! Where a driver stops before a junction, and asks for the way across it.

use std::collections::VecDeque;

use super::idm::COMFORTABLE_MPS2;
use crate::math::{self, DVec3};
use crate::town::{Aspect, Lane, LaneId, LaneKind, STOP_LINE_M as PAINTED_M};
use crate::world::footprint::Footprint;
use crate::world::junctions::{Junctions, Refusal, Request};
use crate::world::lane_use::{LaneUse, OnLane};
use crate::world::physics::DT_S;
use crate::world::roads::Roads;
use crate::world::route::Route;
use crate::world::slot::{EGO, Slot};
use crate::world::surroundings::{Surroundings, VehicleAt};

/// Where the front bumper stops before a junction's first point: out of the sweep of those who turn in.
const STOP_LINE_M: f64 = 3.3;
/// The same before the line of a light.
const LIGHT_LINE_M: f64 = PAINTED_M.1 + 0.9;
/// Whose front is so far over that, a light does not hold any more: the painted line is farther yet.
const OVER_LINE_M: f64 = -0.7;
/// Lights are heeded from so much before one has to brake.
const SEES_LIGHT_M: f64 = 12.0;
/// How hard drivers brake at most when a light turns yellow, and when it is red.
const YELLOW_MPS2: f64 = 3.0;
const RED_MPS2: f64 = 6.5;
/// Who is slower than this at a light on a cycle lane has come to stand there.
const QUEUES_MPS: f64 = 0.5;
/// Who is slower than this stands in the way of those who turn, and the room they need beside it.
const STANDS_MPS: f64 = 0.5;
const SWEEP_ROOM_M: f64 = 0.3;
/// Vehicles from this length on swing out in tight turns that they may take.
const SWINGS_OUT_M: f64 = 4.9;
/// How far behind the middle the point is that follows the line in a bend, of the length: the rear axle, and more, as
/// drivers steer late.
const FOLLOWS_BEHIND: f64 = 0.4;
/// Who is nearer to the junction than this is reckoned with as if it stood at its line.
const STOPS_SOON_M: f64 = 65.0;
/// The ego, and a tram, ask for their way across a junction this much earlier than others do.
const EGO_ASKS_EARLIER_M: f64 = 20.0;
const TRAM_ASKS_EARLIER_M: f64 = 25.0;

/// Who wants to cross.
#[derive(Clone, Copy)]
pub(super) struct Crossing<'a> {
    pub slot: Slot,
    pub route: &'a Route,
    pub footprint: &'a Footprint,
    /// All of a train; as long as the vehicle otherwise.
    pub length_m: f64,
    /// Whether it is a tram, which all others let go first.
    pub is_tram: bool,
}

impl Crossing<'_> {
    fn speed_mps(&self) -> f64 {
        self.footprint.velocity.dot(self.footprint.heading)
    }
}

/// Follows a body along its route, and gives back what its tail has cleared of junctions.
pub(super) fn leave_junctions(
    slot: Slot,
    route: &mut Route,
    position: DVec3,
    tail_m: f64,
    junctions: &mut Junctions,
    roads: &Roads,
) {
    route.track(position, roads, |lane, end_m| junctions.leaving(slot, lane, end_m + tail_m));
    junctions.advance(slot, route.lanes[0], route.s_m - tail_m);
    junctions.release_cleared(slot, route.odometer_m());
}

/// The gap to a stop line where the next junction is not ours to cross, and why it is not.
pub(super) fn stop_line(
    own: &Crossing<'_>,
    around: &mut Surroundings,
    roads: &Roads,
    step: u64,
) -> Option<(f64, Refusal)> {
    let Crossing { slot, route, footprint, length_m, is_tram } = *own;
    let (speed_mps, half_length_m) = (own.speed_mps(), footprint.half_length_m);
    let Surroundings { junctions, lane_use, vehicles, .. } = around;
    if let Some(gap_m) = stop_at_light(own, junctions, roads, step) {
        queue_at_light(own, junctions, roads, step);
        return Some((gap_m, Refusal::Light));
    }
    let (k, start_m) = next_junction(route, roads, &|id| !junctions.holds(slot, id))?;
    let before = route.lanes[k - 1];
    let is_held_by_light = roads.signals().arm_of(before).is_some();
    let has_ford = is_held_by_light || roads.signals().has_zebra(before);
    // Fords are kept free. Who is over the line before one waits at the junction itself.
    let at_light_m = start_m - half_length_m - LIGHT_LINE_M;
    let line_m = if has_ford && at_light_m > OVER_LINE_M { LIGHT_LINE_M } else { STOP_LINE_M };
    let front_m = start_m - half_length_m - line_m;
    let early_m = match (slot, is_tram) {
        (EGO, _) => EGO_ASKS_EARLIER_M,
        (_, true) => TRAM_ASKS_EARLIER_M,
        _ => 0.0,
    };
    let zone_m = speed_mps * speed_mps / (2.0 * COMFORTABLE_MPS2) + 0.5 * speed_mps.max(0.0) + 6.0 + early_m;
    // Over the line there is no stopping any more.
    if front_m > zone_m || front_m < -STOP_LINE_M - 0.5 {
        return None;
    }
    // Not before those ahead of us.
    let is_behind_others = |lane: LaneId, first: bool| {
        lane_use.on(lane).any(|a| a.agent != slot && (!first || a.s_m > route.s_m) && !junctions.holds_any(a.agent))
    };
    if route.lanes.iter().take(k).enumerate().any(|(i, l)| is_behind_others(*l, i == 0)) {
        return Some((front_m + 1.5, Refusal::NotFirst));
    }
    let chain = chain(route, k, roads);
    if let Some(other) = swept_vehicle(own, &chain, start_m, (vehicles, lane_use), junctions, roads) {
        junctions.renounce(slot, &[]);
        return Some((front_m + 1.5, Refusal::Taken(other)));
    }
    let exit = route.lanes.get(k + chain.len()).copied().unwrap_or(chain[chain.len() - 1]);
    let room_m = length_m + 2.5;
    let exit_taken_by = exit_taken_by(own, exit, room_m, lane_use, junctions, roads);
    let lets_pass = is_held_by_light && turns_left(roads.lane(chain[0]));
    let asked = Request { car: slot, lanes: &chain, exit, room_m, exit_taken_by, lets_pass, has_priority: is_tram };
    junctions.request(&asked, step).err().map(|refusal| (front_m + 1.5, refusal))
}

/// The first lane of a route that crosses a junction and `counts`: its place on the route, and how far ahead it begins.
pub(super) fn next_junction(route: &Route, roads: &Roads, counts: &dyn Fn(LaneId) -> bool) -> Option<(usize, f64)> {
    let mut start_m = -route.s_m;
    for (i, id) in route.lanes.iter().enumerate() {
        if i > 0 && roads.lane(*id).junction.is_some() && counts(*id) {
            return Some((i, start_m));
        }
        start_m += roads.lane(*id).length_m();
    }
    None
}

/// The lanes across the junction that begins at the `k`-th of a route.
fn chain(route: &Route, k: usize, roads: &Roads) -> Vec<LaneId> {
    route.lanes.iter().skip(k).copied().take_while(|l| roads.lane(*l).junction.is_some()).collect()
}

/// Who leaves too little room on the lane after a junction. At the end of its line a tram stands for long: the next finds
/// room behind it, or stops before the junction.
fn exit_taken_by(
    own: &Crossing<'_>,
    exit: LaneId,
    room_m: f64,
    lane_use: &LaneUse,
    junctions: &Junctions,
    roads: &Roads,
) -> Option<Slot> {
    let lane = roads.lane(exit);
    let is_end = own.is_tram && lane.successors.is_empty();
    let last = lane_use.last_on(exit, own.slot, is_end);
    let free_m = last.map_or(if is_end { lane.length_m() } else { f64::INFINITY }, OnLane::tail_m);
    let promised_m: f64 = junctions.promised(own.slot, exit).map(|(_, m)| m).sum();
    let blocker = last.map(|a| a.agent).or_else(|| junctions.promised(own.slot, exit).next().map(|(car, _)| car));
    blocker.filter(|_| free_m - promised_m < room_m)
}

/// Who stands, or is about to stop, where a long vehicle would swing into the oncoming lane: at the line of an arm that it
/// turns into, or on the way there. Nose to nose, neither would get past the other.
fn swept_vehicle(
    own: &Crossing<'_>,
    chain: &[LaneId],
    start_m: f64,
    (vehicles, lane_use): (&[VehicleAt], &LaneUse),
    junctions: &Junctions,
    roads: &Roads,
) -> Option<Slot> {
    let length_m = 2.0 * own.footprint.half_length_m;
    if length_m < SWINGS_OUT_M && chain.iter().all(|lane| own.route.may_use(*lane, roads)) {
        return None;
    }
    let across_m: f64 = chain.iter().map(|lane| roads.lane(*lane).length_m()).sum();
    let others: Vec<(Slot, Footprint)> = vehicles
        .iter()
        .filter(|v| v.agent != own.slot)
        .filter_map(|v| {
            let stands = v.footprint.velocity.length() < STANDS_MPS;
            let at = if stands { v.footprint } else { at_its_line(v, chain[0], lane_use, junctions, roads)? };
            Some((v.agent, at))
        })
        .collect();
    (0..(across_m + length_m) as u32).find_map(|k| {
        let at_m = start_m + f64::from(k);
        let there = own.route.ahead(at_m, roads);
        // The rear axle follows on a tighter bend, so that the heading lags behind the lane's.
        let behind = own.route.ahead((at_m - FOLLOWS_BEHIND * 2.0 * length_m).max(0.0), roads);
        let heading = (there.at - behind.at).normalize_or(there.tangent);
        let swept = Footprint { center: there.at, heading, ..*own.footprint }.grown(SWEEP_ROOM_M);
        let meets = |o: &Footprint| o.heading.dot(there.tangent) < 0.0 && swept.overlaps(o);
        others.iter().find(|(_, o)| meets(o)).map(|(agent, _)| *agent)
    })
}

/// Where who comes toward the junction of a lane will stand, if it has no right to enter it.
fn at_its_line(
    other: &VehicleAt,
    lane: LaneId,
    lane_use: &LaneUse,
    junctions: &Junctions,
    roads: &Roads,
) -> Option<Footprint> {
    let on = lane_use.of(other.agent)?;
    let mut to_junction_m = roads.lane(on.lane).length_m() - on.s_m;
    let mut lanes = VecDeque::from([on.lane]);
    let mut next = roads.lane(on.lane).successors.first()?;
    while roads.lane(*next).junction.is_none() {
        to_junction_m += roads.lane(*next).length_m();
        lanes.push_back(*next);
        next = roads.lane(*next).successors.first()?;
        if to_junction_m > STOPS_SOON_M {
            return None;
        }
    }
    let goes_m = to_junction_m - STOP_LINE_M - on.half_length_m;
    let is_ours = roads.lane(on.lane).junction.is_none() && roads.lane(*next).junction == roads.lane(lane).junction;
    if !is_ours || goes_m < 0.0 || to_junction_m > STOPS_SOON_M || junctions.holds_any(other.agent) {
        return None;
    }
    let line = Route::along(lanes, on.s_m).ahead(goes_m, roads);
    Some(Footprint { center: line.at, heading: line.tangent, ..other.footprint })
}

/// The gap to the line of a light at which we stop. What was ours of the junction is given back.
fn stop_at_light(own: &Crossing<'_>, junctions: &mut Junctions, roads: &Roads, step: u64) -> Option<f64> {
    let Crossing { slot, route, footprint, .. } = *own;
    let (speed_mps, half_length_m) = (own.speed_mps(), footprint.half_length_m);
    let (k, start_m) = next_junction(route, roads, &|_| true)?;
    let aspect = roads.signals().aspect(route.lanes[k - 1], step as f64 * DT_S)?;
    let front_m = start_m - half_length_m - LIGHT_LINE_M;
    let braking_m = speed_mps.max(0.0) * speed_mps.max(0.0) / 2.0;
    let seen_m = braking_m / COMFORTABLE_MPS2 + speed_mps.max(0.0) + SEES_LIGHT_M;
    if aspect == Aspect::Green || front_m < OVER_LINE_M || front_m > seen_m {
        return None;
    }
    let is_ours = junctions.holds(slot, route.lanes[k]);
    // On yellow those go on who could stop only hard; on red nobody does who has not got past stopping at all.
    let hardest_mps2 = if aspect == Aspect::Yellow { YELLOW_MPS2 } else { RED_MPS2 };
    if is_ours && braking_m > hardest_mps2 * (front_m + 0.5).max(0.1) {
        return None;
    }
    if is_ours {
        junctions.renounce(slot, &chain(route, k, roads));
    }
    Some(front_m + 1.5)
}

/// Who stands at a light on a cycle lane has its turn as soon as it is green: bicycles stand in front of cars.
fn queue_at_light(own: &Crossing<'_>, junctions: &mut Junctions, roads: &Roads, step: u64) {
    let Some((k, _)) = next_junction(own.route, roads, &|_| true) else { return };
    let lane = roads.lane(own.route.lanes[k]);
    if lane.kind == LaneKind::Biking && own.speed_mps() < QUEUES_MPS {
        // Before that, those who have green need not wait for it.
        let aspect = roads.signals().aspect(own.route.lanes[k - 1], step as f64 * DT_S);
        junctions.queue(own.slot, lane.id, turns_left(lane), (step, aspect == Some(Aspect::RedYellow)));
    }
}

/// Whether a lane across a junction turns left.
fn turns_left(lane: &Lane) -> bool {
    let c = &lane.center;
    let (a, b) = ((c[1] - c[0]).truncate(), (c[c.len() - 1] - c[c.len() - 2]).truncate());
    math::atan2(a.perp_dot(b), a.dot(b)) > 0.6
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::math::DVec2;
    use crate::rng::Stream;
    use crate::world::room::Needs;
    use crate::world::tests::towns::crossing;
    use crate::world::tests::trams::towns_with_tracks;
    use crate::world::track::Track;

    const BUS_LWH: DVec3 = DVec3::new(12.0, 2.6, 3.0);

    /// Asks for the way across a crossing that turns by about a right angle to the right, 12 m before it, while a car is on
    /// the lane that comes toward it out of the arm that it turns into, so far before the junction. The car may cross if
    /// it `holds` the junction.
    fn ask(size_lwh: DVec3, needs: Needs, oncoming_m: f64, oncoming_mps: f64, holds: bool) -> Option<Refusal> {
        let roads = Roads::new(crossing());
        let into = roads.lanes().iter().find(|l| l.junction.is_none() && l.successors.len() == 3).unwrap();
        let turns_right = |route: &Route| {
            let c = &roads.lane(route.lanes[1]).center;
            (c[1] - c[0]).truncate().perp_dot((c[c.len() - 1] - c[0]).truncate()) < -1.0
        };
        let routes = (0..99).map(|seed| {
            let s_m = into.length_m() - 12.0;
            Route::with_needs(into.id, s_m, 0.0, 1e-9, needs, Stream::from_seed("ways", seed), &roads)
        });
        let route = routes.into_iter().find(turns_right).unwrap();
        let rectangle = |at: DVec2, heading: DVec2, size_lwh: DVec3, speed_mps: f64| Footprint {
            center: at,
            heading,
            half_length_m: size_lwh.x / 2.0,
            half_width_m: size_lwh.y / 2.0,
            velocity: heading * speed_mps,
        };
        let here = route.ahead(0.0, &roads);
        let footprint = rectangle(here.at, here.tangent, size_lwh, 2.0);
        // The lane that leads into the junction beside the one that is left on.
        let exit = route.ahead(12.0 + roads.lane(route.lanes[1]).length_m() + oncoming_m, &roads);
        let oncoming =
            rectangle(exit.at + exit.tangent.perp() * 3.0, -exit.tangent, DVec3::new(4.4, 1.8, 1.5), oncoming_mps);
        let mut around = Surroundings::new(&roads);
        let vehicle = |agent, footprint| VehicleAt { agent, footprint, is_cycle: false };
        around.vehicles = vec![vehicle(1, footprint), vehicle(2, oncoming)];
        let heading_rad = math::atan2(oncoming.heading.y, oncoming.heading.x);
        let (lane, s_m, _) = roads.nearest(oncoming.center.extend(0.0), Some(heading_rad), 1.0).unwrap();
        around.lane_use.push(OnLane { lane, agent: 2, s_m, half_length_m: 2.2, speed_mps: oncoming_mps });
        if holds {
            let lanes = &[route.lanes[1]];
            let request = Request {
                car: 2,
                lanes,
                exit: lanes[0],
                room_m: 0.0,
                exit_taken_by: None,
                lets_pass: false,
                has_priority: false,
            };
            around.junctions.request(&request, 0).unwrap();
        }
        let crossing = Crossing { slot: 1, route: &route, footprint: &footprint, length_m: size_lwh.x, is_tram: false };
        stop_line(&crossing, &mut around, &roads, 0).map(|(_, refusal)| refusal)
    }

    #[test]
    fn a_tram_that_follows_one_to_the_end_of_its_line_keeps_the_junction_free() {
        let (_, town) = towns_with_tracks(1).remove(0);
        let roads = Roads::new(town);
        let is_end = |l: &&Lane| l.kind == LaneKind::Tram && l.junction.is_none() && l.successors.is_empty();
        let exit = roads.lanes().iter().find(is_end).expect("the end of a line");
        let track = Track::through(exit.id, &roads);
        let front_m = track.start_of(exit.id).unwrap() - roads.lane(exit.predecessors[0]).length_m() - 12.0;
        let (lane, _) = track.lane_at(front_m);
        let route = Route::along(track.lanes_from(front_m), front_m - track.start_of(lane).unwrap() - 5.0);
        let here = route.ahead(0.0, &roads);
        let footprint = Footprint {
            center: here.at,
            heading: here.tangent,
            half_length_m: 5.0,
            half_width_m: 1.2,
            velocity: here.tangent * 3.0,
        };
        let crossing = Crossing { slot: 1, route: &route, footprint: &footprint, length_m: 30.0, is_tram: true };
        let ask = |behind_m: f64, is_tram: bool| {
            let mut around = Surroundings::new(&roads);
            let s_m = behind_m + 15.0;
            around.lane_use.push(OnLane { lane: exit.id, agent: 2, s_m, half_length_m: 15.0, speed_mps: 5.0 });
            stop_line(&Crossing { is_tram, ..crossing }, &mut around, &roads, 0).map(|(_, refusal)| refusal)
        };
        assert_eq!(ask(20.0, true), Some(Refusal::ExitFull(2)));
        assert_eq!(ask(33.0, true), None, "there is room for all of it");
        assert_eq!(ask(20.0, false), None, "others move on");
    }

    #[test]
    fn a_bus_turns_into_a_narrow_arm_when_nobody_stands_where_it_swings_out() {
        let needs = Needs::of_truck(BUS_LWH);
        let at_line_m = STOP_LINE_M + 2.2;
        assert_eq!(ask(BUS_LWH, needs, at_line_m, 0.0, false), Some(Refusal::Taken(2)));
        assert_eq!(ask(BUS_LWH, needs, at_line_m, 3.0, true), None, "who may cross makes way");
        assert_eq!(
            ask(BUS_LWH, needs, at_line_m + 12.0, 5.0, false),
            Some(Refusal::Taken(2)),
            "it will stop at its line"
        );
        assert_eq!(ask(BUS_LWH, needs, 20.0, 0.0, false), None, "far from the junction");
        let car = DVec3::new(4.4, 1.8, 1.5);
        assert_eq!(ask(car, Needs::default(), at_line_m, 0.0, false), None, "a car stays in its lane");
    }
}
