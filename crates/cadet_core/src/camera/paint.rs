//! Gives what the camera's samples meet its colour: it is collected by kind, band by band of rows, and shaded together.

use super::collect::Collector;
use super::face::Kind;
use super::faces::Faces;
use super::hits::{BEHIND, Hits, LANES, Patch, SampleBits};
use super::lanes::Lanes;
use super::look::{Rays, Samples, View};
use super::shade::{Camera, Light};
use crate::sense::{BLOCK, PosedScene};

/// Rows that are collected together.
pub(super) const BAND: usize = 8;

/// Values that [`paint`] needs room for: those of the image, and of what lies behind the panes of a band; and of the pixel
/// after the last.
pub fn room_for(width: usize, height: usize) -> usize {
    (height * width + width.div_ceil(BLOCK) * BLOCK * BAND + 1) * 3
}

/// Linear radiance of every pixel, interleaved RGB, into `rgb`, which has room for more; see [`room_for`].
pub fn paint(scene: &PosedScene, view: &View, rays: &Rays, light: &Light, samples: &Samples, rgb: &mut [f32]) {
    let (width, height) = (view.width, view.height);
    let image = width * height;
    let painter = Painter {
        hits: vec![Hits::NONE; Kind::COUNT],
        lanes: Box::default(),
        light,
        camera: Camera {
            eye: rays.eye,
            corner: rays.direction(0.0, 0.0),
            right: rays.right,
            down: rays.down,
            pixel_per_m: 1.0 / view.intrinsics[0] as f32,
        },
        first_behind: image,
        behind: 0,
        rgb,
    };
    let faces = Faces::new(scene, view, rays, light, &samples.0);
    let mut collector = Collector::new(&samples.0, faces, painter, view, rays, light);
    for first_row in (0..height).step_by(BAND) {
        collector.paint_band(first_row, (height - first_row).min(BAND));
    }
    collector.finish();
}

/// Shades hits of a kind as soon as there are enough, and adds them to the picture.
pub(super) struct Painter<'a> {
    /// By kind.
    hits: Vec<Hits>,
    lanes: Box<Lanes>,
    light: &'a Light,
    camera: Camera,
    /// Where pixels begin that have what is seen through panes, and how many there are.
    first_behind: usize,
    behind: usize,
    rgb: &'a mut [f32],
}

impl Painter<'_> {
    /// Empties some rows' pixels and those behind panes.
    pub fn clear(&mut self, pixels: std::ops::Range<usize>) {
        self.rgb[pixels.start * 3..pixels.end * 3].fill(0.0);
        self.behind = 0;
    }

    /// The first of [`BEHIND`] black pixels for what is seen through the panes of a block.
    pub fn new_behind(&mut self) -> u32 {
        let first = self.first_behind + self.behind;
        self.behind += BEHIND;
        self.rgb[first * 3..(first + BEHIND) * 3].fill(0.0);
        first as u32
    }

    /// Colours of some pixels in a row.
    #[inline]
    pub fn row(&mut self, first: usize, count: usize) -> &mut [f32] {
        &mut self.rgb[first * 3..(first + count) * 3]
    }

    /// Adds a colour to a pixel.
    #[inline]
    pub fn add(&mut self, pixel: u32, weight: f32, color: [f32; 3]) {
        let at = pixel as usize * 3;
        for (sum, c) in self.rgb[at..at + 3].iter_mut().zip(color) {
            *sum += weight * c;
        }
    }

    /// What a face shows in a block. What is behind a pane must be shaded.
    #[inline]
    pub fn push(&mut self, faces: &Faces, kind: u32, patch: &Patch, samples: SampleBits) {
        let hits = &mut self.hits[kind as usize];
        hits.push(patch, samples);
        if hits.is_full() {
            self.shade(faces, kind as usize);
        }
    }

    /// Shades all that waits.
    pub fn shade_all(&mut self, faces: &Faces) {
        for kind in 0..self.hits.len() {
            self.shade(faces, kind);
        }
    }

    #[inline(never)]
    fn shade(&mut self, faces: &Faces, kind: usize) {
        let hits = &mut self.hits[kind];
        if hits.count == 0 {
            return;
        }
        let known = (faces.faces.as_slice(), faces.open.as_slice());
        self.lanes.shade(self.light, &self.camera, Kind::of(kind), hits, known, self.rgb);
        let n = hits.count.min(LANES);
        hits.clear();
        let [left, right] = &self.lanes.out;
        for (i, pixel) in self.lanes.target[..n].iter().enumerate() {
            if let Some(pixels) = self.rgb[*pixel as usize * 3..].first_chunk_mut::<6>() {
                let added = [left[0][i], left[1][i], left[2][i], right[0][i], right[1][i], right[2][i]];
                for k in 0..6 {
                    pixels[k] += added[k];
                }
            }
        }
    }
}
