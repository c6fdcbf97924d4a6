//! A body with its look: what is posed, seen, and labeled as one actor.

use crate::body::Body;
use crate::footprint::Footprint;
use crate::look::Look;
use crate::physics::Physics;
use cadet_base::actor::BodyEnd;
use cadet_base::math::DVec3;

/// What an agent steers.
pub(crate) struct Actor<B, L> {
    pub body: B,
    pub look: L,
}

impl<B: Body, L: Look> Actor<B, L> {
    pub fn view(&self) -> ActorView<'_> {
        ActorView { body: &self.body, look: &self.look }
    }
}

/// A borrowed actor, whatever the kinds of its body and its look.
#[derive(Clone, Copy)]
pub(crate) struct ActorView<'a> {
    pub body: &'a dyn Body,
    pub look: &'a dyn Look,
}

impl ActorView<'_> {
    /// What the box covers.
    pub fn footprint(&self, physics: &Physics) -> Footprint {
        let velocity = self.body.velocity_world(physics).truncate();
        Footprint::of_box(&self.body.world_from_box(physics), self.look.size_lwh(), velocity)
    }

    /// The end that annotators see, who look from an eye.
    pub fn near_end(&self, physics: &Physics, eye_world: DVec3) -> BodyEnd {
        BodyEnd::nearer(&self.body.world_from_box(physics), eye_world)
    }
}
