//! What all kinds of agents do.

use super::actor::ActorView;
use crate::driving::Cause;
use crate::footprint::Footprint;
use crate::outlook::Outlook;
use crate::physics::Physics;
use crate::slot::Slot;
use crate::streets::{LaneGraph, LanePosition, Streets};
use crate::traffic_state::TrafficState;

/// An agent decides what its actors do: one, or as many as a train has cars.
pub(crate) trait Behavior: Send + Sync {
    /// The `k`-th of its actors.
    fn actor(&self, k: usize) -> Option<ActorView<'_>>;

    /// Looks around; what it finds holds until the next look, a few steps later. All look at the same state, and none
    /// sees what another finds in the same look: the order does not matter.
    fn look(&mut self, _slot: Slot, _around: &TrafficState, _streets: &Streets, _step: u64) -> Outlook {
        Outlook::default()
    }

    /// Before the physics step: gives the bodies their commands.
    fn act(&mut self, _physics: &mut Physics, _streets: &Streets) {}

    /// After the physics step: finds out where the body has got to. `around` has everybody's new places.
    fn track(&mut self, _slot: Slot, _physics: &Physics, _around: &mut TrafficState, _streets: &Streets) {}

    /// Where on the lanes the middle of the `k`-th actor drives.
    fn on_lane(&self, _k: usize) -> Option<LanePosition> {
        None
    }

    /// What it brakes for most.
    fn cause(&self) -> Cause {
        Cause::Nothing
    }

    /// What drivers have to keep off because of a person on the road.
    fn on_road(&self, _graph: &LaneGraph) -> Option<Footprint> {
        None
    }

    /// Somebody has gone, and a newcomer has its slot.
    fn forget(&mut self, _gone: Slot) {}
}
