//! What a vehicle shows: its body, wheels, driver, lamps, and what stands open.

use std::sync::Arc;

use super::{Look, ModelFacts, PosedBox, TurnSignal};
use cadet_assets::vehicle::{LitLamps, Opening, VehicleModel};
use cadet_base::actor::ObjectClass;
use cadet_base::geometry::LodSet;
use cadet_base::instance::Instance;
use cadet_base::math::DPose3;

/// Engines slow a car without lighting its brake lamps; a pressed pedal is not let go for a moment.
const BRAKING_MPS2: f64 = -0.8;
const RELEASED_MPS2: f64 = -0.2;

/// A vehicle's model and the state of its parts.
pub(crate) struct VehicleLook {
    pub model: Arc<VehicleModel>,
    /// Whether somebody is seen at the wheel.
    pub is_driven: bool,
    is_braking: bool,
    /// What the turn signals show.
    pub signal: TurnSignal,
    /// A door or a tailgate that stands open.
    pub opened: Option<Arc<LodSet>>,
}

impl VehicleLook {
    /// A closed vehicle that neither brakes nor signals.
    pub fn new(model: Arc<VehicleModel>, is_driven: bool) -> Self {
        Self { model, is_driven, is_braking: false, signal: TurnSignal::Off, opened: None }
    }

    /// Presses the brake pedal, or the other one.
    pub fn accelerate(&mut self, accel_mps2: f64) {
        self.is_braking = accel_mps2 < if self.is_braking { RELEASED_MPS2 } else { BRAKING_MPS2 };
    }

    /// Opens a door or the tailgate, if the vehicle has such.
    pub fn open(&mut self, opening: Opening) {
        let Self { model, opened, .. } = self;
        *opened = model.openings.as_ref().and_then(|openings| openings.opened(opening, model.size_lwh));
        if opened.is_some()
            && let Some((family, seed)) = model.name.split_once('/')
        {
            // Said in the name, as it reaches out of the box.
            let name = format!("{family} with {}/{seed}", opening.name());
            *model = Arc::new(VehicleModel { name, ..VehicleModel::clone(model) });
        }
    }
}

impl Look for VehicleLook {
    fn class(&self) -> ObjectClass {
        self.model.class
    }

    fn model(&self) -> ModelFacts<'_> {
        ModelFacts { name: &self.model.name, size_lwh: self.model.size_lwh, annotated: self.model.annotated }
    }

    fn parts(&self, posed: &PosedBox<'_>, parts: &mut Vec<Instance>) {
        let PosedBox { actor_id, world_from_box, box_from_wheels, light } = posed;
        let Self { model, is_driven, .. } = self;
        let palette = model.palette_lit(LitLamps {
            low_beams: *is_driven && light.needs_lamps,
            brake: self.is_braking,
            signals: self.signal.lit_sides(*actor_id, light),
            at_night: light.is_night,
        });
        let mut push = |shape: &Arc<LodSet>, box_from_local: DPose3, is_body| {
            parts.push(Instance {
                shape: Arc::clone(shape),
                palette: Arc::clone(&palette),
                world_from_local: *world_from_box * box_from_local,
                actor_id: *actor_id,
                is_body,
                sheds_snow: *is_driven,
            });
        };
        push(&model.body, DPose3::IDENTITY, true);
        let driver = model.driver.as_ref().filter(|_| *is_driven);
        for shape in self.opened.iter().chain(driver) {
            push(shape, DPose3::IDENTITY, false);
        }
        if let Some(wheel) = &model.wheel {
            for box_from_wheel in box_from_wheels.iter().flatten() {
                push(wheel, *box_from_wheel, false);
            }
        }
    }
}
