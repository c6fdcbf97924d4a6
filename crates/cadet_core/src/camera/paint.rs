//! Gives what the camera's samples meet its colour: hits are collected by kind in bands of rows and shaded together.

use super::collect::Collector;
use super::faces::{Faces, Kind};
use super::look::{Rays, Samples, View};
use super::noise::MIDDLE_PX;
use super::shade::{Camera, LANES, Lanes, Light, NO_SLOT};
use crate::sense::PosedScene;

/// Rows whose hits are collected before they are shaded.
pub(super) const BAND: usize = 8;

/// Linear radiance of every pixel, interleaved RGB.
pub fn paint(scene: &PosedScene, view: &View, rays: &Rays, light: &Light, samples: &Samples, rgb: &mut Vec<f32>) {
    let (width, height) = (view.width, view.height);
    rgb.resize(width * height * 3, 0.0);
    let faces = Faces::new(scene, view, rays, light, &samples.0.faces);
    let mut painter = Painter {
        collector: Collector::new(&samples.0, faces, width, height, rays, light),
        air: vec![[0.0; 3]; width * BAND],
        lanes: Box::default(),
        width,
        rays,
        light,
        camera: Camera {
            eye: rays.eye,
            corner: rays.direction(0.0, 0.0),
            right: rays.right,
            down: rays.down,
            pixel_per_m: 1.0 / view.intrinsics[0] as f32,
        },
    };
    for (band, rgb) in rgb.chunks_mut(width * BAND * 3).enumerate() {
        rgb.fill(0.0);
        painter.paint_band(band * BAND, rgb);
    }
}

struct Painter<'a> {
    collector: Collector<'a>,
    /// The endless air for every pixel of the band.
    air: Vec<[f32; 3]>,
    lanes: Box<Lanes>,
    width: usize,
    rays: &'a Rays,
    light: &'a Light,
    camera: Camera,
}

impl Painter<'_> {
    fn paint_band(&mut self, first_row: usize, rgb: &mut [f32]) {
        let rows = rgb.len() / (3 * self.width);
        for row in 0..rows {
            self.air_of_row(row, first_row + row);
        }
        self.collector.collect_band(first_row, rgb);
        let Collector { faces, hits, panes, behind, .. } = &mut self.collector;
        let known = (faces.faces.as_slice(), faces.open.as_slice());
        for (kind, hits) in hits.iter_mut().enumerate() {
            for some in hits.chunks(LANES) {
                self.lanes.shade(self.light, &self.camera, Kind::of(kind), some, known, &self.air, behind);
                for (i, hit) in some.iter().enumerate() {
                    let color = self.lanes.out.each_ref().map(|c| c[i]);
                    if hit.slot == NO_SLOT {
                        let at = hit.pixel as usize * 3;
                        for (sum, c) in rgb[at..at + 3].iter_mut().zip(color) {
                            *sum += hit.weight * c;
                        }
                    } else {
                        for (sum, c) in behind[hit.slot as usize].iter_mut().zip(color) {
                            *sum += hit.weight * c;
                        }
                    }
                }
            }
            hits.clear();
        }
        // Panes come after what they show.
        panes.sort_by_key(|(kind, _)| *kind);
        for (kind, hit) in panes.drain(..) {
            hits[kind as usize].push(hit);
        }
        for (kind, hits) in hits.iter_mut().enumerate() {
            for some in hits.chunks(LANES) {
                self.lanes.shade(self.light, &self.camera, Kind::of(kind), some, known, &self.air, behind);
                for (i, hit) in some.iter().enumerate() {
                    let at = hit.pixel as usize * 3;
                    for (sum, c) in rgb[at..at + 3].iter_mut().zip(&self.lanes.out) {
                        *sum += hit.weight * c[i];
                    }
                }
            }
            hits.clear();
        }
        behind.clear();
        faces.forget_if_many();
    }

    /// The air changes slowly: between every 32nd pixel it is interpolated.
    fn air_of_row(&mut self, row_in_band: usize, row: usize) {
        const STEP: usize = 32;
        let v = row as f32 + MIDDLE_PX;
        let at = |column: usize| self.light.air(self.rays.direction(column as f32, v).normalize());
        let line = &mut self.air[row_in_band * self.width..(row_in_band + 1) * self.width];
        let mut from = at(0);
        for (step, some) in line.chunks_mut(STEP).enumerate() {
            let to = at((step + 1) * STEP);
            let slope = (to - from) * (1.0 / STEP as f32);
            for (i, pixel) in some.iter_mut().enumerate() {
                *pixel = (from + slope * i as f32).to_array();
            }
            from = to;
        }
    }
}
