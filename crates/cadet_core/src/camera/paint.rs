//! Gives what the camera's samples meet its colour: hits are collected by kind, band by band of rows, and shaded together.

use super::collect::Collector;
use super::face::Kind;
use super::faces::Faces;
use super::hits::{Hit, Hits, LANES, RUN};
use super::lanes::Lanes;
use super::look::{Rays, Samples, View};
use super::shade::{Camera, Light};
use crate::sense::PosedScene;

/// Rows that are collected together.
pub(super) const BAND: usize = 8;

/// Values that [`paint`] needs room for: those of the image, and of what lies behind the panes of a band, two samples a
/// pixel.
pub fn room_for(width: usize, height: usize) -> usize {
    (height + 2 * BAND) * width * 3
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
    let faces = Faces::new(scene, view, rays, light, &samples.0.faces);
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

    /// A pixel for what is seen through a pane.
    pub fn new_behind(&mut self, color: [f32; 3]) -> u32 {
        let pixel = self.first_behind + self.behind;
        self.behind += 1;
        self.rgb[pixel * 3..pixel * 3 + 3].copy_from_slice(&color);
        pixel as u32
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

    #[inline]
    pub fn push(&mut self, faces: &Faces, kind: u32, hit: &Hit) {
        let hits = &mut self.hits[kind as usize];
        hits.push(hit);
        if hits.is_full() {
            self.shade(faces, kind as usize);
        }
    }

    /// See [`Hits::push_run`].
    #[inline]
    pub fn push_run(&mut self, faces: &Faces, kind: u32, first: &Hit, depth: &[f32; RUN], count: usize) {
        let hits = &mut self.hits[kind as usize];
        hits.push_run(first, depth, count);
        if hits.is_full() {
            self.shade(faces, kind as usize);
        }
    }

    /// A hit of a pane; what is `behind` it must be shaded.
    pub fn push_pane(&mut self, faces: &Faces, kind: u32, hit: &Hit, behind: u32) {
        let hits = &mut self.hits[kind as usize];
        hits.behind[hits.count] = behind;
        self.push(faces, kind, hit);
    }

    /// Shades all hits that wait.
    pub fn shade_all(&mut self, faces: &Faces) {
        for kind in 0..self.hits.len() {
            self.shade(faces, kind);
        }
    }

    #[inline(never)]
    fn shade(&mut self, faces: &Faces, kind: usize) {
        let hits = &mut self.hits[kind];
        let n = hits.count.min(LANES);
        if n == 0 {
            return;
        }
        hits.count = 0;
        let (hits, known) = (&self.hits[kind], (faces.faces.as_slice(), faces.open.as_slice()));
        self.lanes.shade(self.light, &self.camera, Kind::of(kind), hits, n, known, self.rgb);
        let [r, g, b] = &self.lanes.out;
        let colors = r[..n].iter().zip(&g[..n]).zip(&b[..n]);
        for ((pixel, weight), ((r, g), b)) in hits.target[..n].iter().zip(&hits.weight[..n]).zip(colors) {
            if let Some([red, green, blue]) = self.rgb[*pixel as usize * 3..].first_chunk_mut() {
                *red += weight * r;
                *green += weight * g;
                *blue += weight * b;
            }
        }
    }
}
