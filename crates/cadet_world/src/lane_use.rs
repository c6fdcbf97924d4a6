//! Places of all vehicles on the lanes: nobody enters a junction without a way out of it, or past those ahead.

use super::slot::Slot;
use super::streets::LanePosition;
use cadet_town::LaneId;

/// Speed below which a vehicle may still be at the start of a lane when another wants to leave a junction there.
const SLOW_MPS: f64 = 2.5;

/// An agent on a lane.
#[derive(Debug, Clone, Copy)]
pub(super) struct OnLane {
    pub agent: Slot,
    /// Where its middle is.
    pub at: LanePosition,
    pub half_length_m: f64,
    pub speed_mps: f64,
}

impl OnLane {
    /// Distance of its tail along the lane.
    pub fn tail_m(&self) -> f64 {
        self.at.s_m - self.half_length_m
    }
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

    /// The agent that stands or crawls nearest to the start of a lane, leaving one agent out; for trams those that move
    /// count too.
    pub fn last_on(&self, lane: LaneId, but: Slot, is_tram: bool) -> Option<&OnLane> {
        let others = self.on(lane).filter(|a| a.agent != but && (is_tram || a.speed_mps < SLOW_MPS));
        others.min_by(|a, b| a.tail_m().total_cmp(&b.tail_m()))
    }

    /// Where an agent is.
    pub fn of(&self, agent: Slot) -> Option<&OnLane> {
        self.0.iter().find(|a| a.agent == agent)
    }

    /// The agents on a lane.
    pub fn on(&self, lane: LaneId) -> impl Iterator<Item = &OnLane> {
        self.0.iter().filter(move |a| a.at.lane == lane)
    }
}
