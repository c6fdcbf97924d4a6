//! What a user's person or rider shows: a mesh that stays as it is.

use std::sync::Arc;

use super::{Look, ModelFacts, PosedBox};
use cadet_assets::imported::FigureModel;
use cadet_base::actor::{AnnotatedBox, BodyEnd, ObjectClass};
use cadet_base::instance::Instance;

/// A user's model.
pub(crate) struct FigureLook {
    pub model: Arc<FigureModel>,
}

impl Look for FigureLook {
    fn class(&self) -> ObjectClass {
        self.model.class
    }

    fn model(&self) -> ModelFacts<'_> {
        ModelFacts { name: &self.model.name, size_lwh: self.model.size_lwh, annotated: self.model.annotated }
    }

    /// The box stays where the user's mesh is.
    fn annotated_from(&self, _near_end: BodyEnd) -> AnnotatedBox {
        self.model.annotated
    }

    fn parts(&self, posed: &PosedBox<'_>, parts: &mut Vec<Instance>) {
        parts.push(Instance {
            shape: Arc::clone(&self.model.body),
            palette: Arc::clone(&self.model.palette),
            world_from_local: posed.world_from_box,
            actor_id: posed.actor_id,
            is_body: true,
            sheds_snow: false,
        });
    }
}
