//! Where a driver stops before a junction, and asks for the way across it.

use super::approach::{Crossing, LIGHT_LINE_M, STOP_LINE_M, line_m};
use super::exit_room::exit_blocked_by;
use super::idm::COMFORTABLE_MPS2;
use super::swing_out::vehicle_in_swept_path;
use crate::math::{self, DVec3};
use crate::town::{Aspect, Lane, LaneId, LaneKind};
use crate::world::junctions::{Junctions, Refusal, Request};
use crate::world::physics::DT_S;
use crate::world::roads::Roads;
use crate::world::route::Route;
use crate::world::slot::{EGO, Slot};
use crate::world::traffic_state::TrafficState;

/// Whose front is so far over that, a light does not hold any more: the painted line is farther yet.
const OVER_LINE_M: f64 = -0.7;
/// Lights are heeded from so much before one has to brake.
const SEES_LIGHT_M: f64 = 12.0;
/// How hard drivers brake at most when a light turns yellow, and when it is red.
const YELLOW_MPS2: f64 = 3.0;
const RED_MPS2: f64 = 6.5;
/// Who is slower than this at a light on a cycle lane has come to stand there.
const QUEUES_MPS: f64 = 0.5;
/// The ego, and a tram, ask for their way across a junction this much earlier than others do.
const EGO_ASKS_EARLIER_M: f64 = 20.0;
const TRAM_ASKS_EARLIER_M: f64 = 25.0;

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
    around: &mut TrafficState,
    roads: &Roads,
    step: u64,
) -> Option<(f64, Refusal)> {
    let Crossing { slot, route, footprint, length_m, is_tram, .. } = *own;
    let (speed_mps, half_length_m) = (own.speed_mps(), footprint.half_length_m);
    let TrafficState { junctions, lane_use, vehicles, .. } = around;
    if let Some(gap_m) = stop_at_light(own, junctions, roads, step) {
        queue_at_light(own, junctions, roads, step);
        return Some((gap_m, Refusal::Light));
    }
    let (k, start_m) = next_junction(route, roads, &|id| !junctions.holds(slot, id))?;
    let before = route.lanes[k - 1];
    // Who is over the line before a ford waits at the junction itself.
    let at_line_m = start_m - half_length_m - line_m(before, roads);
    let front_m = if at_line_m > OVER_LINE_M { at_line_m } else { start_m - half_length_m - STOP_LINE_M };
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
    if let Some(other) = vehicle_in_swept_path(own, &chain, start_m, (vehicles, lane_use), junctions, roads) {
        junctions.release(slot, &[]);
        return Some((front_m + 1.5, Refusal::InSweep(other)));
    }
    let exits: Vec<LaneId> = route.lanes.iter().skip(k + chain.len()).copied().collect();
    let exit = exits.first().copied().unwrap_or(chain[chain.len() - 1]);
    let room_m = length_m + 2.5;
    let exit_blocked_by = exit_blocked_by(own, &exits, room_m, lane_use, junctions, roads);
    let yields_to_oncoming = roads.signals().arm_of(before).is_some() && turns_across(roads.lane(chain[0]));
    let asked =
        Request { car: slot, lanes: &chain, exit, room_m, exit_blocked_by, yields_to_oncoming, has_priority: is_tram };
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
        junctions.release(slot, &chain(route, k, roads));
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
        junctions.queue(own.slot, lane.id, turns_across(lane), (step, aspect == Some(Aspect::RedYellow)));
    }
}

/// Whether a lane across a junction crosses the way of those who come toward it: turns left where traffic keeps right.
fn turns_across(lane: &Lane) -> bool {
    let c = &lane.center;
    let (a, b) = ((c[1] - c[0]).truncate(), (c[c.len() - 1] - c[c.len() - 2]).truncate());
    -lane.curb_side() * math::atan2(a.perp_dot(b), a.dot(b)) > 0.6
}
