//! An agent: somebody or something with a place, a shape and a will.

use std::any::Any;

use super::appearance::Appearance;
use super::body::Body;
use super::control::{Controller, Own};
use super::footprint::Footprint;
use super::physics::Physics;
use super::slot::Slot;
use crate::actor::ObjectClass;

/// The ego, a car in traffic, a parked one, a person.
pub(super) struct Agent {
    /// Never given twice; 0 for the ego.
    pub id: i32,
    pub class: ObjectClass,
    pub body: Body,
    pub controller: Box<dyn Controller>,
    pub appearance: Appearance,
    /// Put there by the user: never replaced.
    pub is_placed: bool,
}

impl Agent {
    /// The controller, and apart from it what it steers.
    pub fn parts_mut(&mut self, slot: Slot) -> (&mut dyn Controller, Own<'_>) {
        let own = Own { slot, body: &mut self.body, appearance: &mut self.appearance };
        (self.controller.as_mut(), own)
    }

    /// The controller, if it is of this kind.
    pub fn controlled_by<T: Controller>(&self) -> Option<&T> {
        let controller: &dyn Any = self.controller.as_ref();
        controller.downcast_ref()
    }

    /// The same, to be changed.
    pub fn controlled_by_mut<T: Controller>(&mut self) -> Option<&mut T> {
        let controller: &mut dyn Any = self.controller.as_mut();
        controller.downcast_mut()
    }

    /// What the agent's box covers.
    pub fn footprint(&self, physics: &Physics) -> Footprint {
        let velocity = self.body.velocity_world(physics).truncate();
        Footprint::of_box(&self.body.world_from_box(physics), self.appearance.size_lwh(), velocity)
    }
}
