//! The junction ahead of who follows a route: what is asked of it, and the line to stop at until it may be crossed.

use super::on_route::{Cause, Constraint, OnRoute};
use super::stop_line::line_m;
use crate::driving::swing_out::vehicle_in_swept_path;
use crate::junctions::{Junctions, Refusal, Request, Stage, Turn};
use crate::params::junctions::{
    AT_LINE_M, COMES_S, DECIDED_S, EARLY_M, EARLY_S, EXIT_ROOM_M, LIGHT_LINE_M, OVER_LINE_M, RED_MPS2, SEES_LIGHT_M,
    STARTS_MPS, STOP_LINE_M, UNUSED_STEPS, YELLOW_MPS2,
};
use crate::params::{CRAWLS_MPS, STANDS_MPS};
use crate::physics::DT_S;
use crate::slot::Slot;
use crate::streets::{LaneGraph, Route};
use cadet_base::math::{self, DVec3};
use cadet_town::{Aspect, LaneId, RightOfWay};

/// What a look at the next junction finds.
#[derive(Default)]
pub(crate) struct JunctionAhead {
    /// The line to stop at, and why.
    pub stop: Option<Constraint>,
    pub request: Option<Request>,
}

/// Follows a body along its route, and gives back what its tail has cleared of junctions.
pub(crate) fn leave_junctions(
    slot: Slot,
    route: &mut Route,
    position: DVec3,
    tail_m: f64,
    junctions: &mut Junctions,
    graph: &LaneGraph,
) {
    route.track(position, graph, |lane, end_m| junctions.leaving(slot, lane, end_m + tail_m));
    junctions.advance(slot, route.lanes[0], route.s_m - tail_m);
    junctions.release(slot, route.odometer_m(), |lane| route.lanes.contains(&lane));
}

/// Looks at the next junction that is not one's own to cross.
pub(crate) fn look_at_junction(own: &OnRoute<'_>) -> JunctionAhead {
    let graph = own.graph;
    let (speed_mps, half_length_m) = (own.speed_mps().max(0.0), own.footprint.half_length_m);
    let junctions = &own.around.junctions;
    let Some(next) = next_junction(own.route, graph, &|_| true) else { return JunctionAhead::default() };
    if let Some(held_up) = wait_at_light(own, next).or_else(|| give_back(own, next)) {
        return held_up;
    }
    let is_not_held = |id| !junctions.holds(own.slot, id);
    let Some((k, start_m)) = next_junction(own.route, graph, &is_not_held) else { return JunctionAhead::default() };
    let before = own.route.lanes[k - 1];
    // A vehicle that is over the line before a ford waits at the junction itself.
    let at_line_m = start_m - half_length_m - line_m(before, graph);
    let front_m = if at_line_m > OVER_LINE_M { at_line_m } else { start_m - half_length_m - STOP_LINE_M };
    let brakes_m = own.idm.comfortable_stop_m(speed_mps) + EARLY_M + EARLY_S * speed_mps;
    let is_green = graph.signals().aspect(before, own.step as f64 * DT_S).is_none_or(|a| a == Aspect::Green);
    if !is_green && at_line_m > OVER_LINE_M {
        return JunctionAhead::default();
    }
    if front_m > brakes_m + DECIDED_S * speed_mps {
        let request = Some(request(own, (k, start_m), Stage::Comes)).filter(|r| r.arrives_s < COMES_S);
        return JunctionAhead { stop: None, request };
    }
    let has_to_stop = graph.right_of_way(before) == Some(RightOfWay::Stop)
        && (speed_mps > CRAWLS_MPS || front_m > AT_LINE_M)
        && front_m > 0.0;
    let in_sweep = vehicle_in_swept_path(own, &across(own, k), start_m);
    let stage = if has_to_stop || in_sweep.is_some() { Stage::Waits } else { Stage::Asks };
    let refusal = in_sweep.map_or_else(|| junctions.refusal(own.slot), Refusal::InSweep);
    // Over the line there is no stopping any more.
    let stops = front_m < brakes_m && front_m > -STOP_LINE_M - 0.5;
    JunctionAhead {
        stop: stops.then(|| own.stop_in(front_m, Cause::Junction(refusal))),
        request: Some(request(own, (k, start_m), stage)),
    }
}

/// The first lane of a route that crosses a junction and `counts`: its place on the route, and how far ahead it begins.
pub(crate) fn next_junction(route: &Route, graph: &LaneGraph, counts: &dyn Fn(LaneId) -> bool) -> Option<(usize, f64)> {
    let mut start_m = -route.s_m;
    for (i, id) in route.lanes.iter().enumerate() {
        if i > 0 && graph.lane(*id).junction.is_some() && counts(*id) {
            return Some((i, start_m));
        }
        start_m += graph.lane(*id).length_m();
    }
    None
}

/// The lanes across the junction that begins at the `k`-th of a route.
fn across(own: &OnRoute<'_>, k: usize) -> Vec<LaneId> {
    own.route.lanes.iter().skip(k).copied().take_while(|l| own.graph.lane(*l).junction.is_some()).collect()
}

/// The request to the junction that begins at the `k`-th lane of a route, `start_m` ahead of the vehicle's middle.
fn request(own: &OnRoute<'_>, (k, start_m): (usize, f64), stage: Stage) -> Request {
    let (route, graph, is_tram) = (own.route, own.graph, own.train_m.is_some());
    let lanes = across(own, k);
    let leads_on = |l: &LaneId| graph.lane(*l).junction.is_none();
    let exits = route.lanes.iter().skip(k + lanes.len()).copied().take_while(leads_on).collect();
    let (first, last) = (graph.lane(lanes[0]), graph.lane(lanes[lanes.len() - 1]));
    let heading = first.start_tangent();
    let turn_rad = math::turn_rad(heading, last.end_tangent());
    let speed_mps = own.speed_mps().max(0.0);
    let front_m = start_m - own.footprint.half_length_m;
    let across_m: f64 = lanes.iter().map(|l| graph.lane(*l).length_m()).sum();
    let allowed = lanes.iter().flat_map(|l| graph.allowed_mps(*l)).copied();
    let goes_mps = allowed.fold(f64::INFINITY, f64::min);
    Request {
        slot: own.slot,
        before: route.lanes[k - 1],
        front_m,
        exits,
        room_m: own.length_m() + EXIT_ROOM_M,
        is_tram,
        right_of_way: graph.right_of_way(route.lanes[k - 1]).filter(|_| !graph.is_in_roundabout(lanes[0])),
        heading,
        turn: Turn::of(first.curb_side() * turn_rad),
        curb_side: first.curb_side(),
        arrives_s: front_m.max(0.0) / speed_mps.max(STARTS_MPS),
        clears_s: own.idm.time_to_go(front_m + across_m + own.length_m(), speed_mps, goes_mps),
        stage,
        lanes,
    }
}

/// The way across a junction that was granted to somebody who has come to stand before it, for whatever reason: it is given
/// back, and asked for again.
fn give_back(own: &OnRoute<'_>, (k, start_m): (usize, f64)) -> Option<JunctionAhead> {
    let since_step = own.around.junctions.holds_since(own.slot, own.route.lanes[k])?;
    let is_unused = own.speed_mps() < STANDS_MPS && own.step > since_step + UNUSED_STEPS;
    let request = is_unused.then(|| request(own, (k, start_m), Stage::Waits))?;
    Some(JunctionAhead { stop: None, request: Some(request) })
}

/// The line of a light that holds, and the place in the queue before it: what was ours of the junction is given back.
fn wait_at_light(own: &OnRoute<'_>, (k, start_m): (usize, f64)) -> Option<JunctionAhead> {
    let speed_mps = own.speed_mps().max(0.0);
    let aspect = own.graph.signals().aspect(own.route.lanes[k - 1], own.step as f64 * DT_S)?;
    let front_m = start_m - own.footprint.half_length_m - LIGHT_LINE_M;
    let braking_m = speed_mps * speed_mps / 2.0;
    let seen_m = braking_m / own.idm.comfortable_mps2 + speed_mps + SEES_LIGHT_M;
    if aspect == Aspect::Green || front_m < OVER_LINE_M || front_m > seen_m {
        return None;
    }
    // On yellow those go on who could stop only hard; on red nobody does who has not got past stopping at all.
    let hardest_mps2 = if aspect == Aspect::Yellow { YELLOW_MPS2 } else { RED_MPS2 };
    if own.around.junctions.holds(own.slot, own.route.lanes[k]) && braking_m > hardest_mps2 * (front_m + 0.5).max(0.1) {
        return None;
    }
    let stop = Some(own.stop_in(front_m, Cause::Junction(Refusal::Light)));
    Some(JunctionAhead { stop, request: Some(request(own, (k, start_m), Stage::Waits)) })
}
