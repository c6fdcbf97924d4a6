//! The light of the lamps of a night on a batch's surfaces.

use macro_rules_attribute::apply;

use super::super::face::ShaderVariant;
use super::super::shading_queue::{BATCH_SIZE, BATCH_STRIDE};
use super::batch::{BatchVector, IncidentLight, SurfaceGeometry, SurfaceInputs};
use super::lighting::{SurfaceCoat, lamp_coat};
use crate::camera::light::{NightLights, WIDE, WideLight, WideSurfaces, add_lamp};
use crate::camera::surfaces::Flags;
use crate::wide_registers::array_of;
use cadet_base::material::Pattern;
use cadet_base::math::Vec3;

/// Adds what `n` pairs get of all lamps to the irradiance, and what they mirror of them to `mirrored`, which starts at 0.
#[apply(for_wide_registers)]
pub fn add_lamp_light(
    inputs: &SurfaceInputs,
    geometry: &SurfaceGeometry,
    incident: &IncidentLight,
    n: usize,
    variant: ShaderVariant,
    night: &NightLights,
    wetness: f32,
    eye: Vec3,
    irradiance: &mut BatchVector,
    mirrored: &mut BatchVector,
) {
    for plane in mirrored.iter_mut() {
        plane.fill(0.0);
    }
    let mut cells = [NightLights::OUTSIDE; BATCH_STRIDE];
    for i in 0..n.min(BATCH_SIZE) {
        cells[i] = night.cell(geometry.point[0][i], geometry.point[1][i]);
    }
    for first in (0..n.min(BATCH_SIZE)).step_by(WIDE) {
        let of = |values: &BatchVector| array_of(|axis| array_of(|i| values[axis][first + i]));
        let mut s = WideSurfaces {
            point: of(&geometry.point),
            normal: of(&geometry.normal),
            view: of(&geometry.view),
            contact: array_of(|i| incident.contact_occlusion[first + i]),
            f0: [0.0; WIDE],
            roughness: [1.0; WIDE],
            mirror: [0.0; WIDE],
            flags: array_of(|i| inputs.flags[first + i]),
            is_leaf: variant.pattern == Pattern::Leaves,
            is_glossy: variant.is_glossy || variant.is_transparent,
        };
        if s.is_glossy {
            for i in 0..WIDE {
                let at = first + i;
                let place = [geometry.point[0][at] + eye.x, geometry.point[1][at] + eye.y];
                let is_ground = inputs.flags[at] & Flags::GROUND > 0;
                let own = SurfaceCoat { f0: inputs.f0[at], roughness: inputs.roughness[at] };
                let rise = geometry.normal[2][at];
                let (coat, mirror) = lamp_coat(is_ground, rise, place, wetness, own);
                (s.f0[i], s.roughness[i], s.mirror[i]) = (coat.f0, coat.roughness, mirror);
            }
        }
        let cells: [u32; WIDE] = array_of(|i| cells[first + i]);
        let mut light = WideLight::default();
        for (i, cell) in cells.iter().enumerate() {
            if cells[..i].contains(cell) {
                continue;
            }
            let share = array_of(|k| if cells[k] == *cell { 1.0 } else { 0.0 });
            for number in night.of_cell(*cell) {
                add_lamp(&night.lamps[usize::from(*number)], &s, &share, &mut light);
            }
        }
        for axis in 0..3 {
            for i in 0..WIDE {
                irradiance[axis][first + i] += light.irradiance[axis][i];
                mirrored[axis][first + i] = light.mirrored[axis][i];
            }
        }
    }
}
