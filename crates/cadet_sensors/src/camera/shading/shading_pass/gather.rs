//! Gathers what is known of a batch's pairs: of their groups, their faces, and the ambient light there.

use macro_rules_attribute::apply;

use super::super::ambient_cache::{AmbientTerms, PER_BLOCK};
use super::super::face::{ShaderVariant, ShadingFace};
use super::super::shading_queue::{
    BACKGROUND_STRIDE, BATCH_SIZE, BATCH_STRIDE, BatchScalar, PAIRS_ACROSS, PAIRS_DOWN, PixelPair, QueuedGroup,
    REGISTER, ShadingQueue,
};
use super::batch::{BatchVector, GroupValues, IncidentLight, SurfaceInputs};
use cadet_base::material::Pattern;
use cadet_base::math::Vec3;

/// Pairs that are filled together.
const RUN: usize = 8;
/// How far samples lie from the middle of their pixel's two, to both sides, pixels.
const SAMPLE_OFFSET_PX: f32 = 0.25;
/// The inverse depth of what is seen from its rim may be lost in rounding, 1/m.
const FARTHEST: f32 = 1e-6;

/// The pairs from `start` on; what it writes beyond a group's pairs the next group overwrites.
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
#[apply(for_wide_registers)]
pub fn gather_groups(queue: &ShadingQueue, n: usize, out: &mut GroupValues) {
    for (number, QueuedGroup { group, .. }) in queue.groups.iter().enumerate() {
        for i in queue.pairs_of(number, n).step_by(RUN) {
            run(&mut out.group, i, number as u32);
            run(&mut out.target, i, group.target);
            run(&mut out.stride, i, group.stride);
            run(&mut out.background, i, group.background);
            run(&mut out.weight, i, group.weight);
            run(&mut out.u, i, group.u);
            run(&mut out.v, i, group.v);
            run(&mut out.inverse_depth_per_m, i, group.inverse_depth_per_m[0]);
            run(&mut out.inverse_depth_by_column, i, group.inverse_depth_per_m[1]);
            run(&mut out.inverse_depth_by_row, i, group.inverse_depth_per_m[2]);
        }
    }
}

/// Where each pair lies within its block.
#[apply(for_wide_registers)]
pub fn place_pairs(groups: &GroupValues, queue: &ShadingQueue, n: usize, out: &mut SurfaceInputs) {
    let m = n.next_multiple_of(REGISTER).min(BATCH_SIZE);
    for i in 0..m {
        let pair = queue.pairs[i];
        let (column, row) = (2 * (pair & PixelPair::COLUMN), pair >> PixelPair::ROW_SHIFT & 3);
        let [a, b, c, d] = [0, 1, 2, 3].map(|k| (pair >> (PixelPair::SAMPLES_SHIFT + k) & 1) as i32 as f32);
        let (left, right) = (a + b, c + d);
        let inverse = 1.0 / (left + right);
        let slant = SAMPLE_OFFSET_PX * ((b + d) - (a + c)) * inverse;
        let across = column as i32 as f32 + right * inverse + slant;
        let down = row as i32 as f32 + slant;
        let by_column = groups.inverse_depth_by_column[i];
        let inverse_depth = groups.inverse_depth_per_m[i] + by_column * across + groups.inverse_depth_by_row[i] * down;
        out.inverse_depth_per_m[i] = if inverse_depth > FARTHEST { inverse_depth } else { FARTHEST };
        out.inverse_depth_by_column[i] = by_column;
        (out.u[i], out.v[i]) = (groups.u[i] + across, groups.v[i] + down);
        (out.across[i], out.down[i]) = (across * (1.0 / (2 * PAIRS_ACROSS) as f32), down * (1.0 / PAIRS_DOWN as f32));
        out.half_spacing[i] = if (left > 0.0) & (right > 0.0) { 0.5 } else { 0.0 };
        out.target[i] = groups.target[i].wrapping_add(row.wrapping_mul(groups.stride[i])).wrapping_add(column);
        out.background[i] = groups.background[i].wrapping_add(row * BACKGROUND_STRIDE + column);
        let half = 0.5 * groups.weight[i];
        (out.weights[0][i], out.weights[1][i]) = (left * half, right * half);
    }
    for i in 0..m {
        let (pair, next) = (queue.pairs[i], queue.pairs[i + 1]);
        let is_whole = pair >> PixelPair::SAMPLES_SHIFT == PixelPair::ALL;
        let is_next = (next == pair + 1)
            & (pair & PixelPair::COLUMN != PixelPair::COLUMN)
            & (groups.group[i] == groups.group[i + 1]);
        out.continues[i] = u32::from(is_whole & is_next & (i + 1 < n)).wrapping_neg();
    }
}

/// What the pairs' faces are like.
#[apply(for_wide_registers)]
pub fn gather_faces(
    variant: ShaderVariant,
    queue: &ShadingQueue,
    n: usize,
    faces: &[ShadingFace],
    out: &mut SurfaceInputs,
) {
    let (has_coat, is_leaf) = (variant.is_glossy || variant.is_transparent, variant.pattern == Pattern::Leaves);
    let has_axes = variant.pattern != Pattern::Plain && !is_leaf;
    for (number, QueuedGroup { group, .. }) in queue.groups.iter().enumerate() {
        let face = &faces[group.face as usize];
        for i in queue.pairs_of(number, n).step_by(RUN) {
            run3(&mut out.face_normal, i, face.face_normal);
            run3(&mut out.albedo, i, face.albedo);
            run(&mut out.flags, i, face.flags);
            if !variant.is_flat() {
                run3(&mut out.corner_normal, i, face.normal);
            }
            if variant.is_smooth {
                run3(&mut out.normal_ab, i, face.normal_ab);
                run3(&mut out.normal_ac, i, face.normal_ac);
                run3(&mut out.to_b, i, face.to_b);
                run3(&mut out.to_c, i, face.to_c);
                run(&mut out.weights_at_eye[0], i, face.weights_at_eye[0]);
                run(&mut out.weights_at_eye[1], i, face.weights_at_eye[1]);
                run(&mut out.least_weight, i, face.least_weight);
            }
            if has_axes {
                run3(&mut out.axis_u, i, face.axes[0]);
                run3(&mut out.axis_v, i, face.axes[1]);
            }
            if has_axes || is_leaf {
                run(&mut out.at_eye_m[0], i, face.at_eye_m[0]);
                run(&mut out.at_eye_m[1], i, face.at_eye_m[1]);
            }
            if is_leaf || variant.pattern == Pattern::Window {
                run(&mut out.face_hash, i, face.face_hash);
                run(&mut out.place_hash, i, face.place_hash);
            }
            if has_coat {
                run(&mut out.f0, i, face.f0);
                run(&mut out.roughness, i, face.roughness);
                run(&mut out.transmission, i, face.transmission);
            }
        }
    }
}

/// The sky visibility of the pairs and, of flat faces, the ambient irradiance.
#[apply(for_wide_registers)]
pub fn gather_ambient(
    variant: ShaderVariant,
    queue: &ShadingQueue,
    n: usize,
    ambient: &[AmbientTerms],
    inputs: &SurfaceInputs,
    out: &mut IncidentLight,
) {
    if variant.pattern == Pattern::Leaves {
        for (number, QueuedGroup { group, .. }) in queue.groups.iter().enumerate() {
            let of_group = ambient[group.ambient as usize];
            for i in queue.pairs_of(number, n).step_by(RUN) {
                for (values, o) in out.sky_visibility.iter_mut().zip(of_group) {
                    run(values, i, o);
                }
            }
        }
        return;
    }
    let mirrors = variant.is_glossy || variant.is_transparent;
    for (number, QueuedGroup { group, .. }) in queue.groups.iter().enumerate() {
        let Some(of_block) = ambient[group.ambient as usize..].first_chunk::<PER_BLOCK>() else { continue };
        for i in queue.pairs_of(number, n).step_by(RUN) {
            let (Some(across), Some(down)) = (inputs.across[i..].first_chunk(), inputs.down[i..].first_chunk()) else {
                continue;
            };
            let at = (across, down);
            if variant.is_flat() {
                for (k, values) in out.ambient.iter_mut().enumerate() {
                    run_between(values, i, of_block, k, at);
                }
                if mirrors {
                    for (k, values) in out.sky_visibility[..4].iter_mut().enumerate() {
                        run_between(values, i, of_block, 3 + k, at);
                    }
                }
            } else {
                for (k, values) in out.sky_visibility.iter_mut().enumerate() {
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
