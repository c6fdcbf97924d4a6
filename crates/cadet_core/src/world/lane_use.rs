//! Who is where on the lanes: nobody enters a junction without a way out of it, or past those ahead.

use super::slot::Slot;
use crate::town::LaneId;

/// Who drives slower than this may still be at the start of a lane when another wants to leave a junction there.
const SLOW_MPS: f64 = 2.5;

/// An agent on a lane.
#[derive(Debug, Clone, Copy)]
pub(super) struct OnLane {
    pub lane: LaneId,
    pub agent: Slot,
    /// Distance of its middle along the lane.
    pub s_m: f64,
    pub half_length_m: f64,
    pub speed_mps: f64,
}

/// Everybody who drives, by slot.
#[derive(Debug, Default)]
pub(super) struct LaneUse(Vec<OnLane>);

impl LaneUse {
    pub fn clear(&mut self) {
        self.0.clear();
    }

    pub fn push(&mut self, agent: OnLane) {
        self.0.push(agent);
    }

    /// Room at the start of a lane before the tail of whoever stands or crawls there, leaving one agent out.
    pub fn room_m(&self, lane: LaneId, but: Slot) -> f64 {
        let slow = |a: &&OnLane| a.lane == lane && a.agent != but && a.speed_mps < SLOW_MPS;
        self.0.iter().filter(slow).map(|a| a.s_m - a.half_length_m).fold(f64::INFINITY, f64::min)
    }

    /// Who is on a lane.
    pub fn on(&self, lane: LaneId) -> impl Iterator<Item = &OnLane> {
        self.0.iter().filter(move |a| a.lane == lane)
    }
}
