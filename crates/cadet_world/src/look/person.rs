//! What a person shows: the body at a phase of its gait, and what the person has along.

use std::sync::Arc;

use super::{Look, ModelFacts, PosedBox};
use cadet_assets::person::PersonModel;
use cadet_base::actor::ObjectClass;
use cadet_base::instance::Instance;

/// A person's model and the state of its parts.
pub(crate) struct PersonLook {
    pub model: Arc<PersonModel>,
    /// Phase of the gait cycle in [0, 1).
    pub phase: f64,
}

impl PersonLook {
    /// Moves the legs by a way.
    pub fn walk(&mut self, moved_m: f64) {
        self.phase = (self.phase + moved_m / self.model.cycle_length_m.max(0.1)).fract();
    }
}

impl Look for PersonLook {
    fn class(&self) -> ObjectClass {
        if self.model.sits() { ObjectClass::PersonSitting } else { ObjectClass::Pedestrian }
    }

    fn model(&self) -> ModelFacts<'_> {
        ModelFacts { name: &self.model.name, size_lwh: self.model.size_lwh, annotated: self.model.annotated }
    }

    fn parts(&self, posed: &PosedBox<'_>, parts: &mut Vec<Instance>) {
        let Self { model, phase } = self;
        let mut push = |shape, palette, is_body| {
            let (actor_id, world_from_local) = (posed.actor_id, posed.world_from_box);
            parts.push(Instance { shape, palette, world_from_local, actor_id, is_body, sheds_snow: false });
        };
        push(Arc::new(model.pose(*phase)), Arc::clone(&model.palette), true);
        if let Some(belonging) = &model.belonging {
            push(belonging.pose(*phase), Arc::clone(&belonging.palette), belonging.is_solid());
        }
    }
}
