//! What agents look like: a model, and the parts of it that the sensors see.

mod cyclist;
mod figure;
mod lamp_light;
mod person;
mod ride;
mod turn_signal;
mod vehicle;

pub(super) use cyclist::CyclistLook;
pub(super) use figure::FigureLook;
pub(super) use lamp_light::LampLight;
pub(super) use person::PersonLook;
pub(super) use ride::Ride;
pub(super) use turn_signal::TurnSignal;
pub(super) use vehicle::VehicleLook;

use cadet_assets::annotation;
use cadet_base::actor::{AnnotatedBox, BodyEnd, ObjectClass};
use cadet_base::instance::Instance;
use cadet_base::math::{DPose3, DVec3};

/// A model and the state of its parts.
pub(super) trait Look: Send + Sync {
    fn class(&self) -> ObjectClass;

    /// Name, size, and annotated box of its model.
    fn model(&self) -> ModelFacts<'_>;

    /// Length, width, height.
    fn size_lwh(&self) -> DVec3 {
        self.model().size_lwh
    }

    /// The annotated box, displaced toward the ego as by annotators of its class to whom an end is near.
    fn annotated_from(&self, near_end: BodyEnd) -> AnnotatedBox {
        annotation::displaced(self.model().annotated, self.class(), near_end)
    }

    /// Appends the posed parts.
    fn parts(&self, posed: &PosedBox<'_>, parts: &mut Vec<Instance>);
}

/// Facts of a model, whatever it is of.
pub(super) struct ModelFacts<'a> {
    pub name: &'a str,
    /// Length, width, height.
    pub size_lwh: DVec3,
    /// The box that an annotator would draw of it.
    pub annotated: AnnotatedBox,
}

/// Where an actor is, and what its lamps depend on.
pub(super) struct PosedBox<'a> {
    pub actor_id: i32,
    pub world_from_box: DPose3,
    /// Where the body has its four wheels, if it has as many.
    pub box_from_wheels: Option<[DPose3; 4]>,
    pub light: &'a LampLight,
}
