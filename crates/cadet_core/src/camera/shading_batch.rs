//! Hits of one shader variant that are shaded together, as a structure of arrays: what is known of them, and what is found.

use super::hits::{Lane, STRIDE};
use super::shadow::Neighbours;
use crate::math::Vec3;

/// The same for all hits of an image.
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

pub type Lane3 = [Lane; 3];

/// Pairs of pixels that show faces of one shader variant, lane by lane; each variant fills what it needs. Two of a thing are of the left
/// pixel and of the right one.
pub struct ShadingBatch {
    /// Number of the patch; see [`Hits::patches`].
    pub patch: [u32; STRIDE],
    /// The left pixel: where its color is added. At first the block's first pixel.
    pub target: [u32; STRIDE],
    /// From a pixel of the target to the one below.
    pub stride: [u32; STRIDE],
    /// The left pixel, where what is seen through a transparent surface is kept. At first that of the block's first pixel.
    pub behind: [u32; STRIDE],
    /// What the pixels' colors count.
    pub weights: [Lane; 2],
    /// The middle of the samples that show the face. At first the block's first pixel; so is the inverse depth.
    pub u: Lane,
    pub v: Lane,
    /// 1 / z, 1/m.
    pub inverse_depth: Lane,
    pub inverse_depth_by_column: Lane,
    pub inverse_depth_by_row: Lane,
    /// Where it lies in its block, from 0 at the first corner to 1 at the last.
    pub across: Lane,
    pub down: Lane,
    /// From the middle to the right pixel, columns, where both pixels show the face; else 0.
    pub aside: Lane,
    /// All bits where the next lane has the next pair of pixels, and both are whole.
    pub goes_on: [u32; STRIDE],
    pub face_normal: Lane3,
    pub axis_u: Lane3,
    pub axis_v: Lane3,
    pub at_eye: [Lane; 2],
    pub normal_ab: Lane3,
    pub normal_ac: Lane3,
    pub to_b: Lane3,
    pub to_c: Lane3,
    pub weights_at_eye: [Lane; 2],
    pub least_weight: Lane,
    pub specular: Lane,
    pub roughness: Lane,
    pub transmission: Lane,
    pub face_hash: [u32; STRIDE],
    pub place_hash: [u32; STRIDE],
    pub flags: [u32; STRIDE],
    /// The sky's visibility towards the six half axes; flat faces know four of them.
    pub open: [Lane; 6],
    /// Light from all around, without what cars near by hide.
    pub around: Lane3,
    /// Unit vectors from the eye.
    pub view: Lane3,
    /// Relative to the eye.
    pub point: Lane3,
    pub distance_m: Lane,
    /// Geometric mean of a pixel's extents on the surface, and its width square to the view.
    pub footprint_m: Lane,
    pub pixel_m: Lane,
    /// Coordinates of the texture.
    pub texture: [[Lane; 2]; 2],
    /// At first of the first corner, then the unit shading normal.
    pub normal: Lane3,
    pub cos_sun: Lane,
    pub cos_face: Lane,
    pub is_asked: [bool; STRIDE],
    pub neighbours: Neighbours<STRIDE>,
    pub lit: Lane,
    pub near: Lane,
    /// Of the material.
    pub material: Lane3,
    /// Of the place.
    pub albedo: [Lane3; 2],
    /// What arrives at the camera if the albedo is one.
    pub matt: Lane3,
    /// What arrives whatever the albedo is: from mirrors and from the air.
    pub sheen: Lane3,
    /// The radiance that arrives at the camera.
    pub out: [Lane3; 2],
}

#[inline(always)]
pub fn get<const N: usize>(lanes: &[[f32; N]; 3], i: usize) -> Vec3 {
    Vec3::new(lanes[0][i], lanes[1][i], lanes[2][i])
}

#[inline(always)]
pub fn put<const N: usize>(lanes: &mut [[f32; N]; 3], i: usize, v: Vec3) {
    (lanes[0][i], lanes[1][i], lanes[2][i]) = (v.x, v.y, v.z);
}

impl Default for ShadingBatch {
    fn default() -> Self {
        const O: Lane = [0.0; STRIDE];
        const O3: Lane3 = [O; 3];
        Self {
            patch: [0; STRIDE],
            target: [0; STRIDE],
            stride: [0; STRIDE],
            behind: [0; STRIDE],
            weights: [O; 2],
            u: O,
            v: O,
            inverse_depth: O,
            inverse_depth_by_column: O,
            inverse_depth_by_row: O,
            across: O,
            down: O,
            aside: O,
            goes_on: [0; STRIDE],
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
            specular: O,
            roughness: O,
            transmission: O,
            face_hash: [0; STRIDE],
            place_hash: [0; STRIDE],
            flags: [0; STRIDE],
            open: [O; 6],
            around: O3,
            view: O3,
            point: O3,
            distance_m: O,
            footprint_m: O,
            pixel_m: O,
            texture: [[O; 2]; 2],
            normal: O3,
            cos_sun: O,
            cos_face: O,
            is_asked: [false; STRIDE],
            neighbours: Neighbours::default(),
            lit: O,
            near: O,
            material: O3,
            albedo: [O3; 2],
            matt: O3,
            sheen: O3,
            out: [O3; 2],
        }
    }
}
