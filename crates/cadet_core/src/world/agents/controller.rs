//! The interface through which all agents act.

use std::any::Any;

use crate::town::LaneId;
use crate::world::body::Body;
use crate::world::driving::Cause;
use crate::world::footprint::Footprint;
use crate::world::look::Appearance;
use crate::world::outlook::Outlook;
use crate::world::physics::Physics;
use crate::world::slot::Slot;
use crate::world::streets::Roads;
use crate::world::streets::Streets;
use crate::world::traffic_state::TrafficState;

/// What a controller steers.
pub(crate) struct AgentParts<'a> {
    pub slot: Slot,
    pub body: &'a mut Body,
    pub appearance: &'a mut Appearance,
}

/// Decides what an agent does.
pub(crate) trait Controller: Any + Send + Sync {
    /// Looks around; what it finds holds until the next look, a few steps later. All look at the same state, and none
    /// sees what another finds in the same look: the order does not matter.
    fn look(&mut self, _own: AgentParts<'_>, _around: &TrafficState, _streets: &Streets, _step: u64) -> Outlook {
        Outlook::default()
    }

    /// Before the physics step: gives the body its commands.
    fn act(&mut self, _own: AgentParts<'_>, _physics: &mut Physics, _streets: &Streets) {}

    /// The slot of the agent whose act comes first, and that this one follows.
    fn follows(&self) -> Option<Slot> {
        None
    }

    /// Before the physics step, after all have acted: gives the body its commands by what the leader does.
    fn follow(&mut self, _own: AgentParts<'_>, _leader: &dyn Controller, _physics: &mut Physics) {}

    /// After the physics step: finds out where the body has got to. `around` has everybody's new places.
    fn track(&mut self, _own: AgentParts<'_>, _physics: &Physics, _around: &mut TrafficState, _streets: &Streets) {}

    /// The lane that it drives on, and how far along it the middle of the body is.
    fn on_lane(&self) -> Option<(LaneId, f64)> {
        None
    }

    /// What it brakes for most.
    fn cause(&self) -> Cause {
        Cause::Nothing
    }

    /// What drivers have to keep off because of a person on the road.
    fn on_road(&self, _body: &Body, _roads: &Roads) -> Option<Footprint> {
        None
    }

    /// Somebody has gone, and a newcomer has its slot.
    fn forget(&mut self, _gone: Slot) {}
}
