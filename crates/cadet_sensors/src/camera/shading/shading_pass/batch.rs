//! What the steps of the shading pass hand on, for the pairs of pixels of one batch: structures of arrays.
//!
//! Each shader variant fills what it needs. Two of a thing are of the left pixel and of the right one.

use macro_rules_attribute::derive;

use super::super::shading_queue::{BATCH_STRIDE, BatchScalar};
use crate::zeros::DefaultZeros;
use cadet_base::math::Vec3;

/// Values of the camera that all pairs of an image share.
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

/// What pairs share with their fragment group: gathered first, read by [`super::gather::place_pairs`] alone.
#[derive(DefaultZeros!)]
pub struct GroupValues {
    /// Number of the group; see [`ShadingQueue::groups`].
    ///
    /// [`ShadingQueue::groups`]: super::super::shading_queue::ShadingQueue::groups
    pub group: [u32; BATCH_STRIDE],
    /// Of the block's first pixel: where its color is added.
    pub target: [u32; BATCH_STRIDE],
    /// From a pixel of the target to the one below.
    pub stride: [u32; BATCH_STRIDE],
    /// Of the block's first pixel: where what is seen through a transparent surface is kept.
    pub background: [u32; BATCH_STRIDE],
    /// What a pixel's color counts, if both samples show the face.
    pub weight: BatchScalar,
    /// Image point of the block's first pixel.
    pub u: BatchScalar,
    pub v: BatchScalar,
    /// 1 / z there, 1/m, and its changes.
    pub inverse_depth_per_m: BatchScalar,
    pub inverse_depth_by_column: BatchScalar,
    pub inverse_depth_by_row: BatchScalar,
}

/// Where the pairs lie, and the faces that they show.
#[derive(DefaultZeros!)]
pub struct SurfaceInputs {
    /// The left pixel: where its color is added.
    pub target: [u32; BATCH_STRIDE],
    /// The left pixel: where what is seen through a transparent surface is kept.
    pub background: [u32; BATCH_STRIDE],
    /// What the pixels' colors count.
    pub weights: [BatchScalar; 2],
    /// The middle of the samples that show the face: image point, and 1 / z there, 1/m.
    pub u: BatchScalar,
    pub v: BatchScalar,
    pub inverse_depth_per_m: BatchScalar,
    pub inverse_depth_by_column: BatchScalar,
    /// Where it lies in its block, from 0 at the first corner to 1 at the last.
    pub across: BatchScalar,
    pub down: BatchScalar,
    /// From the middle to the right pixel, columns, where both pixels show the face; else 0.
    pub half_spacing: BatchScalar,
    /// All bits where the next of the batch is the next pair of its row, and both are whole.
    pub continues: [u32; BATCH_STRIDE],
    pub face_normal: BatchVector,
    /// Axes of the texture, and its coordinates at the eye.
    pub axis_u: BatchVector,
    pub axis_v: BatchVector,
    pub at_eye_m: [BatchScalar; 2],
    /// The shading normal in the first corner, and its changes to the others.
    pub corner_normal: BatchVector,
    pub normal_ab: BatchVector,
    pub normal_ac: BatchVector,
    /// See [`ShadingFace`](super::super::face::ShadingFace).
    pub to_b: BatchVector,
    pub to_c: BatchVector,
    pub weights_at_eye: [BatchScalar; 2],
    pub least_weight: BatchScalar,
    /// Of the material.
    pub albedo: BatchVector,
    pub f0: BatchScalar,
    pub roughness: BatchScalar,
    pub transmission: BatchScalar,
    pub face_hash: [u32; BATCH_STRIDE],
    pub place_hash: [u32; BATCH_STRIDE],
    pub flags: [u32; BATCH_STRIDE],
}

/// Where the pairs' surfaces lie, and how they stand to eye and sun.
#[derive(DefaultZeros!)]
pub struct SurfaceGeometry {
    /// Unit vectors from the eye.
    pub view: BatchVector,
    /// Relative to the eye.
    pub point: BatchVector,
    pub distance_m: BatchScalar,
    /// Geometric mean of a pixel's extents on the surface, and its width square to the view; not of plain faces.
    pub footprint_m: BatchScalar,
    pub pixel_m: BatchScalar,
    /// Unit shading normal.
    pub normal: BatchVector,
    /// Cosines of the shading and of the face's normal to the sun.
    pub cos_sun: BatchScalar,
    pub cos_face: BatchScalar,
}

/// What light reaches the surfaces.
#[derive(DefaultZeros!)]
pub struct IncidentLight {
    /// The sky visibility towards the six half axes; flat faces know four of them.
    pub sky_visibility: [BatchScalar; 6],
    /// Ambient irradiance, without contact occlusion.
    pub ambient: BatchVector,
    /// Share of the sun's light.
    pub shadow_factor: BatchScalar,
    /// Share of the sky's light that vehicles and people leave.
    pub contact_occlusion: BatchScalar,
}

/// Light that goes from the surfaces to the camera.
#[derive(DefaultZeros!)]
pub struct OutgoingLight {
    /// To be multiplied with the base color.
    pub diffuse: BatchVector,
    /// Whatever the base color is.
    pub specular: BatchVector,
}

#[inline(always)]
pub fn get<const N: usize>(values: &[[f32; N]; 3], i: usize) -> Vec3 {
    Vec3::new(values[0][i], values[1][i], values[2][i])
}

#[inline(always)]
pub fn put<const N: usize>(values: &mut [[f32; N]; 3], i: usize, v: Vec3) {
    (values[0][i], values[1][i], values[2][i]) = (v.x, v.y, v.z);
}
