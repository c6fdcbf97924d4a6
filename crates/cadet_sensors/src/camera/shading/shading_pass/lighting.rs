//! The light that a batch's surfaces send towards the camera.
//!
//! Every pair goes through the same IEEE operations in the same order whatever the instruction set, so that the bytes are
//! the same with wide registers and without.

use macro_rules_attribute::apply;

use super::super::face::ShaderVariant;
use super::super::shading_queue::BATCH_SIZE;
use super::batch::{BatchVector, IncidentLight, OutgoingLight, SurfaceGeometry, SurfaceInputs, get, put};
use super::reflections::{environment, fifth, highlight};
use crate::camera::light::{Light, Sky};
use crate::camera::surfaces::{Flags, value_noise};
use cadet_base::material::Pattern;
use cadet_base::math::Vec3;

/// Leaves turn to all sides, and let through so much light for what they reflect, yellower.
const LEAF_TRANSMISSION: f32 = 0.75;
/// Ambient light reaches them on both sides, where leaves about them leave some.
const LEAF_AMBIENT: f32 = CROWN_OPENNESS * (1.0 + LEAF_TRANSMISSION);
/// Share of the light about a crown that reaches the leaves in it.
const CROWN_OPENNESS: f32 = 0.6;
const LEAF_TRANSMISSION_TINT: Vec3 = Vec3::new(0.85, 1.0, 0.50);
/// Of the sun's light, the share that goes by the cosine, and what is scattered to all sides.
const LEAF_DIRECT: f32 = 0.9;
const LEAF_SCATTERED: f32 = 0.20;
/// Ground whose normal rises more holds a film of water.
const WET_RISE: f32 = 0.5;
/// Of ground on which the film begins: stones stand out of it, and drops stir it, so that it is no mirror.
const WET_ROUGHNESS: f32 = 0.55;
/// A full film is so much smoother.
const SMOOTHER_BY_FILM: f32 = 0.2;
/// Of the parts of a film that mirror lamps: roughness, how much smoother a full film is, and their share of a full one.
const FILM_ROUGHNESS: f32 = 0.36;
const SMOOTHER_BY_LAMP_FILM: f32 = 0.08;
const FILM_MIRROR: f32 = 0.2;
/// Puddles: cells of noise per meter, and the film by wetness and by noise.
const PUDDLES_PER_M: f32 = 0.35;
const PUDDLE_SALT: u32 = 0xF11;
const FILM_BY_WETNESS: f32 = 1.5;
const FILM_BY_PUDDLE: f32 = 0.9;
/// Reflectance of water at normal incidence (n = 1.33).
const WATER_F0: f32 = 0.02;
/// Contact occlusion leaves at least this share of what is mirrored.
const LEAST_MIRRORED: f32 = 0.3;
/// What reflects more at normal incidence is a metal, which colors what it reflects.
const METAL_F0: f32 = 0.5;
/// Reflectance of a face of glass at normal incidence (n = 1.54); both faces of a pane reflect.
const GLASS_F0: f32 = 0.045;
const BOTH_FACES: f32 = 1.8;
const GLASS_ROUGHNESS: f32 = 0.15;
const GLASS_TINT: Vec3 = Vec3::new(0.93, 1.0, 0.95);

/// Ambient irradiance by shading normals, of faces that are not flat.
#[apply(for_wide_registers)]
pub fn ambient_of_normals(geometry: &SurfaceGeometry, m: usize, sky: &Sky, incident: &mut IncidentLight) {
    for i in 0..m.min(BATCH_SIZE) {
        let sky_visibility = std::array::from_fn(|k| incident.sky_visibility[k][i]);
        let ambient = sky.ambient(get(&geometry.normal, i), &sky_visibility);
        put(&mut incident.ambient, i, ambient);
    }
}

/// Diffuse irradiance: of sun and sky, on leaves of what comes through them.
#[apply(for_wide_registers)]
pub fn diffuse(
    geometry: &SurfaceGeometry,
    incident: &IncidentLight,
    m: usize,
    light: &Light,
    variant: ShaderVariant,
    out: &mut BatchVector,
) {
    let sky = &light.sky;
    if matches!(variant.pattern, Pattern::Lamp | Pattern::Window) {
        let radiance = if variant.pattern == Pattern::Lamp { light.lamp_radiance } else { 1.0 };
        out.iter_mut().for_each(|channel| channel.fill(radiance));
        return;
    }
    let is_leaf = variant.pattern == Pattern::Leaves;
    for i in 0..m.min(BATCH_SIZE) {
        let ambient =
            get(&incident.ambient, i) * (incident.contact_occlusion[i] * if is_leaf { LEAF_AMBIENT } else { 1.0 });
        let cos_sun = geometry.cos_sun[i];
        let facing = cos_sun.max(0.0);
        let direct = if is_leaf {
            let through = LEAF_TRANSMISSION_TINT * (LEAF_TRANSMISSION * (-cos_sun).max(0.0));
            (Vec3::splat(facing) + through) * LEAF_DIRECT + Vec3::splat(LEAF_SCATTERED)
        } else {
            Vec3::splat(facing)
        };
        put(out, i, sky.sun * direct * incident.shadow_factor[i] + ambient);
    }
}

/// The face of a surface.
#[derive(Debug, Clone, Copy)]
pub struct SurfaceCoat {
    /// Reflectance at normal incidence.
    pub f0: f32,
    pub roughness: f32,
}

/// A surface's own coat, or the film of water on it.
#[inline(always)]
pub fn coat(is_ground: bool, rise: f32, [x, y]: [f32; 2], wetness: f32, own: SurfaceCoat) -> SurfaceCoat {
    let film = film(is_ground, rise, [x, y], wetness);
    let f0 = if film > 0.0 { WATER_F0 } else { own.f0 };
    let roughness = if film > 0.0 { WET_ROUGHNESS - SMOOTHER_BY_FILM * film } else { own.roughness };
    SurfaceCoat { f0, roughness }
}

/// Share of a surface that is under a film of water.
#[inline(always)]
fn film(is_ground: bool, rise: f32, [x, y]: [f32; 2], wetness: f32) -> f32 {
    let puddle = value_noise(x * PUDDLES_PER_M, y * PUDDLES_PER_M, PUDDLE_SALT);
    let is_wet = is_ground && rise > WET_RISE;
    if is_wet { (wetness * FILM_BY_WETNESS - FILM_BY_PUDDLE * puddle).clamp(0.0, 1.0) } else { 0.0 }
}

/// As [`coat`] for the mirror images of lamps, and the share of the surface that is a mirror. What
/// stands out of the film is left out of it, so that it is smoother than for the sky.
#[inline(always)]
pub fn lamp_coat(is_ground: bool, rise: f32, place: [f32; 2], wetness: f32, own: SurfaceCoat) -> (SurfaceCoat, f32) {
    let film = film(is_ground, rise, place, wetness);
    if film > 0.0 {
        let roughness = FILM_ROUGHNESS - SMOOTHER_BY_LAMP_FILM * film;
        (SurfaceCoat { f0: WATER_F0, roughness }, FILM_MIRROR * film)
    } else {
        (own, (1.0 - own.roughness) * (1.0 - own.roughness))
    }
}

/// What a coat or a film of water reflects, and what it leaves of the diffuse light.
#[apply(for_wide_registers)]
pub fn specular(
    inputs: &SurfaceInputs,
    geometry: &SurfaceGeometry,
    incident: &IncidentLight,
    irradiance: &BatchVector,
    m: usize,
    light: &Light,
    eye: Vec3,
    out: &mut OutgoingLight,
) {
    let (sky, wetness) = (&light.sky, light.wetness);
    for i in 0..m.min(BATCH_SIZE) {
        let (view, normal) = (get(&geometry.view, i), get(&geometry.normal, i));
        let (x, y) = (geometry.point[0][i] + eye.x, geometry.point[1][i] + eye.y);
        let is_ground = inputs.flags[i] & Flags::GROUND > 0;
        let own = SurfaceCoat { f0: inputs.f0[i], roughness: inputs.roughness[i] };
        let SurfaceCoat { f0, roughness } = coat(is_ground, normal.z, [x, y], wetness, own);
        let cos_view = (-view.dot(normal)).clamp(0.0, 1.0);
        let smooth = (1.0 - roughness) * (1.0 - roughness);
        let fresnel = f0 + (1.0 - f0) * fifth(1.0 - cos_view) * smooth;
        let fresnel = if f0 > 0.0 { fresnel } else { 0.0 };
        let mirrored = view + normal * (2.0 * cos_view);
        let [a, b, c, d, ..] = &incident.sky_visibility;
        let reflected = environment(sky, mirrored, &[a[i], b[i], c[i], d[i]], roughness)
            * incident.contact_occlusion[i].max(LEAST_MIRRORED)
            + highlight(sky, mirrored, roughness) * incident.shadow_factor[i];
        let is_metal = f0 > METAL_F0;
        let metal = get(&inputs.albedo, i);
        let tint = Vec3::new(
            if is_metal { metal.x } else { 1.0 },
            if is_metal { metal.y } else { 1.0 },
            if is_metal { metal.z } else { 1.0 },
        );
        put(&mut out.diffuse, i, get(irradiance, i) * (1.0 - fresnel));
        put(&mut out.specular, i, reflected * tint * fresnel);
    }
}

/// Of transparent surfaces, whose base color is what is seen through them.
#[apply(for_wide_registers)]
pub fn transparent(
    inputs: &SurfaceInputs,
    geometry: &SurfaceGeometry,
    incident: &IncidentLight,
    m: usize,
    sky: &Sky,
    out: &mut OutgoingLight,
) {
    for i in 0..m.min(BATCH_SIZE) {
        let (view, normal) = (get(&geometry.view, i), get(&geometry.normal, i));
        let cos_view = (-view.dot(normal)).clamp(0.0, 1.0);
        let f0 = inputs.f0[i].max(GLASS_F0) * BOTH_FACES;
        let fresnel = (f0 + (1.0 - f0) * fifth(1.0 - cos_view)).min(1.0);
        let mirrored = view + normal * (2.0 * cos_view);
        let glint = highlight(sky, mirrored, GLASS_ROUGHNESS) * incident.shadow_factor[i];
        let tint = GLASS_TINT * inputs.transmission[i];
        let [a, b, c, d, ..] = &incident.sky_visibility;
        let reflected = environment(sky, mirrored, &[a[i], b[i], c[i], d[i]], 0.0) + glint;
        put(&mut out.diffuse, i, tint * (1.0 - fresnel));
        put(&mut out.specular, i, reflected * fresnel);
    }
}
