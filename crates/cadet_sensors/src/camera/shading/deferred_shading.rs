//! Queues fragment groups by shader variant, shades full batches, and adds their colors to the picture.

use super::face::ShaderVariant;
use super::face_cache::FaceCache;
use super::shading_pass::{ShadingCamera, ShadingPass};
use super::shading_queue::{BACKGROUND_PIXELS, BATCH_SIZE, FragmentGroup, ShadingQueue};
use crate::camera::light::Light;
use crate::camera::visibility::CoverageMask;

/// Rows that are binned together.
pub(super) const BAND: usize = 8;

/// Shades the groups of a shader variant as soon as there are enough, and adds them to the picture.
pub(super) struct DeferredShader<'a> {
    /// By shader variant.
    pub queues: Vec<ShadingQueue>,
    pub pass: Box<ShadingPass>,
    pub light: &'a Light,
    pub camera: ShadingCamera,
    /// Where pixels begin that have what is seen through transparent surfaces, and how many there are.
    pub first_background: usize,
    pub background: usize,
    pub rgb: &'a mut [f32],
}

impl DeferredShader<'_> {
    /// Empties some rows' pixels and those behind transparent surfaces.
    pub fn clear(&mut self, pixels: std::ops::Range<usize>) {
        self.rgb[pixels.start * 3..pixels.end * 3].fill(0.0);
        self.background = 0;
    }

    /// The first of [`BACKGROUND_PIXELS`] black pixels for what is seen through a block's transparent surfaces.
    pub fn new_background(&mut self) -> u32 {
        let first = self.first_background + self.background;
        self.background += BACKGROUND_PIXELS;
        self.rgb[first * 3..(first + BACKGROUND_PIXELS) * 3].fill(0.0);
        first as u32
    }

    /// Colors of some pixels in a row.
    #[inline]
    pub fn row(&mut self, first: usize, count: usize) -> &mut [f32] {
        &mut self.rgb[first * 3..(first + count) * 3]
    }

    /// Adds a color to a pixel.
    #[inline]
    pub fn add(&mut self, pixel: u32, weight: f32, color: [f32; 3]) {
        let at = pixel as usize * 3;
        for (sum, c) in self.rgb[at..at + 3].iter_mut().zip(color) {
            *sum += weight * c;
        }
    }

    /// What a face shows in a block. What is behind a transparent surface must be shaded.
    #[inline]
    pub fn push(&mut self, faces: &FaceCache, variant: u32, group: &FragmentGroup, samples: CoverageMask) {
        let queue = &mut self.queues[variant as usize];
        queue.push(group, samples);
        if queue.is_full() {
            self.shade(faces, variant as usize);
        }
    }

    /// Shades all that waits.
    pub fn shade_all(&mut self, faces: &FaceCache) {
        for variant in 0..self.queues.len() {
            self.shade(faces, variant);
        }
    }

    #[inline(never)]
    fn shade(&mut self, faces: &FaceCache, variant: usize) {
        let queue = &mut self.queues[variant];
        if queue.count == 0 {
            return;
        }
        let known = (faces.faces.as_slice(), faces.ambient.terms.as_slice());
        self.pass.shade(self.light, &self.camera, ShaderVariant::of(variant), queue, known, self.rgb);
        let n = queue.count.min(BATCH_SIZE);
        queue.clear();
        let [left, right] = self.pass.radiance();
        for (i, pixel) in self.pass.targets()[..n].iter().enumerate() {
            if let Some(pixels) = self.rgb[*pixel as usize * 3..].first_chunk_mut::<6>() {
                let added = [left[0][i], left[1][i], left[2][i], right[0][i], right[1][i], right[2][i]];
                for k in 0..6 {
                    pixels[k] += added[k];
                }
            }
        }
    }
}
