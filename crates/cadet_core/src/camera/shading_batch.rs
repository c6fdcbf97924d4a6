//! Pairs of pixels of one shader variant that are shaded together, as a structure of arrays: what is known of them, and what
//! is found.

use super::shading_queue::{BATCH_STRIDE, BatchScalar};
use super::shadow::PcfTexels;
use crate::math::Vec3;

/// The same for all pairs of an image.
#[derive(Debug, Clone, Copy)]
pub struct ShadingCamera {
    /// World coordinates.
    pub eye: Vec3,
    /// Directions of image points, of length 1 along the optical axis: `corner + right * u + down * v`.
    pub corner: Vec3,
    /// See `corner`.
    pub right: Vec3,
    /// See `corner`.
    pub down: Vec3,
    /// Size of a pixel at 1 m.
    pub pixel_per_m: f32,
}

pub type BatchVector = [BatchScalar; 3];

/// Pairs of pixels that show faces of one shader variant; each variant fills what it needs. Two of a thing are of the left
/// pixel and of the right one.
pub struct ShadingBatch {
    /// Number of the group; see [`ShadingQueue::groups`].
    pub group: [u32; BATCH_STRIDE],
    /// The left pixel: where its color is added. At first the block's first pixel.
    pub target: [u32; BATCH_STRIDE],
    /// From a pixel of the target to the one below.
    pub stride: [u32; BATCH_STRIDE],
    /// The left pixel, where what is seen through a transparent surface is kept. At first that of the block's first pixel.
    pub background: [u32; BATCH_STRIDE],
    /// What the pixels' colors count.
    pub weights: [BatchScalar; 2],
    /// The middle of the samples that show the face. At first the block's first pixel; so is the inverse depth.
    pub u: BatchScalar,
    pub v: BatchScalar,
    /// 1 / z, 1/m.
    pub inverse_depth: BatchScalar,
    pub inverse_depth_by_column: BatchScalar,
    pub inverse_depth_by_row: BatchScalar,
    /// Where it lies in its block, from 0 at the first corner to 1 at the last.
    pub across: BatchScalar,
    pub down: BatchScalar,
    /// From the middle to the right pixel, columns, where both pixels show the face; else 0.
    pub aside: BatchScalar,
    /// All bits where the next of the batch is the next pair of its row, and both are whole.
    pub goes_on: [u32; BATCH_STRIDE],
    pub face_normal: BatchVector,
    pub axis_u: BatchVector,
    pub axis_v: BatchVector,
    pub at_eye: [BatchScalar; 2],
    pub normal_ab: BatchVector,
    pub normal_ac: BatchVector,
    pub to_b: BatchVector,
    pub to_c: BatchVector,
    pub weights_at_eye: [BatchScalar; 2],
    pub least_weight: BatchScalar,
    pub f0: BatchScalar,
    pub roughness: BatchScalar,
    pub transmission: BatchScalar,
    pub face_hash: [u32; BATCH_STRIDE],
    pub place_hash: [u32; BATCH_STRIDE],
    pub flags: [u32; BATCH_STRIDE],
    /// The sky visibility towards the six half axes; flat faces know four of them.
    pub sky_visibility: [BatchScalar; 6],
    /// Ambient irradiance, without contact occlusion.
    pub ambient: BatchVector,
    /// Unit vectors from the eye.
    pub view: BatchVector,
    /// Relative to the eye.
    pub point: BatchVector,
    pub distance_m: BatchScalar,
    /// Geometric mean of a pixel's extents on the surface, and its width square to the view.
    pub footprint_m: BatchScalar,
    pub pixel_m: BatchScalar,
    /// Coordinates of the texture.
    pub texture: [[BatchScalar; 2]; 2],
    /// At first of the first corner, then the unit shading normal.
    pub normal: BatchVector,
    pub cos_sun: BatchScalar,
    pub cos_face: BatchScalar,
    pub is_queried: [bool; BATCH_STRIDE],
    pub pcf_texels: PcfTexels<BATCH_STRIDE>,
    pub shadow_factor: BatchScalar,
    pub contact_occlusion: BatchScalar,
    /// Of the material.
    pub material: BatchVector,
    /// Of the place.
    pub albedo: [BatchVector; 2],
    /// What arrives at the camera if the albedo is one.
    pub diffuse: BatchVector,
    /// What arrives whatever the albedo is: specular reflection and in-scattered light.
    pub specular: BatchVector,
    /// The radiance that arrives at the camera.
    pub out: [BatchVector; 2],
}

#[inline(always)]
pub fn get<const N: usize>(values: &[[f32; N]; 3], i: usize) -> Vec3 {
    Vec3::new(values[0][i], values[1][i], values[2][i])
}

#[inline(always)]
pub fn put<const N: usize>(values: &mut [[f32; N]; 3], i: usize, v: Vec3) {
    (values[0][i], values[1][i], values[2][i]) = (v.x, v.y, v.z);
}

impl Default for ShadingBatch {
    fn default() -> Self {
        const O: BatchScalar = [0.0; BATCH_STRIDE];
        const O3: BatchVector = [O; 3];
        Self {
            group: [0; BATCH_STRIDE],
            target: [0; BATCH_STRIDE],
            stride: [0; BATCH_STRIDE],
            background: [0; BATCH_STRIDE],
            weights: [O; 2],
            u: O,
            v: O,
            inverse_depth: O,
            inverse_depth_by_column: O,
            inverse_depth_by_row: O,
            across: O,
            down: O,
            aside: O,
            goes_on: [0; BATCH_STRIDE],
            face_normal: O3,
            axis_u: O3,
            axis_v: O3,
            at_eye: [O; 2],
            normal_ab: O3,
            normal_ac: O3,
            to_b: O3,
            to_c: O3,
            weights_at_eye: [O; 2],
            least_weight: O,
            f0: O,
            roughness: O,
            transmission: O,
            face_hash: [0; BATCH_STRIDE],
            place_hash: [0; BATCH_STRIDE],
            flags: [0; BATCH_STRIDE],
            sky_visibility: [O; 6],
            ambient: O3,
            view: O3,
            point: O3,
            distance_m: O,
            footprint_m: O,
            pixel_m: O,
            texture: [[O; 2]; 2],
            normal: O3,
            cos_sun: O,
            cos_face: O,
            is_queried: [false; BATCH_STRIDE],
            pcf_texels: PcfTexels::default(),
            shadow_factor: O,
            contact_occlusion: O,
            material: O3,
            albedo: [O3; 2],
            diffuse: O3,
            specular: O3,
            out: [O3; 2],
        }
    }
}
