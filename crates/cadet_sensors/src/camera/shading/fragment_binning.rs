//! Bins what a band of the image shows by shader variant: of each block of the visibility buffer every face once, with
//! the samples that show it.

use std::ops::Range;

use super::ambient_cache::SurfacePoint;
use super::deferred_shading::{BAND, DeferredShader};
use super::face_cache::FaceCache;
use super::shading_queue::{BACKGROUND_STRIDE, FragmentGroup};
use super::sky_rows::SkyRows;
use crate::camera::light::Light;
use crate::camera::sensor::MIDDLE_PX;
use crate::camera::visibility::{
    CoverageMask, CoveredFace, FIRST_SAMPLES, ImageRays, View, any_of_pixels, bits_of, place_of, read_block,
    samples_within, split_by_face, where_nearer, whole_pixels,
};
use crate::sense::{BLOCK, VisibilityBuffer};

/// A face that is seen by so few of a block's 64 samples is too small to show how the light changes on it.
const LONE: u32 = 12;
/// Rows of pixels of a block: two rows of samples each.
const ROWS: usize = BLOCK / 2;
/// Rows of samples of a block: bits of a column.
const ROWS_OF_SAMPLES: u32 = BLOCK as u32;
/// Columns of a band that are binned together: what lies together in the image shares faces and shadow texels.
const TOGETHER: usize = 64;

/// Fragment groups of a band, and what is known of their faces.
pub struct FragmentBinner<'a> {
    buffer: &'a VisibilityBuffer,
    faces: FaceCache<'a>,
    shader: DeferredShader<'a>,
    /// The faces that the blocks at hand show.
    covered: Vec<CoveredFace>,
    edges: Vec<EdgePixel>,
    /// Fragment groups of transparent surfaces, with their shader variants and samples.
    transparent: Vec<(u32, FragmentGroup, CoverageMask)>,
    sky: SkyRows<'a>,
    width: usize,
}

/// A pixel whose samples see two faces.
#[derive(Clone, Copy)]
struct EdgePixel {
    faces: [u32; 2],
    /// Its second sample.
    second: CoverageMask,
}

/// A block of the band.
struct Tile {
    /// Its number.
    block: u32,
    /// First pixel row and column.
    top: usize,
    left: usize,
    uncovered: SampleLayer,
    /// Pixels whose samples see two faces and no transparent surface; of [`FragmentBinner::edges`].
    edges: Range<usize>,
    /// Layers seen through transparent surfaces by both samples of pixels, and by one of them.
    background: [SampleLayer; 2],
    /// Of [`FragmentBinner::covered`].
    transparent: Range<usize>,
}

/// What some samples of a block see.
struct SampleLayer {
    /// Of [`FragmentBinner::covered`].
    covered: Range<usize>,
    /// The samples that see nothing.
    sky: CoverageMask,
}

/// Where the colors of a block's pixels go.
#[derive(Clone, Copy)]
struct Target {
    /// The first pixel's.
    first: u32,
    /// From there to the pixel below.
    stride: u32,
    /// What a pixel's color counts, if both samples show the same.
    weight: f32,
}

impl<'a> FragmentBinner<'a> {
    pub fn new(
        buffer: &'a VisibilityBuffer,
        faces: FaceCache<'a>,
        shader: DeferredShader<'a>,
        view: &View,
        rays: &'a ImageRays,
        light: &'a Light,
    ) -> Self {
        let sky = SkyRows::new(view.width, view.height, rays, light);
        let (covered, edges, transparent) = (Vec::new(), Vec::new(), Vec::new());
        Self { buffer, faces, shader, covered, edges, transparent, sky, width: view.width }
    }

    /// Bins and shades the rows of a band.
    pub fn shade_band(&mut self, first_row: usize, rows: usize) {
        let width = self.width;
        self.shader.clear(first_row * width..(first_row + rows) * width);
        for start in (0..width).step_by(TOGETHER) {
            let mut tiles = [const { None }; TOGETHER / BLOCK * BAND / ROWS];
            let places = (start..(start + TOGETHER).min(width))
                .step_by(BLOCK)
                .flat_map(|left| (0..rows).step_by(ROWS).map(move |row| (row, left)));
            // Read at once, so that the processor waits for many lines of the memory together.
            let mut prefetched = 0;
            let number_of = |row: usize, left: usize| row / ROWS * self.buffer.blocks_across + left / BLOCK;
            for (row, left) in places.clone() {
                let number = number_of(first_row + row, left);
                if self.buffer.only_face(number).is_none() {
                    prefetched ^= self.buffer.opaque(number).prefetch();
                }
            }
            let _ = std::hint::black_box(prefetched);
            self.covered.clear();
            self.edges.clear();
            for (tile, (row, left)) in tiles.iter_mut().zip(places) {
                let number = number_of(first_row + row, left);
                let inside = samples_within((rows - row).min(ROWS), (width - left).min(BLOCK));
                *tile = Some(self.find(number, (first_row + row, left), inside));
            }
            self.faces.make_requested();
            for tile in tiles.iter().flatten() {
                self.bin(tile);
            }
        }
        if !self.transparent.is_empty() {
            // Transparent surfaces come after what they show.
            self.shader.shade_all(&self.faces);
            self.transparent.sort_by_key(|(variant, ..)| *variant);
            for (variant, group, samples) in self.transparent.drain(..) {
                self.shader.push(&self.faces, variant, &group, samples);
            }
            self.shader.shade_all(&self.faces);
        }
        if self.faces.is_full() {
            self.finish();
            self.faces.clear();
        }
    }

    /// Shades what still waits.
    pub fn finish(&mut self) {
        self.shader.shade_all(&self.faces);
    }

    /// Finds what a block shows, and requests its faces.
    fn find(&mut self, number: usize, (top, left): (usize, usize), inside: CoverageMask) -> Tile {
        let (first_covered, first_edge) = (self.covered.len(), self.edges.len());
        let none = || SampleLayer { covered: 0..0, sky: 0 };
        let block = number as u32;
        let mut tile =
            Tile { block, top, left, uncovered: none(), edges: 0..0, background: [none(), none()], transparent: 0..0 };
        if let Some(face) = self.buffer.only_face(number) {
            self.covered.push(CoveredFace { face, coverage: inside });
            tile.uncovered.covered = first_covered..self.covered.len();
        } else {
            let (block, transparent) = (self.buffer.opaque(number), self.buffer.transparent(number));
            let behind = transparent.map_or(0, |transparent| where_nearer(transparent, block) & inside);
            let (uncovered, both) = (inside & !behind, whole_pixels(behind));
            let (mut numbers, differ) = read_block(block);
            let whole_uncovered = whole_pixels(uncovered);
            for bit in bits_of(differ & (whole_uncovered | both)) {
                let (second, first) = (place_of(bit), place_of(bit - 1));
                let faces = [numbers[first], numbers[second]];
                // They differ without order: the first stands for both.
                if self.faces.are_of_one_plant(faces[0], faces[1]) {
                    numbers[second] = faces[0];
                } else if whole_uncovered >> bit & 1 == 1 {
                    self.edges.push(EdgePixel { faces, second: 1 << bit });
                }
            }
            let mut layer = |of| {
                let start = self.covered.len();
                let sky = split_by_face(&numbers, of, &mut self.covered);
                SampleLayer { covered: start..self.covered.len(), sky }
            };
            tile.uncovered = layer(uncovered);
            tile.edges = first_edge..self.edges.len();
            if let Some(transparent) = transparent.filter(|_| behind != 0) {
                tile.background = [layer(both), layer(behind & !both)];
                let start = self.covered.len();
                let _ = split_by_face(&read_block(transparent).0, behind, &mut self.covered);
                tile.transparent = start..self.covered.len();
            }
        }
        for covered in &self.covered[first_covered..] {
            self.faces.request(covered.face);
        }
        tile
    }

    /// Passes on what a block shows.
    fn bin(&mut self, tile: &Tile) {
        // Pixels on the edge between faces that look alike are shaded once.
        let covered = &mut self.covered[tile.uncovered.covered.clone()];
        for EdgePixel { faces: [first, second], second: sample } in &self.edges[tile.edges.clone()] {
            if self.faces.are_alike(*first, *second) {
                for covered in covered.iter_mut() {
                    covered.coverage |= if covered.face == *first { *sample } else { 0 };
                    covered.coverage &= if covered.face == *second { !*sample } else { CoverageMask::MAX };
                }
            }
        }
        let number = (tile.top * self.width + tile.left) as u32;
        let image = Target { first: number, stride: self.width as u32, weight: 1.0 };
        self.bin_layer(tile, &tile.uncovered, &image);
        if tile.transparent.is_empty() {
            return;
        }
        let background = self.shader.new_background();
        // Pixels of which one sample sees a transparent surface have the color of that sample behind it.
        for (layer, weight) in tile.background.iter().zip([1.0, 2.0]) {
            self.bin_layer(tile, layer, &Target { first: background, stride: BACKGROUND_STRIDE, weight });
        }
        for i in tile.transparent.clone() {
            let covered = self.covered[i];
            let (variant, group) = self.group(tile, &covered, &image);
            self.transparent.push((variant, FragmentGroup { background, ..group }, covered.coverage));
        }
    }

    fn bin_layer(&mut self, tile: &Tile, layer: &SampleLayer, target: &Target) {
        for i in layer.covered.clone() {
            let covered = self.covered[i];
            if covered.coverage != 0 {
                let (variant, group) = self.group(tile, &covered, target);
                self.shader.push(&self.faces, variant, &group, covered.coverage);
            }
        }
        if layer.sky != 0 {
            self.fill_sky(tile, layer.sky, target);
        }
    }

    /// What a made face shows of a block, and its shader variant.
    #[inline]
    fn group(&mut self, tile: &Tile, covered: &CoveredFace, target: &Target) -> (u32, FragmentGroup) {
        let (face, variant) = self.faces.made(covered.face);
        let (u, v) = (tile.left as f32 + MIDDLE_PX, tile.top as f32 + MIDDLE_PX);
        let inverse_depth_per_m = self.faces.inverse_depth_per_m_at(face, u, v);
        // A sample half-way from the first to the last column that shows it.
        let columns = [
            covered.coverage.trailing_zeros() / ROWS_OF_SAMPLES,
            (CoverageMask::BITS - 1 - covered.coverage.leading_zeros()) / ROWS_OF_SAMPLES,
        ];
        let middle = (columns[0] + columns[1]) / 2 * ROWS_OF_SAMPLES;
        let middle = middle + (covered.coverage >> middle).trailing_zeros();
        let (column, row) = ((middle / ROWS_OF_SAMPLES) as f32, (middle % ROWS_OF_SAMPLES / 2) as f32);
        let there = inverse_depth_per_m[0] + inverse_depth_per_m[1] * column + inverse_depth_per_m[2] * row;
        let is_lone = covered.coverage.count_ones() <= LONE;
        let point = SurfacePoint { u: u + column, v: v + row, inverse_depth_per_m: there, is_lone };
        let ambient = self.faces.ambient_index(face, tile.block, (u, v), inverse_depth_per_m, point);
        let &Target { first, stride, weight } = target;
        (
            variant,
            FragmentGroup { face, ambient, target: first, stride, background: 0, u, v, inverse_depth_per_m, weight },
        )
    }

    /// The sky in some samples.
    fn fill_sky(&mut self, tile: &Tile, samples: CoverageMask, target: &Target) {
        let columns = BLOCK.min(self.width - tile.left);
        for row in 0..ROWS {
            let of_row = samples_within(1, columns) << (2 * row);
            let (line, first) = (tile.top + row, target.first as usize + row * target.stride as usize);
            if samples & of_row == of_row {
                self.sky.fill(tile.left, line, self.shader.row(first, columns));
                continue;
            }
            for bit in bits_of(any_of_pixels(samples & of_row) & FIRST_SAMPLES) {
                let column = place_of(bit) % BLOCK;
                let color = self.sky.at(tile.left + column, line);
                let share = if samples >> bit & 3 == 3 { 1.0 } else { 0.5 };
                self.shader.add((first + column) as u32, share * target.weight, color);
            }
        }
    }
}
