//! The shading pass of a batch: from pairs of pixels in a queue to the radiance of their pixels.
//!
//! Its steps and what they hand on: [`gather`] makes [`SurfaceInputs`] and the ambient part of [`IncidentLight`], [`geometry`]
//! makes [`SurfaceGeometry`], shadows and contact occlusion complete [`IncidentLight`], [`base_color`] makes two base colors a
//! pair, [`lighting`] makes [`OutgoingLight`], and [`resolve()`] takes it through the air and to the pixels.

mod base_color;
mod batch;
mod gather;
mod geometry;
mod lamp_light;
mod lighting;
mod reflections;
mod resolve;

use macro_rules_attribute::apply;

use self::base_color::{PixelOfPair, lay_snow, place_texture, snow_over, soak, texture};
pub use self::batch::ShadingCamera;
use self::batch::{BatchVector, GroupValues, IncidentLight, OutgoingLight, SurfaceGeometry, SurfaceInputs, put};
use self::gather::{gather_ambient, gather_faces, gather_groups, place_pairs};
use self::geometry::place_surfaces;
use self::lamp_light::add_lamp_light;
#[cfg(test)]
pub(crate) use self::lighting::{SurfaceCoat, lamp_coat};
use self::lighting::{ambient_of_normals, diffuse, specular, transparent};
#[cfg(test)]
pub(crate) use self::reflections::{environment, highlight};
use self::resolve::{resolve, through_air};
use super::ambient_cache::AmbientTerms;
use super::face::{ShaderVariant, ShadingFace};
use super::shading_queue::{BATCH_SIZE, BATCH_STRIDE, BatchScalar, REGISTER, ShadingQueue};
use crate::camera::light::{Light, PcfTexels, ShadowQuery};
use crate::camera::surfaces::Flags;
use cadet_base::material::Pattern;
use cadet_base::math::Vec3;

/// The memory of a batch's structures, used again and again.
pub struct ShadingPass {
    groups: GroupValues,
    inputs: SurfaceInputs,
    geometry: SurfaceGeometry,
    incident: IncidentLight,
    /// Pairs for which a shadow factor or contact occlusion is looked up, and memory for that.
    is_queried: [bool; BATCH_STRIDE],
    pcf_texels: PcfTexels<BATCH_STRIDE>,
    /// Coordinates of the texture, in the left and the right pixels.
    texture: [[BatchScalar; 2]; 2],
    /// What diffuse light is multiplied with, in the left and the right pixels: the albedo or, of transparent surfaces, what is
    /// seen through them.
    base_color: [BatchVector; 2],
    /// Diffuse irradiance.
    irradiance: BatchVector,
    /// Light of the lamps of a night that surfaces mirror.
    mirrored_lamps: BatchVector,
    /// As light leaves the surfaces, and as it arrives at the camera.
    outgoing: OutgoingLight,
    arriving: OutgoingLight,
    /// Radiance of the left and of the right pixels, weighted.
    radiance: [BatchVector; 2],
}

impl Default for ShadingPass {
    fn default() -> Self {
        const NONE: BatchScalar = [0.0; BATCH_STRIDE];
        Self {
            groups: GroupValues::default(),
            inputs: SurfaceInputs::default(),
            geometry: SurfaceGeometry::default(),
            incident: IncidentLight::default(),
            is_queried: [false; BATCH_STRIDE],
            pcf_texels: PcfTexels::default(),
            texture: [[NONE; 2]; 2],
            base_color: [[NONE; 3]; 2],
            irradiance: [NONE; 3],
            mirrored_lamps: [NONE; 3],
            outgoing: OutgoingLight::default(),
            arriving: OutgoingLight::default(),
            radiance: [[NONE; 3]; 2],
        }
    }
}

impl ShadingPass {
    /// Shades the groups that wait for a shader variant; see [`ShadingPass::targets`] and [`ShadingPass::radiance`].
    ///
    /// `rgb`: the picture, where transparent surfaces find what is behind them.
    pub fn shade(
        &mut self,
        light: &Light,
        camera: &ShadingCamera,
        variant: ShaderVariant,
        queue: &ShadingQueue,
        (faces, ambient): (&[ShadingFace], &[AmbientTerms]),
        rgb: &[f32],
    ) {
        let n = queue.count.min(BATCH_SIZE);
        // Whole registers: what is computed of the pairs beyond is not used.
        let m = n.next_multiple_of(REGISTER);
        let Self { groups, inputs, geometry, incident, .. } = self;
        gather_groups(queue, n, groups);
        gather_faces(variant, queue, n, faces, inputs);
        place_pairs(groups, queue, n, inputs);
        gather_ambient(variant, queue, n, ambient, inputs, incident);
        place_surfaces(inputs, m, camera, light.sky.sun_world, variant, geometry);
        self.occlude(light, camera.eye, variant, n);
        if variant.is_transparent {
            self.look_through(n, rgb);
            transparent(&self.inputs, &self.geometry, &self.incident, m, &light.sky, &mut self.outgoing);
            if light.night.is_some() {
                self.shine_through(light, camera, variant, m);
            }
            if light.snow_cover > 0.0 && variant.pattern != Pattern::Window {
                self.snow_on_panes(light, camera, variant, m);
            }
        } else {
            self.color(light, camera, variant, m);
            self.reflect(light, camera.eye, variant, m);
        }
        through_air(&self.geometry, &self.outgoing, m, light, variant, &mut self.arriving);
        resolve(&self.inputs, &self.base_color, &self.arriving, m, &mut self.radiance);
    }

    /// Where the left pixels' colors are added; the right ones' follow.
    pub fn targets(&self) -> &[u32; BATCH_STRIDE] {
        &self.inputs.target
    }

    /// Radiance that is added to the left and to the right pixels.
    pub fn radiance(&self) -> &[BatchVector; 2] {
        &self.radiance
    }

    /// Looks up shadow factors and contact occlusion.
    fn occlude(&mut self, light: &Light, eye: Vec3, variant: ShaderVariant, n: usize) {
        let (is_queried, pcf_texels) = (&mut self.is_queried, &mut self.pcf_texels);
        match &light.shadows {
            Some(shadows) if query_sun(&self.geometry, variant, n, is_queried) => {
                let query = ShadowQuery {
                    points: &self.geometry.point,
                    normals: &self.inputs.face_normal,
                    flags: &self.inputs.flags,
                    cos_sun: &self.geometry.cos_face,
                    is_queried,
                    count: n,
                };
                shadows.shadow_factors(eye, &query, pcf_texels, &mut self.incident.shadow_factor);
            }
            _ => self.incident.shadow_factor.fill(0.0),
        }
        query_contacts(&self.inputs.flags, n, is_queried);
        let factors = &mut self.incident.contact_occlusion;
        light.sky_probes.contacts.shade(eye, &self.geometry.point, is_queried, n, factors);
    }

    /// Takes what is behind transparent surfaces for their base color.
    fn look_through(&mut self, n: usize, rgb: &[f32]) {
        let [left, right] = &mut self.base_color;
        for (i, pixel) in self.inputs.background[..n].iter().enumerate() {
            if let Some([a, b, c, d, e, f]) = rgb[*pixel as usize * 3..].first_chunk() {
                put(left, i, Vec3::new(*a, *b, *c));
                put(right, i, Vec3::new(*d, *e, *f));
            }
        }
    }

    /// Finds the base color of opaque surfaces.
    fn color(&mut self, light: &Light, camera: &ShadingCamera, variant: ShaderVariant, m: usize) {
        let (inputs, geometry) = (&self.inputs, &self.geometry);
        for ((side, color), at) in PixelOfPair::BOTH.into_iter().zip(&mut self.base_color).zip(&mut self.texture) {
            if matches!(variant.pattern, Pattern::Plain | Pattern::Lamp | Pattern::Reflector) {
                *color = inputs.albedo;
            } else {
                place_texture(inputs, m, camera, variant, side, at);
                texture(inputs, geometry, at, m, variant.pattern, color);
            }
            if light.wetness > 0.0 {
                soak(inputs, geometry, m, light.wetness, color);
            }
            if light.snow_cover > 0.0 {
                lay_snow(inputs, geometry, m, camera, light.snow_cover, side, color);
            }
        }
    }

    /// Finds what opaque surfaces reflect.
    fn reflect(&mut self, light: &Light, eye: Vec3, variant: ShaderVariant, m: usize) {
        if !variant.is_flat() {
            ambient_of_normals(&self.geometry, m, &light.sky, &mut self.incident);
        }
        let (inputs, geometry, incident) = (&self.inputs, &self.geometry, &self.incident);
        let irradiance = &mut self.irradiance;
        diffuse(geometry, incident, m, light, variant, irradiance);
        let night = light.night.as_ref().filter(|_| !matches!(variant.pattern, Pattern::Lamp | Pattern::Window));
        if let Some(night) = night {
            let mirrored = &mut self.mirrored_lamps;
            add_lamp_light(inputs, geometry, incident, m, variant, night, light.wetness, eye, irradiance, mirrored);
        }
        if variant.is_glossy {
            specular(inputs, geometry, incident, irradiance, m, light, eye, &mut self.outgoing);
        } else {
            self.outgoing.diffuse = *irradiance;
            self.outgoing.specular = [[0.0; BATCH_STRIDE]; 3];
        }
        if night.is_some() && variant.is_glossy {
            add(&self.mirrored_lamps, m, &mut self.outgoing.specular);
        }
    }

    /// Lays snow on transparent surfaces: what is under it neither shows what is behind nor mirrors.
    fn snow_on_panes(&mut self, light: &Light, camera: &ShadingCamera, variant: ShaderVariant, m: usize) {
        if !variant.is_flat() {
            ambient_of_normals(&self.geometry, m, &light.sky, &mut self.incident);
        }
        let (inputs, geometry) = (&self.inputs, &self.geometry);
        diffuse(geometry, &self.incident, m, light, variant, &mut self.irradiance);
        snow_over(inputs, geometry, m, camera, light.snow_cover, &self.irradiance, &mut self.outgoing);
    }

    /// Adds what transparent surfaces mirror of lamps, and the light of rooms behind lit panes.
    fn shine_through(&mut self, light: &Light, camera: &ShadingCamera, variant: ShaderVariant, m: usize) {
        let (inputs, geometry, incident) = (&self.inputs, &self.geometry, &self.incident);
        if let Some(night) = &light.night {
            let (wetness, eye) = (light.wetness, camera.eye);
            let (lost, mirrored) = (&mut self.irradiance, &mut self.mirrored_lamps);
            add_lamp_light(inputs, geometry, incident, m, variant, night, wetness, eye, lost, mirrored);
            add(mirrored, m, &mut self.outgoing.specular);
        }
        if variant.pattern == Pattern::Window {
            let room = &mut self.irradiance;
            place_texture(inputs, m, camera, variant, PixelOfPair::Middle, &mut self.texture[0]);
            texture(inputs, geometry, &self.texture[0], m, variant.pattern, room);
            add(room, m, &mut self.outgoing.specular);
        }
    }
}

/// Adds light to other light.
fn add(light: &BatchVector, m: usize, to: &mut BatchVector) {
    for (to, from) in to.iter_mut().zip(light) {
        for (sum, value) in to[..m].iter_mut().zip(&from[..m]) {
            *sum += value;
        }
    }
}

/// Which of the first `n` pairs the sun may reach; true if there is any.
#[apply(for_wide_registers)]
fn query_sun(geometry: &SurfaceGeometry, variant: ShaderVariant, n: usize, out: &mut [bool; BATCH_STRIDE]) -> bool {
    let is_leaf = variant.pattern == Pattern::Leaves;
    let mut any = [0_u8; BATCH_SIZE];
    for i in 0..BATCH_SIZE {
        let faces_sun = (geometry.cos_face[i] > 0.0) & ((geometry.cos_sun[i] > 0.0) | variant.is_transparent);
        let is_queried = (i < n) & (is_leaf | faces_sun);
        out[i] = is_queried;
        any[i] = u8::from(is_queried);
    }
    any.into_iter().fold(0, |all, one| all | one) != 0
}

/// Which of the first `n` pairs vehicles may hide from the sky.
#[apply(for_wide_registers)]
fn query_contacts(flags: &[u32; BATCH_STRIDE], n: usize, out: &mut [bool; BATCH_STRIDE]) {
    for i in 0..BATCH_SIZE {
        out[i] = (i < n) & (flags[i] & Flags::CONTACT > 0);
    }
}
