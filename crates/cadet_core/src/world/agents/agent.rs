//! An agent: somebody or something with a place, a shape and a will.

use std::any::Any;

use crate::actor::{AnnotatedBox, End, ObjectClass};
use crate::assets::annotation;
use crate::math::DVec3;
use crate::world::agents::{AgentParts, Controller};
use crate::world::body::Body;
use crate::world::footprint::Footprint;
use crate::world::look::Appearance;
use crate::world::physics::Physics;
use crate::world::slot::Slot;

/// The ego, a car in traffic, a parked one, a person.
pub(crate) struct Agent {
    /// Never given twice; 0 for the ego.
    pub id: i32,
    pub class: ObjectClass,
    pub body: Body,
    pub controller: Box<dyn Controller>,
    pub appearance: Appearance,
    /// Put there by the user: never replaced.
    pub is_placed: bool,
    /// The end that was near when it was first labeled: its annotated box stays as it was drawn then.
    pub labeled_end: Option<End>,
}

impl Agent {
    /// The controller, and apart from it what it steers.
    pub fn parts_mut(&mut self, slot: Slot) -> (&mut dyn Controller, AgentParts<'_>) {
        let own = AgentParts { slot, body: &mut self.body, appearance: &mut self.appearance };
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

    /// The end that annotators see, who look from an eye unless they have labeled it before.
    pub fn near_end(&self, physics: &Physics, eye_world: DVec3) -> End {
        self.labeled_end.unwrap_or_else(|| End::nearer(&self.body.world_from_box(physics), eye_world))
    }

    /// The box that these annotators draw.
    pub fn annotated(&self, physics: &Physics, eye_world: DVec3) -> AnnotatedBox {
        annotation::displaced(self.appearance.annotated(), self.class, self.near_end(physics, eye_world))
    }

    /// What the agent's box covers.
    pub fn footprint(&self, physics: &Physics) -> Footprint {
        let velocity = self.body.velocity_world(physics).truncate();
        Footprint::of_box(&self.body.world_from_box(physics), self.appearance.size_lwh(), velocity)
    }
}
