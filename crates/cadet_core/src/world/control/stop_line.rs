//! Where a driver stops before a junction, and asks for the way across it.

use super::idm::COMFORTABLE_MPS2;
use crate::math::DVec3;
use crate::town::LaneId;
use crate::world::junctions::{Junctions, Refusal};
use crate::world::lane_use::LaneUse;
use crate::world::route::{Roads, Route};
use crate::world::slot::{EGO, Slot};

/// Where the front bumper stops before a junction's first point: out of the sweep of those who turn in.
const STOP_LINE_M: f64 = 3.3;
/// The ego asks for its way across a junction this much earlier than others do.
const EGO_ASKS_EARLIER_M: f64 = 20.0;

/// Who wants to cross.
pub(super) struct Crossing<'a> {
    pub slot: Slot,
    pub route: &'a Route,
    pub speed_mps: f64,
    pub half_length_m: f64,
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
    junctions: &mut Junctions,
    lane_use: &LaneUse,
    roads: &Roads,
    step: u64,
) -> Option<(f64, Refusal)> {
    let Crossing { slot, route, speed_mps, half_length_m } = *own;
    let mut start_m = -route.s_m;
    let mut k = 0;
    for (i, id) in route.lanes.iter().enumerate() {
        if i > 0 && roads.lane(*id).junction.is_some() && !junctions.holds(slot, *id) {
            k = i;
            break;
        }
        start_m += roads.lane(*id).length_m();
    }
    let front_m = start_m - half_length_m - STOP_LINE_M;
    let early_m = if slot == EGO { EGO_ASKS_EARLIER_M } else { 0.0 };
    let zone_m = speed_mps * speed_mps / (2.0 * COMFORTABLE_MPS2) + 0.5 * speed_mps.max(0.0) + 6.0 + early_m;
    // Over the line there is no stopping any more.
    if k == 0 || front_m > zone_m || front_m < -STOP_LINE_M - 0.5 {
        return None;
    }
    // Not before those ahead of us.
    let is_behind_others = |lane: LaneId, first: bool| {
        lane_use.on(lane).any(|a| a.agent != slot && (!first || a.s_m > route.s_m) && !junctions.holds_any(a.agent))
    };
    if route.lanes.iter().take(k).enumerate().any(|(i, l)| is_behind_others(*l, i == 0)) {
        return Some((front_m + 1.5, Refusal::NotFirst));
    }
    let chain: Vec<LaneId> =
        route.lanes.iter().skip(k).copied().take_while(|l| roads.lane(*l).junction.is_some()).collect();
    let exit = route.lanes.get(k + chain.len()).copied().unwrap_or(chain[chain.len() - 1]);
    let room_m = 2.0 * half_length_m + 2.5;
    let exit_free = lane_use.room_m(exit, slot) - junctions.promised_m(slot, exit) >= room_m;
    junctions.request(slot, &chain, exit, room_m, exit_free, step).err().map(|refusal| (front_m + 1.5, refusal))
}
