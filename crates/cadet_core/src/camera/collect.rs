//! Collects what a band of the image shows by kind: of each block of the visibility buffer every face once, with the samples
//! that show it.

use std::ops::Range;

use super::faces::{Faces, Place};
use super::hits::{FIRST, Patch, SECOND, SampleBits};
use super::look::{Rays, View};
use super::noise::MIDDLE_PX;
use super::paint::{BAND, Painter};
use super::parts::{FIRSTS, Part, nearer, pixels_of, place_of, read, samples_within, split};
use super::shade::Light;
use super::sky::SkyRows;
use crate::sense::{BLOCK, Block, VisibilityBuffer};

/// Rows of pixels of a block: two rows of samples each.
const ROWS: usize = BLOCK / 2;
/// Columns of a band that are collected together: what lies together in the image shares faces and shadow texels.
const TOGETHER: usize = 64;
/// From the middle of a pixel's two samples, which lies `MIDDLE_PX` right and below of its centre; the point spread
/// takes that back.
const OFFSETS: [f32; 2] = [-0.25, 0.25];

/// Patches of a band, and what is known of their faces.
pub struct Collector<'a> {
    buffer: &'a VisibilityBuffer,
    faces: Faces<'a>,
    painter: Painter<'a>,
    /// What the blocks at hand show.
    parts: Vec<Part>,
    edges: Vec<Edge>,
    /// Patches of panes, with their kinds.
    panes: Vec<(u32, Patch)>,
    sky: SkyRows<'a>,
    width: usize,
}

/// A pixel whose samples see two faces.
#[derive(Clone, Copy)]
struct Edge {
    faces: [u32; 2],
    /// Its second sample.
    second: SampleBits,
}

/// A block of the band.
#[derive(Clone)]
struct Tile {
    /// Its number in the buffer.
    number: usize,
    place: Place,
    /// First pixel row and column.
    top: usize,
    left: usize,
    /// Of [`Collector::parts`] and [`Collector::edges`].
    parts: Range<usize>,
    edges: Range<usize>,
    /// The samples that see nothing.
    sky: SampleBits,
    /// Both samples of pixels with panes before what is solid.
    panes: SampleBits,
}

/// A pixel.
#[derive(Clone, Copy)]
struct Pixel {
    column: usize,
    row: usize,
    number: u32,
    place: Place,
}

impl Pixel {
    /// The middle of its samples.
    fn uv(&self) -> (f32, f32) {
        (self.column as f32 + MIDDLE_PX, self.row as f32 + MIDDLE_PX)
    }

    /// One of its samples.
    fn sample(&self, i: usize) -> (f32, f32) {
        let (u, v) = self.uv();
        (u + OFFSETS[i], v + OFFSETS[i])
    }
}

/// The two samples of a pixel: nearness in 1/m, 0 where there is nothing, and the number of the face.
type Two = [(f32, u32); 2];

/// Of a pixel of a block.
#[inline]
fn two(block: &Block, row: usize, column: usize) -> Two {
    [2 * row, 2 * row + 1].map(|line| (block.nearness[line][column], block.face[line][column]))
}

/// The set bits of a number, from the lowest on.
fn bits_of(mut set: SampleBits) -> impl Iterator<Item = u32> {
    std::iter::from_fn(move || {
        let bit = set.trailing_zeros();
        set &= set.wrapping_sub(1);
        (bit < SampleBits::BITS).then_some(bit)
    })
}

impl<'a> Collector<'a> {
    pub fn new(
        buffer: &'a VisibilityBuffer,
        faces: Faces<'a>,
        painter: Painter<'a>,
        view: &View,
        rays: &'a Rays,
        light: &'a Light,
    ) -> Self {
        let sky = SkyRows::new(view.width, view.height, rays, light);
        let (parts, edges, panes) = (Vec::new(), Vec::new(), Vec::new());
        Self { buffer, faces, painter, parts, edges, panes, sky, width: view.width }
    }

    /// Collects the rows of a band.
    pub fn paint_band(&mut self, first_row: usize, rows: usize) {
        let width = self.width;
        self.painter.clear(first_row * width..(first_row + rows) * width);
        for start in (0..width).step_by(TOGETHER) {
            let mut tiles = [const { None }; TOGETHER / BLOCK * BAND / ROWS];
            // The blocks of a square one after the other: leaves share the sky's visibility there.
            let places = (start..(start + TOGETHER).min(width))
                .step_by(BLOCK)
                .flat_map(|left| (0..rows).step_by(ROWS).map(move |row| (row, left)));
            // Read at once, so that the processor waits for many lines of the memory together.
            let mut touched = 0;
            let number_of = |row: usize, left: usize| row / ROWS * self.buffer.blocks_across + left / BLOCK;
            for (row, left) in places.clone() {
                let number = number_of(first_row + row, left);
                if self.buffer.only_face(number).is_none() {
                    touched ^= self.buffer.solid(number).touch();
                }
            }
            let _ = std::hint::black_box(touched);
            self.parts.clear();
            self.edges.clear();
            for (tile, (row, left)) in tiles.iter_mut().zip(places) {
                let (number, square) = (number_of(first_row + row, left), number_of(first_row, left));
                let place = Place { block: number as u32, square: square as u32 };
                let inside = samples_within((rows - row).min(ROWS), (width - left).min(BLOCK));
                *tile = Some(self.find(number, place, (first_row + row, left), inside));
            }
            self.faces.make_asked();
            for tile in tiles.iter().flatten() {
                self.collect(tile);
            }
        }
        if !self.panes.is_empty() {
            // Panes come after what they show.
            self.painter.shade_all(&self.faces);
            self.panes.sort_by_key(|(kind, _)| *kind);
            for (kind, patch) in self.panes.drain(..) {
                self.painter.push(&self.faces, kind, &patch, FIRST | SECOND);
            }
            self.painter.shade_all(&self.faces);
        }
        if self.faces.are_many() {
            self.finish();
            self.faces.forget();
        }
    }

    /// Shades what still waits.
    pub fn finish(&mut self) {
        self.painter.shade_all(&self.faces);
    }

    /// Finds what a block shows, and asks for its faces.
    fn find(&mut self, number: usize, place: Place, (top, left): (usize, usize), inside: SampleBits) -> Tile {
        let (parts, edges) = (self.parts.len(), self.edges.len());
        let mut tile = Tile { number, place, top, left, parts: parts..parts, edges: edges..edges, sky: 0, panes: 0 };
        if let Some(face) = self.buffer.only_face(number) {
            self.parts.push(Part { face, samples: inside });
        } else {
            let block = self.buffer.solid(number);
            if let Some(panes) = self.buffer.panes(number) {
                tile.panes = pixels_of(nearer(panes, block)) & inside;
                self.ask_behind_panes(block, panes, tile.panes);
            }
            let asked = inside & !tile.panes;
            let (mut numbers, differ) = read(block);
            for bit in bits_of(differ & asked) {
                let (second, first) = (place_of(bit), place_of(bit - 1));
                let faces = [numbers[first], numbers[second]];
                // They differ without order: the first stands for both.
                if self.faces.are_of_one_plant(faces[0], faces[1]) {
                    numbers[second] = faces[0];
                } else {
                    self.edges.push(Edge { faces, second: 1 << bit });
                }
            }
            tile.sky = split(&numbers, asked, &mut self.parts);
        }
        (tile.parts.end, tile.edges.end) = (self.parts.len(), self.edges.len());
        for part in &self.parts[tile.parts.clone()] {
            self.faces.ask(part.face);
        }
        tile
    }

    /// All faces of pixels with panes, except for panes behind what is solid.
    fn ask_behind_panes(&mut self, solid: &Block, panes: &Block, samples: SampleBits) {
        for bit in bits_of(samples) {
            let (row, column) = (place_of(bit) / BLOCK, place_of(bit) % BLOCK);
            if solid.nearness[row][column] > 0.0 {
                self.faces.ask(solid.face[row][column]);
            }
            if panes.nearness[row][column] > solid.nearness[row][column] {
                self.faces.ask(panes.face[row][column]);
            }
        }
    }

    /// Passes on what a block shows.
    fn collect(&mut self, tile: &Tile) {
        // Pixels on the edge between faces that look alike are shaded once.
        let parts = &mut self.parts[tile.parts.clone()];
        for Edge { faces: [first, second], second: sample } in &self.edges[tile.edges.clone()] {
            if self.faces.are_alike(*first, *second) {
                for part in parts.iter_mut() {
                    part.samples |= if part.face == *first { *sample } else { 0 };
                    part.samples &= if part.face == *second { !*sample } else { SampleBits::MAX };
                }
            }
        }
        for i in tile.parts.clone() {
            let part = self.parts[i];
            if part.samples != 0 {
                self.collect_part(tile, &part);
            }
        }
        if tile.sky != 0 {
            self.collect_sky(tile);
        }
        if let Some(panes) = self.buffer.panes(tile.number).filter(|_| tile.panes != 0) {
            let block = self.buffer.solid(tile.number);
            for bit in bits_of(tile.panes & FIRSTS) {
                let (row, column) = (place_of(bit) / BLOCK / 2, place_of(bit) % BLOCK);
                let pixel = self.pixel(tile, row, column);
                self.collect_behind_panes(two(block, row, column), two(panes, row, column), pixel);
            }
        }
    }

    fn pixel(&self, tile: &Tile, row: usize, column: usize) -> Pixel {
        let (row, column) = (tile.top + row, tile.left + column);
        Pixel { column, row, number: (row * self.width + column) as u32, place: tile.place }
    }

    #[inline]
    fn collect_part(&mut self, tile: &Tile, part: &Part) {
        let (face, kind) = self.faces.made(part.face);
        let first = self.pixel(tile, 0, 0);
        let (u, v) = first.uv();
        let nearness = self.faces.nearness_at(face, u, v);
        // A sample half-way from the first to the last column that shows it.
        let columns = [part.samples.trailing_zeros() / 8, (63 - part.samples.leading_zeros()) / 8];
        let middle = (columns[0] + columns[1]) / 2 * 8;
        let middle = middle + (part.samples >> middle).trailing_zeros();
        let (column, row) = ((middle / 8) as f32, (middle % 8 / 2) as f32);
        let there = nearness[0] + nearness[1] * column + nearness[2] * row;
        let open = self.faces.open_index(face, tile.place, u + column, v + row, there);
        let patch = Patch { face, open, target: first.number, behind: 0, u, v, nearness, weight: 1.0 };
        self.painter.push(&self.faces, kind, &patch, part.samples);
    }

    fn collect_sky(&mut self, tile: &Tile) {
        let columns = BLOCK.min(self.width - tile.left);
        for row in 0..ROWS {
            let of_row = samples_within(1, columns) << (2 * row);
            if tile.sky & of_row == of_row {
                let first = self.pixel(tile, row, 0);
                self.sky.fill(tile.left, first.row, self.painter.row(first.number as usize, columns));
                continue;
            }
            for bit in bits_of(pixels_of(tile.sky & of_row) & FIRSTS) {
                let pixel = self.pixel(tile, row, place_of(bit) % BLOCK);
                if tile.sky >> bit & 3 == 3 {
                    self.sky.fill(pixel.column, pixel.row, self.painter.row(pixel.number as usize, 1));
                } else {
                    self.add_sky(pixel);
                }
            }
        }
    }

    /// The sky in one sample of a pixel.
    fn add_sky(&mut self, pixel: Pixel) {
        self.painter.add(pixel.number, 0.5, self.sky.at(pixel.column, pixel.row));
    }

    /// A hit of one face, whose colour goes to `target`.
    fn collect_hit(&mut self, face: u32, pixel: Pixel, target: u32, weight: f32, (u, v): (f32, f32), nearness: f32) {
        let (face, kind) = self.faces.made(face);
        let open = self.faces.open_index(face, pixel.place, u, v, nearness);
        let patch = Patch { face, open, target, behind: 0, u, v, nearness: [nearness, 0.0, 0.0], weight };
        self.painter.push(&self.faces, kind, &patch, FIRST | SECOND);
    }

    /// A pixel some of whose samples lie behind panes: sample by sample, unless both agree.
    fn collect_behind_panes(&mut self, solid: Two, panes: Two, pixel: Pixel) {
        let is_before = |i: usize| panes[i].0 > solid[i].0;
        let same = |two: Two| two[0].1 == two[1].1 && two[0].0 > 0.0 && two[1].0 > 0.0;
        let none = solid[0].0 <= 0.0 && solid[1].0 <= 0.0;
        if (0..2).all(is_before) && (same(solid) || none) && same(panes) {
            let mean = |two: Two| (two[0].0 + two[1].0) * 0.5;
            self.collect_pane((mean(solid), solid[0].1), (mean(panes), panes[0].1), pixel, 1.0, pixel.uv());
            return;
        }
        for i in 0..2 {
            let uv = pixel.sample(i);
            if is_before(i) {
                self.collect_pane(solid[i], panes[i], pixel, 0.5, uv);
            } else if solid[i].0 > 0.0 {
                self.collect_hit(solid[i].1, pixel, pixel.number, 0.5, uv, solid[i].0);
            } else {
                self.add_sky(pixel);
            }
        }
    }

    fn collect_pane(&mut self, solid: (f32, u32), pane: (f32, u32), pixel: Pixel, weight: f32, (u, v): (f32, f32)) {
        let behind = if solid.0 > 0.0 {
            let behind = self.painter.new_behind([0.0; 3]);
            self.collect_hit(solid.1, pixel, behind, 1.0, (u, v), solid.0);
            behind
        } else {
            self.painter.new_behind(self.sky.at(pixel.column, pixel.row))
        };
        let (face, kind) = self.faces.made(pane.1);
        let open = self.faces.open_index(face, pixel.place, u, v, pane.0);
        let nearness = [pane.0, 0.0, 0.0];
        self.panes.push((kind, Patch { face, open, target: pixel.number, behind, u, v, nearness, weight }));
    }
}
