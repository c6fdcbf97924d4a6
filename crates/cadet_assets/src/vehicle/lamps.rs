//! Lit lamps: what they change of a vehicle's materials, and the light that they send out at night.

use std::sync::Arc;

use super::VehicleModel;
use super::paint::{slot, work_slot};
use cadet_base::actor::ObjectClass;
use cadet_base::lamp::{Lamp, LampBeam};
use cadet_base::material::{Material, Palette, Pattern};
use cadet_base::math::{DVec3, Vec3};
use cadet_base::rng::Stream;

/// What lit lenses send out, as shares of `camera`'s lamp radiance.
const LOW_BEAM: [f32; 3] = [1.0, 0.96, 0.86];
const TAIL: [f32; 3] = [0.20, 0.002, 0.001];
const BRAKE: [f32; 3] = [0.80, 0.008, 0.006];
const SIGNAL: [f32; 3] = [1.0, 0.33, 0.010];

/// Colors of low beams, of luma 1: halogen bulbs, and gas discharge or LED.
pub const HALOGEN: [f32; 3] = [1.16, 0.98, 0.73];
const WHITE: [f32; 3] = [0.98, 1.0, 1.08];
const WHITE_SHARE: f64 = 0.35;
/// The strongest intensity of one low beam.
const LOW_BEAM_CD: f32 = 16_000.0;
const LOW_BEAM_REACH_M: f32 = 90.0;
/// Of a vehicle's size: how high and how far aside its lamps are; and the least and the greatest height, meters.
const HEIGHT_SHARE: f32 = 0.43;
const ASIDE_SHARE: f32 = 0.37;
const HEIGHTS_M: (f32, f32) = (0.6, 0.95);
/// How far a lamp's light starts before its lens.
const BEFORE_LENS_M: f32 = 0.05;
/// Tail lamps and brake lamps of both sides together.
const TAIL_CD: f32 = 12.0;
const BRAKE_CD: f32 = 80.0;
const RED: [f32; 3] = [3.2, 0.03, 0.02];
const TAIL_REACH_M: f32 = 45.0;
/// Windows of buses and trams with people in them ([`Pattern::Window`]), and the light inside.
const BUS_PANES: [f32; 3] = [2.0, 0.012, 0.0];
const BUS_INSIDE: f32 = 0.25;

/// Which lamps of a vehicle are lit.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq)]
pub struct LitLamps {
    /// Low beams, and tail lamps with them.
    pub low_beams: bool,
    /// Brake lamps, which share the tail lamps' lenses.
    pub brake: bool,
    /// They light what is around, the windows of buses and trams are lit, and dark tail lamps reflect the beams of others.
    pub at_night: bool,
    /// Turn signals of the left side, and of the right.
    pub signals: [bool; 2],
}

/// The two low beams of a vehicle of a size, in its box frame.
#[must_use]
pub fn low_beams(size_lwh: DVec3, color: [f32; 3]) -> [Lamp; 2] {
    let size = size_lwh.as_vec3();
    let z = (HEIGHT_SHARE * size.z).clamp(HEIGHTS_M.0, HEIGHTS_M.1);
    [1.0, -1.0].map(|side| {
        let at = Vec3::new(0.5 * size.x + BEFORE_LENS_M, side * ASIDE_SHARE * size.y, z);
        Lamp::of_candela(LampBeam::LowBeam, at, [Vec3::X, Vec3::Y], color, LOW_BEAM_CD, LOW_BEAM_REACH_M)
    })
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
        if !lit.at_night {
            return Arc::new(Palette::new(materials));
        }
        self.change_at_night(&mut materials, lit);
        Arc::new(Palette::new(materials).with_lamps(self.lamps(lit)))
    }

    /// What else of the materials is another at night.
    fn change_at_night(&self, materials: &mut [Material], lit: LitLamps) {
        if !lit.low_beams && !lit.brake {
            materials[usize::from(slot::TAIL_LAMP)].pattern = Pattern::Reflector;
        }
        let is_tram = self.class == ObjectClass::Tram;
        if lit.low_beams && (is_tram || self.livery == super::Livery::Bus) {
            for number in [slot::SIDE_GLASS, slot::REAR_SIDE_GLASS] {
                let pane = &mut materials[usize::from(number)];
                (pane.albedo, pane.pattern) = (BUS_PANES, Pattern::Window);
            }
            if let Some(lining) = materials.get_mut(usize::from(work_slot::LINING)) {
                lining.shine(BUS_INSIDE);
            }
        }
    }

    /// What lights the surroundings.
    fn lamps(&self, lit: LitLamps) -> Vec<Lamp> {
        let mut lamps = Vec::new();
        // Of a tram, not every car has lamps at its end.
        if lit.low_beams && self.class != ObjectClass::Tram {
            let is_white = Stream::from_seed(&self.name, 0).chance(WHITE_SHARE);
            lamps.extend(low_beams(self.size_lwh, if is_white { WHITE } else { HALOGEN }));
        }
        let candela = if lit.brake { BRAKE_CD } else { TAIL_CD };
        if lit.low_beams || lit.brake {
            let size = self.size_lwh.as_vec3();
            let z = (1.3 * HEIGHT_SHARE * size.z).clamp(HEIGHTS_M.0, 1.2 * HEIGHTS_M.1);
            let at = Vec3::new(-0.5 * size.x - BEFORE_LENS_M, 0.0, z);
            let axes = [-Vec3::X, -Vec3::Y];
            lamps.push(Lamp::of_candela(LampBeam::Lens, at, axes, RED, candela, TAIL_REACH_M));
        }
        lamps
    }
}
