//! Gives what the camera's samples meet its colour: hits are collected by kind in bands of rows and shaded together.

use std::ops::Range;

use super::faces::{Faces, Kind, NO_PLANT};
use super::look::{Rays, Samples, View};
use super::noise::MIDDLE_PX;
use super::shade::{Camera, Hit, LANES, Lanes, Light, NO_SLOT};
use super::sky::SkyRows;
use crate::sense::{NO_HIT, Pair, PosedScene};

/// Rows whose hits are collected before they are shaded.
pub(super) const BAND: usize = 8;
/// Columns of a band that are collected together: what lies together in the image shares faces and shadow texels.
const BLOCK: usize = 64;
/// From the middle of a pixel's two samples, which lies `MIDDLE_PX` right and below of its centre; the point spread
/// takes that back.
const OFFSETS: [(f32, f32); 2] = [(-0.25, -0.25), (0.25, 0.25)];

/// Linear radiance of every pixel, interleaved RGB.
pub fn paint(scene: &PosedScene, view: &View, rays: &Rays, light: &Light, samples: &Samples, rgb: &mut Vec<f32>) {
    let (width, height) = (view.width, view.height);
    rgb.resize(width * height * 3, 0.0);
    let mut painter = Painter {
        faces: Faces::new(scene, view, rays, light, &samples.0.faces),
        hits: Vec::new(),
        panes: Vec::new(),
        behind: Vec::new(),
        sky: SkyRows::new(width, height),
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
    painter.hits.resize_with(Kind::COUNT, Vec::new);
    for (band, rgb) in rgb.chunks_mut(width * BAND * 3).enumerate() {
        rgb.fill(0.0);
        painter.paint_band(samples, band * BAND, rgb);
    }
}

struct Painter<'a> {
    faces: Faces<'a>,
    /// Of the band, by kind.
    hits: Vec<Vec<Hit>>,
    /// Hits of panes, with their kinds.
    panes: Vec<(u32, Hit)>,
    /// What is seen through the band's panes.
    behind: Vec<[f32; 3]>,
    sky: SkyRows,
    /// The endless air for every pixel of the band.
    air: Vec<[f32; 3]>,
    lanes: Box<Lanes>,
    width: usize,
    rays: &'a Rays,
    light: &'a Light,
    camera: Camera,
}

/// What samples of one pixel see of one face.
#[derive(Clone, Copy)]
struct Part {
    /// Number of the face.
    face: u32,
    /// See [`Faces::plant`].
    plant: u32,
    /// Samples that count for it.
    weight: f32,
    /// Samples of the very face, and the sums of their places.
    count: f32,
    du: f32,
    dv: f32,
    depth: f32,
}

impl Painter<'_> {
    fn paint_band(&mut self, samples: &Samples, first_row: usize, rgb: &mut [f32]) {
        let rows = rgb.len() / (3 * self.width);
        for row in 0..rows {
            self.air_of_row(row, first_row + row);
        }
        for start in (0..self.width).step_by(BLOCK) {
            for row in 0..rows {
                self.collect_row(samples, first_row, row, start..(start + BLOCK).min(self.width), rgb);
            }
        }
        let (faces, open) = (std::mem::take(&mut self.faces.faces), std::mem::take(&mut self.faces.open));
        for (kind, hits) in self.hits.iter_mut().enumerate() {
            for some in hits.chunks(LANES) {
                let known = (faces.as_slice(), open.as_slice());
                self.lanes.shade(self.light, &self.camera, Kind::of(kind), some, known, &self.air, &self.behind);
                for (i, hit) in some.iter().enumerate() {
                    let color = self.lanes.out.each_ref().map(|c| c[i]);
                    if hit.slot == NO_SLOT {
                        let at = hit.pixel as usize * 3;
                        for (sum, c) in rgb[at..at + 3].iter_mut().zip(color) {
                            *sum += hit.weight * c;
                        }
                    } else {
                        for (sum, c) in self.behind[hit.slot as usize].iter_mut().zip(color) {
                            *sum += hit.weight * c;
                        }
                    }
                }
            }
            hits.clear();
        }
        // Panes come after what they show.
        self.panes.sort_by_key(|(kind, _)| *kind);
        for (kind, hit) in self.panes.drain(..) {
            self.hits[kind as usize].push(hit);
        }
        for (kind, hits) in self.hits.iter_mut().enumerate() {
            for some in hits.chunks(LANES) {
                let known = (faces.as_slice(), open.as_slice());
                self.lanes.shade(self.light, &self.camera, Kind::of(kind), some, known, &self.air, &self.behind);
                for (i, hit) in some.iter().enumerate() {
                    let at = hit.pixel as usize * 3;
                    for (sum, c) in rgb[at..at + 3].iter_mut().zip(&self.lanes.out) {
                        *sum += hit.weight * c[i];
                    }
                }
            }
            hits.clear();
        }
        self.behind.clear();
        (self.faces.faces, self.faces.open) = (faces, open);
        self.faces.forget_if_many();
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

    fn collect_row(
        &mut self,
        samples: &Samples,
        first_row: usize,
        row_in_band: usize,
        columns: Range<usize>,
        rgb: &mut [f32],
    ) {
        let buffer = &samples.0;
        let row = first_row + row_in_band;
        let v = row as f32 + MIDDLE_PX;
        for column in columns {
            let pixel = (row_in_band * self.width + column) as u32;
            let u = column as f32 + MIDDLE_PX;
            let solid = buffer.solid_pair(2 * row, column);
            if let Some(panes) = buffer.pane_pair(2 * row, column, &solid) {
                self.collect_behind_panes(&solid, &panes, pixel, u, v, rgb);
                continue;
            }
            if solid.is_one_face() {
                if solid.face[0] == NO_HIT {
                    let color = self.sky.at(column, row, self.rays, self.light);
                    rgb[pixel as usize * 3..pixel as usize * 3 + 3].copy_from_slice(&color);
                } else {
                    self.collect(solid.face[0], pixel, NO_SLOT, 1.0, u, v, solid.mean_depth());
                }
                continue;
            }
            let parts = self.parts(&solid);
            for part in parts.into_iter().flatten() {
                let weight = part.weight * 0.5;
                if part.face == NO_HIT {
                    let color = self.sky.at(column, row, self.rays, self.light);
                    for (sum, c) in rgb[pixel as usize * 3..pixel as usize * 3 + 3].iter_mut().zip(color) {
                        *sum += weight * c;
                    }
                } else {
                    let share = 1.0 / part.count;
                    let (u, v) = (u + part.du * share, v + part.dv * share);
                    self.collect(part.face, pixel, NO_SLOT, weight, u, v, part.depth * share);
                }
            }
        }
    }

    #[inline]
    fn collect(&mut self, face: u32, pixel: u32, slot: u32, weight: f32, u: f32, v: f32, depth: f32) {
        let face = self.faces.index(face);
        let open = self.faces.open_index(face, u, v, depth);
        let kind = self.faces.faces[face as usize].kind;
        self.hits[kind as usize].push(Hit { face, open, pixel, slot, weight, u, v, depth });
    }

    /// A pixel some of whose samples lie behind panes: sample by sample, unless both agree.
    fn collect_behind_panes(&mut self, solid: &Pair, panes: &Pair, pixel: u32, u: f32, v: f32, rgb: &mut [f32]) {
        let before = |i: usize| panes.nearness[i] > solid.nearness[i];
        if (0..2).all(before) && solid.is_one_face() && panes.is_one_face() {
            let depths = [solid.mean_depth(), panes.mean_depth()];
            self.collect_pane([solid.face[0], panes.face[0]], pixel, 1.0, u, v, depths);
            return;
        }
        for (i, (du, dv)) in OFFSETS.into_iter().enumerate() {
            let (u, v) = (u + du, v + dv);
            let depths = [1.0 / solid.nearness[i], 1.0 / panes.nearness[i]];
            if before(i) {
                self.collect_pane([solid.face[i], panes.face[i]], pixel, 0.5, u, v, depths);
            } else if solid.face[i] != NO_HIT {
                self.collect(solid.face[i], pixel, NO_SLOT, 0.5, u, v, depths[0]);
            } else {
                let color = self.sky.at(u as usize, v as usize, self.rays, self.light);
                for (sum, c) in rgb[pixel as usize * 3..pixel as usize * 3 + 3].iter_mut().zip(color) {
                    *sum += 0.5 * c;
                }
            }
        }
    }

    fn collect_pane(
        &mut self,
        [solid, pane]: [u32; 2],
        pixel: u32,
        weight: f32,
        u: f32,
        v: f32,
        [depth, pane_depth]: [f32; 2],
    ) {
        let slot = self.behind.len() as u32;
        if solid == NO_HIT {
            self.behind.push(self.sky.at(u as usize, v as usize, self.rays, self.light));
        } else {
            self.behind.push([0.0; 3]);
            self.collect(solid, pixel, slot, 1.0, u, v, depth);
        }
        let face = self.faces.index(pane);
        let open = self.faces.open_index(face, u, v, pane_depth);
        let kind = self.faces.faces[face as usize].kind;
        self.panes.push((kind, Hit { face, open, pixel, slot, weight, u, v, depth: pane_depth }));
    }

    /// Collects a pixel's samples by face: one shading each. Leaves of one plant are shaded as one, by the first: they
    /// differ without order.
    #[inline]
    fn parts(&self, solid: &Pair) -> [Option<Part>; 2] {
        let mut out: [Option<Part>; 2] = [None; 2];
        'samples: for (i, (du, dv)) in OFFSETS.into_iter().enumerate() {
            let face = solid.face[i];
            let depth = 1.0 / solid.nearness[i];
            let plant = if face == NO_HIT { NO_PLANT } else { self.faces.plant(face) };
            for slot in &mut out {
                let Some(part) = slot else {
                    *slot = Some(Part { face, plant, weight: 1.0, count: 1.0, du, dv, depth });
                    continue 'samples;
                };
                if part.face == face {
                    part.weight += 1.0;
                    part.count += 1.0;
                    part.du += du;
                    part.dv += dv;
                    part.depth += depth;
                    continue 'samples;
                }
                if part.plant == plant && plant != NO_PLANT {
                    part.weight += 1.0;
                    continue 'samples;
                }
            }
        }
        out
    }
}
