//! What stays where it is: parked vehicles, somebody who sits, a cyclist with a foot on the ground, a user's figures.

use super::actor::{Actor, ActorView};
use super::behavior::Behavior;
use crate::body::{Cycle, Fixed, Upright};
use crate::footprint::Footprint;
use crate::look::{CyclistLook, FigureLook, PersonLook, VehicleLook};
use crate::streets::LaneGraph;
use crate::walking::{is_on_road, keep_off};
use cadet_base::actor::ObjectClass;

/// An agent that does nothing.
pub(crate) enum Fixture {
    Vehicle(Actor<Fixed, VehicleLook>),
    Cyclist(Actor<Cycle, CyclistLook>),
    Person(Actor<Upright, PersonLook>),
    Figure(Actor<Upright, FigureLook>),
    RidingFigure(Actor<Cycle, FigureLook>),
}

impl Behavior for Fixture {
    fn actor(&self, k: usize) -> Option<ActorView<'_>> {
        (k == 0).then(|| match self {
            Self::Vehicle(actor) => actor.view(),
            Self::Cyclist(actor) => actor.view(),
            Self::Person(actor) => actor.view(),
            Self::Figure(actor) => actor.view(),
            Self::RidingFigure(actor) => actor.view(),
        })
    }

    fn on_road(&self, graph: &LaneGraph) -> Option<Footprint> {
        let Self::Figure(Actor { body, .. }) = self else { return None };
        is_on_road(body, body.at(), graph).then(|| keep_off(body, 0.0))
    }
}

/// An agent that has left the world.
pub(crate) struct Gone {
    pub class: ObjectClass,
}

impl Behavior for Gone {
    fn actor(&self, _k: usize) -> Option<ActorView<'_>> {
        None
    }
}
