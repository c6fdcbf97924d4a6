//! The radiance of every pixel: fragments are binned by shader variant, band by band of rows, and shaded in batches.

use super::deferred_shading::{BAND, DeferredShader};
use super::face::ShaderVariant;
use super::face_cache::FaceCache;
use super::fragment_binning::FragmentBinner;
use super::shading_pass::ShadingCamera;
use super::shading_queue::ShadingQueue;
use crate::camera::light::Light;
use crate::camera::visibility::{ImageRays, Samples, View};
use crate::sense::{BLOCK, PosedScene};

/// Values that [`radiance_pass`] needs room for: those of the image, of what lies behind a band's transparent surfaces, and
/// of the pixel after the last.
pub fn room_for(width: usize, height: usize) -> usize {
    (height * width + width.div_ceil(BLOCK) * BLOCK * BAND + 1) * 3
}

/// Linear radiance of every pixel, interleaved RGB, into `rgb`, which has room for more; see [`room_for`].
pub fn radiance_pass(
    scene: &PosedScene,
    view: &View,
    rays: &ImageRays,
    light: &Light,
    samples: &Samples,
    rgb: &mut [f32],
) {
    let (width, height) = (view.width, view.height);
    let image = width * height;
    let shader = DeferredShader {
        queues: vec![ShadingQueue::NONE; ShaderVariant::COUNT],
        pass: Box::default(),
        light,
        camera: ShadingCamera {
            eye: rays.eye,
            corner: rays.direction(0.0, 0.0),
            right: rays.right,
            down: rays.down,
            pixel_per_m: 1.0 / view.intrinsics_px[0] as f32,
        },
        first_background: image,
        background: 0,
        rgb,
    };
    let faces = FaceCache::new(scene, view, rays, light, &samples.0);
    let mut binner = FragmentBinner::new(&samples.0, faces, shader, view, rays, light);
    for first_row in (0..height).step_by(BAND) {
        binner.shade_band(first_row, (height - first_row).min(BAND));
    }
    binner.finish();
}
