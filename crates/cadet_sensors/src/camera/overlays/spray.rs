//! Spray behind vehicles in the image: each plume dims what is behind it and shows the light around.
//!
//! A plume's optical depth is integrated along the rays of a coarse lattice over the part of the image that it covers, slice by
//! slice of depth; every sample looks up how much of it stands before what the sample shows. Spray is smooth, so that this
//! costs little and keeps the edges of what stands in it.

use std::ops::Range;

use super::compositing::blend;
use crate::camera::light::{Light, transmittance};
use crate::camera::visibility::{View, Visibility};
use crate::sense::BLOCK;
use crate::spray::{Plume, Spray};
use cadet_base::math::{DVec3, Vec3};

/// Slices of depth of a plume.
const SLICES: usize = 16;
/// Points of the lattice across the image of a plume, if the fewest and the most pixels between them allow.
const POINTS: usize = 24;
const MIN_STEP_PX: usize = 2;
const MAX_STEP_PX: usize = 16;
/// Spray nearer than this is on the lens, m.
const NEAREST_M: f64 = 0.3;
/// Optical depths below this are none.
const LEAST_DEPTH: f32 = 4e-3;

/// Draws spray into linear radiance, interleaved RGB.
pub(crate) fn draw(spray: &Spray, rgb: &mut [f32], view: &View, seen: &Visibility, light: &Light) {
    let eye = view.world_from_cam.translation;
    let distance_m = |plume: &Plume| (plume.world_from_plume().translation - eye).length();
    let mut far_first: Vec<(f64, &Plume)> = spray.plumes().iter().map(|plume| (distance_m(plume), plume)).collect();
    far_first.sort_by(|(a_m, _), (b_m, _)| b_m.total_cmp(a_m));
    for (distance_m, plume) in far_first {
        if let Some(lattice) = PlumeLattice::new(plume, view) {
            let direction = (plume.world_from_plume().translation - eye).normalize_or(DVec3::X);
            let radiance = light.through_air(light.around(), direction.as_vec3(), distance_m as f32);
            lattice.draw(rgb, view.width, seen, radiance);
        }
    }
}

/// A plume's optical depths before the slices of a lattice of rays.
struct PlumeLattice {
    rows: Range<usize>,
    columns: Range<usize>,
    step: usize,
    points_across: usize,
    /// The point to the left of each column, and the share of the one to its right.
    across: Vec<(u32, f32)>,
    /// Depth at which the first slice begins, and one over the slices' thickness.
    first_m: f32,
    per_m: f32,
    /// One over the depth at which the last slice ends.
    last_per_m: f32,
    /// Point by point, row by row: depths before each slice, and of all.
    depths: Vec<[f32; SLICES + 1]>,
}

/// The pixels and the depths between which a plume may be seen.
fn window(plume: &Plume, view: &View) -> Option<(Range<usize>, Range<usize>, [f64; 2])> {
    let cam_from_plume = view.world_from_cam.inverse() * *plume.world_from_plume();
    let [low, high] = plume.bounds().map(|corner| corner.as_dvec3());
    let corners: [DVec3; 8] = std::array::from_fn(|k| {
        let pick = |bit: usize, low: f64, high: f64| if k >> bit & 1 == 0 { low } else { high };
        cam_from_plume * DVec3::new(pick(0, low.x, high.x), pick(1, low.y, high.y), pick(2, low.z, high.z))
    });
    let [near_m, far_m] = corners.iter().fold([f64::INFINITY, 0.0_f64], |[near, far], p| [near.min(p.z), far.max(p.z)]);
    if far_m <= NEAREST_M {
        return None;
    }
    let [fx, fy, cx, cy] = view.intrinsics_px;
    let mut spans = [[f64::INFINITY, f64::NEG_INFINITY]; 2];
    let mut reach = |p: DVec3| {
        for (span, at) in spans.iter_mut().zip([fx * p.x / p.z + cx, fy * p.y / p.z + cy]) {
            *span = [span[0].min(at), span[1].max(at)];
        }
    };
    for (k, a) in corners.iter().enumerate() {
        if a.z >= NEAREST_M {
            reach(*a);
        }
        // Edges that pass through the nearest plane end there.
        for b in (0..3).filter(|bit| k >> bit & 1 == 0).map(|bit| corners[k | 1 << bit]) {
            if (a.z < NEAREST_M) != (b.z < NEAREST_M) {
                reach(*a + (b - *a) * ((NEAREST_M - a.z) / (b.z - a.z)));
            }
        }
    }
    let pixels = |[low, high]: [f64; 2], size: usize| {
        let (low, high) = ((low - 1.0).max(0.0), (high + 1.0).min(size as f64 - 1.0));
        (low <= high).then(|| low as usize..high as usize + 1)
    };
    Some((pixels(spans[1], view.height)?, pixels(spans[0], view.width)?, [near_m.max(NEAREST_M), far_m]))
}

impl PlumeLattice {
    fn new(plume: &Plume, view: &View) -> Option<Self> {
        let (rows, columns, [near_m, far_m]) = window(plume, view)?;
        let step = (columns.len() / POINTS).clamp(MIN_STEP_PX, MAX_STEP_PX);
        let points_across = columns.len() / step + 2;
        let points_down = rows.len() / step + 2;
        let plume_from_cam = *plume.plume_from_world() * view.world_from_cam;
        let from = plume_from_cam.translation.as_vec3();
        let [fx, fy, cx, cy] = view.intrinsics_px;
        let slice_m = ((far_m - near_m) / SLICES as f64) as f32;
        let mut depths = Vec::with_capacity(points_across * points_down);
        for i in 0..points_down {
            for j in 0..points_across {
                let (column, row) = ((columns.start + j * step) as f64, (rows.start + i * step) as f64);
                let direction = DVec3::new((column - cx) / fx, (row - cy) / fy, 1.0);
                let length = direction.length() as f32;
                let direction = (plume_from_cam.rotation * direction).as_vec3();
                let mut before = [0.0; SLICES + 1];
                for k in 0..SLICES {
                    let middle = from + direction * (near_m as f32 + (k as f32 + 0.5) * slice_m);
                    before[k + 1] = before[k] + plume.extinction_per_m(middle) * slice_m * length;
                }
                depths.push(before);
            }
        }
        let across = (0..columns.len()).map(|at| ((at / step) as u32, (at % step) as f32 / step as f32)).collect();
        let (first_m, per_m, last_per_m) = (near_m as f32, 1.0 / slice_m, 1.0 / far_m as f32);
        Some(Self { rows, columns, step, points_across, across, first_m, per_m, last_per_m, depths })
    }

    fn draw(&self, rgb: &mut [f32], width: usize, seen: &Visibility, radiance: Vec3) {
        let buffer = &seen.samples.0;
        let mut line = vec![[0.0; SLICES + 1]; self.points_across];
        for row in self.rows.clone() {
            self.fill(row, &mut line);
            let (block_row, i) = (2 * row / BLOCK * buffer.blocks_across, 2 * row % BLOCK);
            let mut column = self.columns.start;
            while column < self.columns.end {
                let number = block_row + column / BLOCK;
                let end = (column / BLOCK * BLOCK + BLOCK).min(self.columns.end);
                let (opaque, transparent) = (buffer.opaque(number), buffer.transparent(number));
                for column in column..end {
                    let (point, share) = self.across[column - self.columns.start];
                    let pair = [&line[point as usize], &line[point as usize + 1]];
                    let [left, right] = pair.map(|depths| depths[SLICES]);
                    if left.max(right) < LEAST_DEPTH {
                        continue;
                    }
                    // The two samples of a pixel; mostly all of the plume is before both.
                    let inverse = [i, i + 1].map(|i| {
                        let glass = transparent.map_or(0.0, |glass| glass.inverse_depth_per_m[i][column % BLOCK]);
                        glass.max(opaque.inverse_depth_per_m[i][column % BLOCK])
                    });
                    let clear = if inverse[0].max(inverse[1]) <= self.last_per_m {
                        transmittance(left + (right - left) * share, 1.0)
                    } else {
                        let [a, b] = inverse.map(|v| transmittance(self.depth_before(pair, share, 1.0 / v), 1.0));
                        0.5 * (a + b)
                    };
                    let cover = 1.0 - clear;
                    if cover > 0.0 {
                        let at = 3 * (row * width + column);
                        blend(&mut rgb[at..at + 3], radiance, cover);
                    }
                }
                column = end;
            }
        }
    }

    /// The lattice along a row of pixels.
    fn fill(&self, row: usize, line: &mut [[f32; SLICES + 1]]) {
        let down = row - self.rows.start;
        let (point, share) = (down / self.step, (down % self.step) as f32 / self.step as f32);
        let [above, below] = [point, point + 1].map(|k| &self.depths[k * self.points_across..][..self.points_across]);
        for ((out, above), below) in line.iter_mut().zip(above).zip(below) {
            for ((out, above), below) in out.iter_mut().zip(above).zip(below) {
                *out = above + (below - above) * share;
            }
        }
    }

    /// Optical depth before a depth, between two points of the lattice.
    #[inline]
    fn depth_before(&self, [left, right]: [&[f32; SLICES + 1]; 2], share: f32, depth_m: f32) -> f32 {
        let place = ((depth_m - self.first_m) * self.per_m).clamp(0.0, SLICES as f32);
        let slice = (place as usize).min(SLICES - 1);
        let inside = place - slice as f32;
        let [left, right] = [left, right].map(|d| d[slice] + (d[slice + 1] - d[slice]) * inside);
        left + (right - left) * share
    }
}
