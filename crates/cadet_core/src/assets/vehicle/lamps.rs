//! Lit lamps: what they change of a vehicle's materials.

use std::sync::Arc;

use super::VehicleModel;
use super::paint::slot;
use crate::material::{Palette, Pattern};

/// What lit lenses send out, as shares of `camera`'s lamp radiance.
const LOW_BEAM: [f32; 3] = [1.0, 0.96, 0.86];
const TAIL: [f32; 3] = [0.20, 0.002, 0.001];
const BRAKE: [f32; 3] = [0.80, 0.008, 0.006];
const SIGNAL: [f32; 3] = [1.0, 0.33, 0.010];

/// Which lamps of a vehicle are lit.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq)]
pub struct LitLamps {
    /// Low beams, and tail lamps with them.
    pub low_beams: bool,
    /// Brake lamps, which share the tail lamps' lenses.
    pub brake: bool,
    /// Turn signals of the left side, and of the right.
    pub signals: [bool; 2],
}

impl VehicleModel {
    /// The vehicle's materials with some lamps lit; an imported vehicle's, whose lenses are not told apart, stay dark.
    #[must_use]
    pub fn palette_lit(&self, lit: LitLamps) -> Arc<Palette> {
        if !self.has_lenses || lit == LitLamps::default() {
            return Arc::clone(&self.palette);
        }
        let mut materials = self.palette.materials().to_vec();
        let mut light = |slot: u8, color: [f32; 3]| {
            let lens = &mut materials[usize::from(slot)];
            (lens.albedo, lens.pattern) = (color, Pattern::Lamp);
        };
        if lit.low_beams {
            light(slot::LAMP, LOW_BEAM);
            light(slot::TAIL_LAMP, TAIL);
        }
        if lit.brake {
            light(slot::TAIL_LAMP, BRAKE);
        }
        for (slot, is_lit) in [slot::LEFT_SIGNAL, slot::RIGHT_SIGNAL].into_iter().zip(lit.signals) {
            if is_lit {
                light(slot, SIGNAL);
            }
        }
        Arc::new(Palette::new(materials))
    }
}
