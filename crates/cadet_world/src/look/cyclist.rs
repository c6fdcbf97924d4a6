//! What a cyclist shows: the rider, who leans, pedals, points, or stands, and two wheels.

use std::sync::Arc;

use super::{Look, ModelFacts, PosedBox, Ride};
use cadet_assets::cyclist::CyclistModel;
use cadet_base::actor::ObjectClass;
use cadet_base::instance::Instance;

/// A cyclist's model and the state of its parts.
pub(crate) struct CyclistLook {
    pub model: Arc<CyclistModel>,
    pub ride: Ride,
}

impl Look for CyclistLook {
    fn class(&self) -> ObjectClass {
        ObjectClass::Cyclist
    }

    fn model(&self) -> ModelFacts<'_> {
        ModelFacts { name: &self.model.name, size_lwh: self.model.size_lwh, annotated: self.model.annotated }
    }

    fn parts(&self, posed: &PosedBox<'_>, parts: &mut Vec<Instance>) {
        let Self { model, ride } = self;
        let box_from_leaning = ride.box_from_leaning();
        let mut push = |shape, box_from_local, is_body| {
            parts.push(Instance {
                shape,
                palette: Arc::clone(&model.palette),
                world_from_local: posed.world_from_box * box_from_local,
                actor_id: posed.actor_id,
                is_body,
                sheds_snow: true,
            });
        };
        push(if ride.stands { model.body(true) } else { model.pointing(ride.arm_share) }, box_from_leaning, true);
        push(if ride.stands { model.standing() } else { model.pedaling(ride.crank_phase) }, box_from_leaning, false);
        for axle in model.axles() {
            push(Arc::clone(&model.wheel), box_from_leaning * ride.leaning_from_wheel(axle), false);
        }
    }
}
