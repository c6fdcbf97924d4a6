//! Vehicles that hold lanes across junctions, and those that want them.

use super::conflicts::Conflicts;
use crate::slot::Slot;
use crate::streets::LaneGraph;
use cadet_town::LaneId;

/// One vehicle's right to cross.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Reservation {
    pub slot: Slot,
    pub lane: LaneId,
    pub since_step: u64,
    /// The lane on which it leaves the junction, and the room that it takes there.
    pub exit: LaneId,
    pub room_m: f64,
    /// How far its tail has come along the lane.
    pub tail_m: f64,
    /// Set once its middle has left the lane: the odometer at which its tail has left too.
    pub clear_at_m: Option<f64>,
}

/// A place in the queue before a junction.
#[derive(Debug, Clone, Copy)]
pub(super) struct Queued {
    pub slot: Slot,
    /// The first lane across: who chooses another way queues anew.
    pub first: LaneId,
    pub since_step: u64,
    /// At how many looks it has asked.
    pub asked_looks: u32,
    pub refusal: Refusal,
}

/// Why a junction may not be entered yet.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum Refusal {
    /// Nobody has decided yet, or it has to stop first.
    Undecided,
    /// Somebody leaves no room to leave it again.
    ExitFull(Slot),
    /// Somebody goes first whose way crosses ours.
    Yields(Slot),
    /// Somebody whose way crosses ours is in it or about to enter.
    Taken(Slot),
    /// Somebody stands where we would swing out.
    InSweep(Slot),
    /// The light is not green.
    Light,
}

/// Conflicts between lanes, and who holds and wants which.
#[derive(Debug, Default)]
pub(crate) struct Junctions {
    pub(super) conflicts: Conflicts,
    pub(super) held: Vec<Reservation>,
    pub(super) queue: Vec<Queued>,
}

impl Junctions {
    pub fn new(graph: &LaneGraph) -> Self {
        Self { conflicts: Conflicts::of(graph.lanes()), held: Vec::new(), queue: Vec::new() }
    }

    /// Lanes that can't be used together with this one.
    #[cfg(test)]
    pub fn conflicts_of(&self, lane: LaneId) -> Vec<LaneId> {
        self.conflicts.with(lane).iter().map(|c| c.0).collect()
    }

    pub fn holds(&self, slot: Slot, lane: LaneId) -> bool {
        self.holds_since(slot, lane).is_some()
    }

    /// Since which step somebody holds a lane.
    pub fn holds_since(&self, slot: Slot, lane: LaneId) -> Option<u64> {
        self.held.iter().find(|r| r.slot == slot && r.lane == lane).map(|r| r.since_step)
    }

    pub fn holds_any(&self, slot: Slot) -> bool {
        self.held.iter().any(|r| r.slot == slot && r.clear_at_m.is_none())
    }

    /// Why somebody who has asked may not go yet.
    pub fn refusal(&self, slot: Slot) -> Refusal {
        self.queue.iter().find(|q| q.slot == slot).map_or(Refusal::Undecided, |q| q.refusal)
    }

    /// Whether somebody who crosses a junction is about to leave it on a lane.
    pub fn is_exit(&self, lane: LaneId) -> bool {
        self.held.iter().any(|r| r.exit == lane)
    }

    /// Room on an exit lane that is promised to others than `slot`, once to each, however many lanes it holds.
    pub(super) fn promised(&self, slot: Slot, exit: LaneId) -> impl Iterator<Item = (Slot, f64)> {
        let promised = move |r: &Reservation| r.slot != slot && r.exit == exit;
        let is_first =
            move |(i, r): &(usize, &Reservation)| !self.held[..*i].iter().any(|q| q.slot == r.slot && q.exit == exit);
        self.held.iter().enumerate().filter(move |(_, r)| promised(r)).filter(is_first).map(|(_, r)| (r.slot, r.room_m))
    }

    /// A vehicle's tail has come this far along the lane that its middle is on.
    pub fn advance(&mut self, slot: Slot, lane: LaneId, tail_m: f64) {
        for r in self.held.iter_mut().filter(|r| r.slot == slot && r.lane == lane) {
            r.tail_m = tail_m;
        }
    }

    /// A vehicle's middle has left a lane; its tail follows when the odometer reads `clear_at_m`.
    pub fn leaving(&mut self, slot: Slot, lane: LaneId, clear_at_m: f64) {
        for r in self.held.iter_mut().filter(|r| r.slot == slot && r.lane == lane) {
            r.clear_at_m = Some(clear_at_m);
        }
    }

    /// Gives back what a vehicle has cleared, and what does not lie on its way any more.
    pub fn release(&mut self, slot: Slot, odometer_m: f64, is_on_way: impl Fn(LaneId) -> bool) {
        let is_held = |r: &Reservation| r.clear_at_m.map_or_else(|| is_on_way(r.lane), |clear| odometer_m < clear);
        self.held.retain(|r| r.slot != slot || is_held(r));
    }

    /// Forgets a vehicle: it was moved away.
    pub fn forget(&mut self, slot: Slot) {
        self.held.retain(|r| r.slot != slot);
        self.queue.retain(|q| q.slot != slot);
    }
}
