//! What an agent looks like: its model, and the parts of it that the sensors see.

use std::sync::Arc;

use super::lamp_light::LampLight;
use super::ride::Ride;
use super::turn_signal::TurnSignal;
use crate::actor::AnnotatedBox;
use crate::assets::cyclist::CyclistModel;
use crate::assets::person::PersonModel;
use crate::assets::vehicle::{LitLamps, Opening, VehicleModel};
use crate::geometry::LodSet;
use crate::instance::Instance;
use crate::math::{DPose3, DVec3};

/// Engines slow a car without lighting its brake lamps; a pressed pedal is not let go for a moment.
const BRAKING_MPS2: f64 = -0.8;
const RELEASED_MPS2: f64 = -0.2;

/// A model and the state of its parts.
pub(crate) enum Appearance {
    Vehicle {
        model: Arc<VehicleModel>,
        /// Whether somebody is seen at the wheel.
        is_driven: bool,
        is_braking: bool,
        signal: TurnSignal,
        /// A door or a tailgate that stands open.
        opened: Option<Arc<LodSet>>,
    },
    Person {
        model: Arc<PersonModel>,
        /// Phase of the gait cycle in [0, 1).
        phase: f64,
    },
    Cyclist {
        model: Arc<CyclistModel>,
        ride: Ride,
    },
}

impl Appearance {
    /// A closed vehicle that neither brakes nor signals.
    pub fn vehicle(model: Arc<VehicleModel>, is_driven: bool) -> Self {
        Self::Vehicle { model, is_driven, is_braking: false, signal: TurnSignal::Off, opened: None }
    }

    /// Length, width, height.
    pub fn size_lwh(&self) -> DVec3 {
        match self {
            Self::Vehicle { model, .. } => model.size_lwh,
            Self::Person { model, .. } => model.size_lwh,
            Self::Cyclist { model, .. } => model.size_lwh,
        }
    }

    pub fn annotated(&self) -> AnnotatedBox {
        match self {
            Self::Vehicle { model, .. } => model.annotated,
            Self::Person { model, .. } => model.annotated,
            Self::Cyclist { model, .. } => model.annotated,
        }
    }

    /// The model's name.
    pub fn name(&self) -> &str {
        match self {
            Self::Vehicle { model, .. } => &model.name,
            Self::Person { model, .. } => &model.name,
            Self::Cyclist { model, .. } => &model.name,
        }
    }

    /// Presses a vehicle's brake pedal, or the other one.
    pub fn accelerate(&mut self, accel_mps2: f64) {
        if let Self::Vehicle { is_braking, .. } = self {
            *is_braking = accel_mps2 < if *is_braking { RELEASED_MPS2 } else { BRAKING_MPS2 };
        }
    }

    /// Says where a vehicle is about to go.
    pub fn indicate(&mut self, intent: TurnSignal) {
        if let Self::Vehicle { signal, .. } = self {
            *signal = intent;
        }
    }

    /// Opens a door or the tailgate, if the vehicle has such.
    pub fn open(&mut self, opening: Opening) {
        if let Self::Vehicle { model, opened, .. } = self {
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

    /// The posed parts. `box_from_wheels` is where the body has its wheels, if it has any; `light` lights the lamps of what
    /// is driven.
    pub fn parts(
        &self,
        world_from_box: DPose3,
        box_from_wheels: Option<[DPose3; 4]>,
        actor_id: i32,
        light: &LampLight,
        parts: &mut Vec<Instance>,
    ) {
        let palette = match self {
            Self::Vehicle { model, is_driven, is_braking, signal, .. } => &model.palette_lit(LitLamps {
                low_beams: *is_driven && light.needs_lamps,
                brake: *is_braking,
                signals: signal.lit_sides(actor_id, light),
                at_night: light.is_night,
            }),
            Self::Person { model, .. } => &model.palette,
            Self::Cyclist { model, .. } => &model.palette,
        };
        let sheds_snow = match self {
            Self::Vehicle { is_driven, .. } => *is_driven,
            Self::Person { .. } => false,
            Self::Cyclist { .. } => true,
        };
        let mut push = |shape, box_from_local: DPose3, is_body| {
            let (palette, world_from_local) = (Arc::clone(palette), world_from_box * box_from_local);
            parts.push(Instance { shape, palette, world_from_local, actor_id, is_body, sheds_snow });
        };
        match self {
            Self::Person { model, phase } => {
                push(Arc::new(model.pose(*phase)), DPose3::IDENTITY, true);
                if let Some(belonging) = &model.belonging {
                    parts.push(Instance {
                        shape: belonging.pose(*phase),
                        palette: Arc::clone(&belonging.palette),
                        world_from_local: world_from_box,
                        actor_id,
                        is_body: belonging.is_solid(),
                        sheds_snow,
                    });
                }
            }
            Self::Vehicle { model, is_driven, opened, .. } => {
                push(Arc::clone(&model.body), DPose3::IDENTITY, true);
                if let Some(opened) = opened {
                    push(Arc::clone(opened), DPose3::IDENTITY, false);
                }
                if let Some(driver) = model.driver.as_ref().filter(|_| *is_driven) {
                    push(Arc::clone(driver), DPose3::IDENTITY, false);
                }
                if let (Some(wheel), Some(box_from_wheels)) = (&model.wheel, box_from_wheels) {
                    for box_from_wheel in box_from_wheels {
                        push(Arc::clone(wheel), box_from_wheel, false);
                    }
                }
            }
            Self::Cyclist { model, ride } => {
                let box_from_leaning = ride.box_from_leaning();
                let body = if ride.stands { model.body(true) } else { model.pointing(ride.arm) };
                push(body, box_from_leaning, true);
                push(if ride.stands { model.standing() } else { model.pedaling(ride.crank) }, box_from_leaning, false);
                for axle in model.axles() {
                    push(Arc::clone(&model.wheel), box_from_leaning * ride.leaning_from_wheel(axle), false);
                }
            }
        }
    }
}
