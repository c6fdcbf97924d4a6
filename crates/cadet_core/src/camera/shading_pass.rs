//! The shading pass of a batch: it gathers what is known of its pairs, and shades them.

use multiversion::multiversion;

use super::ambient_cache::{AmbientTerms, PER_BLOCK};
use super::face::{Face, Flags, ShaderVariant};
use super::light::Light;
use super::shade::{diffuse, geometry, place_texture, resolve, snow, specular, texture, through_air, transparent};
use super::shading_batch::{BatchVector, ShadingBatch, ShadingCamera, put};
use super::shading_queue::{
    BACKGROUND_STRIDE, BATCH_SIZE, BATCH_STRIDE, BatchScalar, PAIRS_ACROSS, PAIRS_DOWN, PixelPair, ShadingQueue,
};
use super::shadow::ShadowQuery;
use crate::material::Pattern;
use crate::math::Vec3;

/// Pairs that are filled together.
const RUN: usize = 8;

impl ShadingBatch {
    /// Shades groups of a shader variant; the outcome is in `out`, where it belongs in `target` and `weights`.
    ///
    /// `rgb`: the picture, where transparent surfaces find what is behind them.
    pub fn shade(
        &mut self,
        light: &Light,
        camera: &ShadingCamera,
        variant: ShaderVariant,
        queue: &ShadingQueue,
        (faces, ambient): (&[Face], &[AmbientTerms]),
        rgb: &[f32],
    ) {
        let n = queue.count.min(BATCH_SIZE);
        gather_groups(self, queue, n);
        gather_faces(self, variant, queue, n, faces);
        // Whole registers: what is left in the pairs beyond is nobody's.
        let m = n.next_multiple_of(16);
        spread(self, queue, n);
        gather_ambient(self, variant, queue, n, ambient);
        geometry(self, m, camera, light.sky.sun_world, variant);
        self.cast_shadows(light, camera.eye, variant, n);
        self.albedo = [self.material; 2];
        if variant.is_transparent {
            for (i, pixel) in self.background[..n].iter().enumerate() {
                if let Some([a, b, c, d, e, f]) = rgb[*pixel as usize * 3..].first_chunk() {
                    put(&mut self.albedo[0], i, Vec3::new(*a, *b, *c));
                    put(&mut self.albedo[1], i, Vec3::new(*d, *e, *f));
                }
            }
            transparent(self, m, &light.sky);
        } else {
            for pixel in 0..2 {
                if variant.pattern != Pattern::Plain {
                    place_texture(self, m, camera, variant, pixel);
                    texture(self, m, variant.pattern, pixel);
                }
                if light.snow > 0.0 {
                    snow(self, m, camera, light.snow, pixel);
                }
            }
            diffuse(self, m, &light.sky, variant, light.wetness);
            if variant.is_glossy {
                specular(self, m, &light.sky, camera.eye, light.wetness);
            }
        }
        through_air(self, m, light);
        resolve(self, m);
    }

    /// Looks up shadow factors and contact occlusion.
    fn cast_shadows(&mut self, light: &Light, eye: Vec3, variant: ShaderVariant, n: usize) {
        match &light.shadows {
            Some(shadows) if ask_sun(self, variant, n) => {
                let query = ShadowQuery {
                    points: &self.point,
                    normals: &self.face_normal,
                    cos_sun: &self.cos_face,
                    is_queried: &self.is_queried,
                    count: n,
                };
                shadows.shadow_factors(eye, &query, &mut self.pcf_texels, &mut self.shadow_factor);
            }
            _ => self.shadow_factor.fill(0.0),
        }
        ask_contacts(self, n);
        light.sky_probes.contacts.shade(eye, &self.point, &self.is_queried, n, &mut self.contact_occlusion);
    }
}

/// Asks for what the sun sees of the first `n` pairs; true if there is any.
#[multiversion(targets("x86_64+avx512f+avx512bw+avx512dq+avx512vl", "x86_64+avx2"))]
fn ask_sun(l: &mut ShadingBatch, variant: ShaderVariant, n: usize) -> bool {
    let is_leaf = variant.pattern == Pattern::Leaves;
    let mut any = [0_u8; BATCH_SIZE];
    for i in 0..BATCH_SIZE {
        let faces_sun = (l.cos_face[i] > 0.0) & ((l.cos_sun[i] > 0.0) | variant.is_transparent);
        let is_queried = (i < n) & (is_leaf | faces_sun);
        l.is_queried[i] = is_queried;
        any[i] = u8::from(is_queried);
    }
    any.into_iter().fold(0, |all, one| all | one) != 0
}

/// Asks for what vehicles leave of the sky to the first `n` pairs.
#[multiversion(targets("x86_64+avx512f+avx512bw+avx512dq+avx512vl", "x86_64+avx2"))]
fn ask_contacts(l: &mut ShadingBatch, n: usize) {
    for i in 0..BATCH_SIZE {
        l.is_queried[i] = (i < n) & (l.flags[i] & Flags::CONTACT > 0);
    }
}

/// The pairs from `start` on; those that are nobody's yet are filled again when their turn comes.
#[inline(always)]
fn run<T: Copy>(values: &mut [T; BATCH_STRIDE], start: usize, value: T) {
    if let Some(run) = values[start..].first_chunk_mut() {
        *run = [value; RUN];
    }
}

#[inline(always)]
fn run3(values: &mut BatchVector, start: usize, value: Vec3) {
    let [x, y, z] = values;
    run(x, start, value.x);
    run(y, start, value.y);
    run(z, start, value.z);
}

/// What pairs share with their group.
#[multiversion(targets("x86_64+avx512f+avx512bw+avx512dq+avx512vl", "x86_64+avx2"))]
fn gather_groups(l: &mut ShadingBatch, queue: &ShadingQueue, n: usize) {
    for (number, (_, group)) in queue.groups.iter().enumerate() {
        for i in queue.pairs_of(number, n).step_by(RUN) {
            run(&mut l.group, i, number as u32);
            run(&mut l.target, i, group.target);
            run(&mut l.stride, i, group.stride);
            run(&mut l.background, i, group.background);
            run(&mut l.weights[0], i, group.weight);
            run(&mut l.u, i, group.u);
            run(&mut l.v, i, group.v);
            run(&mut l.inverse_depth, i, group.inverse_depth[0]);
            run(&mut l.inverse_depth_by_column, i, group.inverse_depth[1]);
            run(&mut l.inverse_depth_by_row, i, group.inverse_depth[2]);
        }
    }
}

/// Where each pair lies within its block.
#[multiversion(targets("x86_64+avx512f+avx512bw+avx512dq+avx512vl", "x86_64+avx2"))]
fn spread(l: &mut ShadingBatch, queue: &ShadingQueue, n: usize) {
    let m = n.next_multiple_of(16).min(BATCH_SIZE);
    for i in 0..m {
        let pair = queue.pairs[i];
        let (column, row) = (2 * (pair & PixelPair::COLUMN), pair >> PixelPair::ROW_SHIFT & 3);
        let [a, b, c, d] = [0, 1, 2, 3].map(|k| (pair >> (PixelPair::SAMPLES_SHIFT + k) & 1) as i32 as f32);
        let (left, right) = (a + b, c + d);
        let inverse = 1.0 / (left + right);
        // Samples lie a quarter of a pixel from the middle of their pixel's two, to both sides.
        let slant = 0.25 * ((b + d) - (a + c)) * inverse;
        let across = column as i32 as f32 + right * inverse + slant;
        let down = row as i32 as f32 + slant;
        let inverse_depth =
            l.inverse_depth[i] + l.inverse_depth_by_column[i] * across + l.inverse_depth_by_row[i] * down;
        l.inverse_depth[i] = if inverse_depth > FARTHEST { inverse_depth } else { FARTHEST };
        (l.u[i], l.v[i]) = (l.u[i] + across, l.v[i] + down);
        (l.across[i], l.down[i]) = (across * (1.0 / (2 * PAIRS_ACROSS) as f32), down * (1.0 / PAIRS_DOWN as f32));
        l.aside[i] = if (left > 0.0) & (right > 0.0) { 0.5 } else { 0.0 };
        l.target[i] = l.target[i].wrapping_add(row.wrapping_mul(l.stride[i])).wrapping_add(column);
        l.background[i] = l.background[i].wrapping_add(row * BACKGROUND_STRIDE + column);
        let half = 0.5 * l.weights[0][i];
        (l.weights[0][i], l.weights[1][i]) = (left * half, right * half);
    }
    for i in 0..m {
        let (pair, next) = (queue.pairs[i], queue.pairs[i + 1]);
        let is_whole = pair >> PixelPair::SAMPLES_SHIFT == PixelPair::ALL;
        let is_next =
            (next == pair + 1) & (pair & PixelPair::COLUMN != PixelPair::COLUMN) & (l.group[i] == l.group[i + 1]);
        l.goes_on[i] = u32::from(is_whole & is_next & (i + 1 < n)).wrapping_neg();
    }
}

/// The inverse depth of what is seen from its rim may be lost in rounding, 1/m.
const FARTHEST: f32 = 1e-6;

#[multiversion(targets("x86_64+avx512f+avx512bw+avx512dq+avx512vl", "x86_64+avx2"))]
fn gather_faces(l: &mut ShadingBatch, variant: ShaderVariant, queue: &ShadingQueue, n: usize, faces: &[Face]) {
    let (has_coat, is_leaf) = (variant.is_glossy || variant.is_transparent, variant.pattern == Pattern::Leaves);
    let has_axes = variant.pattern != Pattern::Plain && !is_leaf;
    for (number, (_, group)) in queue.groups.iter().enumerate() {
        let face = &faces[group.face as usize];
        for i in queue.pairs_of(number, n).step_by(RUN) {
            run3(&mut l.face_normal, i, face.face_normal);
            run3(&mut l.material, i, face.albedo);
            run(&mut l.flags, i, face.flags);
            if !variant.is_flat() {
                run3(&mut l.normal, i, face.normal);
            }
            if variant.is_smooth {
                run3(&mut l.normal_ab, i, face.normal_ab);
                run3(&mut l.normal_ac, i, face.normal_ac);
                run3(&mut l.to_b, i, face.to_b);
                run3(&mut l.to_c, i, face.to_c);
                run(&mut l.weights_at_eye[0], i, face.weights_at_eye[0]);
                run(&mut l.weights_at_eye[1], i, face.weights_at_eye[1]);
                run(&mut l.least_weight, i, face.least_weight);
            }
            if has_axes {
                run3(&mut l.axis_u, i, face.axes[0]);
                run3(&mut l.axis_v, i, face.axes[1]);
            }
            if has_axes || is_leaf {
                run(&mut l.at_eye[0], i, face.at_eye[0]);
                run(&mut l.at_eye[1], i, face.at_eye[1]);
            }
            if is_leaf {
                run(&mut l.face_hash, i, face.face_hash);
                run(&mut l.place_hash, i, face.place_hash);
            }
            if has_coat {
                run(&mut l.f0, i, face.f0);
                run(&mut l.roughness, i, face.roughness);
                run(&mut l.transmission, i, face.transmission);
            }
        }
    }
}

#[multiversion(targets("x86_64+avx512f+avx512bw+avx512dq+avx512vl", "x86_64+avx2"))]
fn gather_ambient(
    l: &mut ShadingBatch,
    variant: ShaderVariant,
    queue: &ShadingQueue,
    n: usize,
    ambient: &[AmbientTerms],
) {
    if variant.pattern == Pattern::Leaves {
        for (number, (_, group)) in queue.groups.iter().enumerate() {
            let of_group = ambient[group.ambient as usize];
            for i in queue.pairs_of(number, n).step_by(RUN) {
                for (values, o) in l.sky_visibility.iter_mut().zip(of_group) {
                    run(values, i, o);
                }
            }
        }
        return;
    }
    let mirrors = variant.is_glossy || variant.is_transparent;
    for (number, (_, group)) in queue.groups.iter().enumerate() {
        let Some(of_block) = ambient[group.ambient as usize..].first_chunk::<PER_BLOCK>() else { continue };
        for i in queue.pairs_of(number, n).step_by(RUN) {
            let (Some(across), Some(down)) = (l.across[i..].first_chunk(), l.down[i..].first_chunk()) else { continue };
            let at = (across, down);
            if variant.is_flat() {
                for (k, values) in l.ambient.iter_mut().enumerate() {
                    run_between(values, i, of_block, k, at);
                }
                if mirrors {
                    for (k, values) in l.sky_visibility[..4].iter_mut().enumerate() {
                        run_between(values, i, of_block, 3 + k, at);
                    }
                }
            } else {
                for (k, values) in l.sky_visibility.iter_mut().enumerate() {
                    run_between(values, i, of_block, k, at);
                }
            }
        }
    }
}

/// As [`run`], of what changes evenly from corner to corner of a block.
#[inline(always)]
fn run_between(
    values: &mut BatchScalar,
    start: usize,
    [first, rightwards, downwards, both]: &[AmbientTerms; PER_BLOCK],
    k: usize,
    (across, down): (&[f32; RUN], &[f32; RUN]),
) {
    if let Some(run) = values[start..].first_chunk_mut::<RUN>() {
        for i in 0..RUN {
            let left = first[k] + downwards[k] * down[i];
            run[i] = left + (rightwards[k] + both[k] * down[i]) * across[i];
        }
    }
}
