//! Collects the hits of a band of the image by kind, block by block of the visibility buffer: many blocks' rows show one
//! face, whose hits go into their list eight at a time.

use std::ops::Range;

use multiversion::multiversion;

use super::faces::{Faces, Place};
use super::hits::{Hit, RUN};
use super::look::{Rays, View};
use super::noise::MIDDLE_PX;
use super::paint::{BAND, Painter};
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

/// Hits of a band, and what is known of their faces.
pub struct Collector<'a> {
    buffer: &'a VisibilityBuffer,
    faces: Faces<'a>,
    painter: Painter<'a>,
    /// Hits of panes, with their kinds and the pixels that have what is behind.
    panes: Vec<(u32, u32, Hit)>,
    sky: SkyRows<'a>,
    width: usize,
    intrinsics: [f64; 4],
}

/// What a row of pixels of a block shows, a bit a pixel.
#[derive(Clone, Copy, Default)]
struct Row {
    /// The first sample sees something solid; the second does.
    hits: [u32; 2],
    /// Both samples see one face.
    whole: u32,
    /// Both samples of the pixel and of the next see one face.
    joined: u32,
}

impl Row {
    const ALL: u32 = (1 << BLOCK) - 1;

    fn is_sky(&self) -> bool {
        self.hits[0] | self.hits[1] == 0
    }

    /// All samples see one face.
    fn is_one_face(&self) -> bool {
        self.joined == Self::ALL >> 1
    }

    /// How many pixels from one on show its face; the pixel must be `whole`.
    fn run_from(&self, i: usize) -> usize {
        1 + (self.joined >> i).trailing_ones() as usize
    }
}

#[multiversion(targets("x86_64+avx512f+avx512bw+avx512dq+avx512vl", "x86_64+avx2"))]
fn survey(block: &Block) -> [Row; ROWS] {
    let mut out = [Row::default(); ROWS];
    for (row, out) in out.iter_mut().enumerate() {
        let (a, b) = (&block.nearness[2 * row], &block.nearness[2 * row + 1]);
        let (id_a, id_b) = (&block.face[2 * row], &block.face[2 * row + 1]);
        let (mut hit_a, mut hit_b, mut same, mut next) = ([0_u32; BLOCK], [0_u32; BLOCK], [0; BLOCK], [0; BLOCK]);
        for i in 0..BLOCK {
            hit_a[i] = u32::from(a[i] > 0.0) << i;
            hit_b[i] = u32::from(b[i] > 0.0) << i;
            same[i] = u32::from(id_a[i] == id_b[i]) << i;
        }
        for i in 0..BLOCK - 1 {
            next[i] = u32::from(id_a[i] == id_a[i + 1]) << i;
        }
        let bits = |lanes: [u32; BLOCK]| lanes.into_iter().fold(0, |all, lane| all | lane);
        let hits = [bits(hit_a), bits(hit_b)];
        let whole = bits(same) & hits[0] & hits[1];
        *out = Row { hits, whole, joined: bits(next) & whole & whole >> 1 };
    }
    out
}

/// Depths of a row of pixels, each between its two samples; mean nothing where these do not see one face.
type Depths = [f32; 2 * BLOCK];

#[inline]
fn depths_of(block: &Block, row: usize) -> Depths {
    let (a, b) = (&block.nearness[2 * row], &block.nearness[2 * row + 1]);
    let mut depths = [1.0; 2 * BLOCK];
    for i in 0..BLOCK {
        depths[i] = 2.0 / (a[i] + b[i]);
    }
    depths
}

/// A block of the band.
#[derive(Clone, Copy)]
struct Tile {
    /// Its number in the buffer.
    number: usize,
    place: Place,
    /// First pixel row and column, and rows and columns of it that lie in the image.
    top: usize,
    left: usize,
    rows: usize,
    columns: usize,
    shown: Shown,
}

/// What a block shows.
#[derive(Clone, Copy)]
enum Shown {
    /// A single face and no pane.
    Face(u32),
    Rows([Row; ROWS]),
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
        Self { buffer, faces, painter, panes: Vec::new(), sky, width: view.width, intrinsics: view.intrinsics }
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
            for (tile, (row, left)) in tiles.iter_mut().zip(places) {
                let (number, square) = (number_of(first_row + row, left), number_of(first_row, left));
                let only = self.buffer.only_face(number);
                let found = Tile {
                    number,
                    place: Place { block: number as u32, square: square as u32 },
                    top: first_row + row,
                    left,
                    rows: (rows - row).min(ROWS),
                    columns: (width - left).min(BLOCK),
                    shown: only.map_or_else(|| Shown::Rows(survey(self.buffer.solid(number))), Shown::Face),
                };
                self.ask(&found);
                *tile = Some(found);
            }
            self.faces.make_asked();
            for tile in tiles.iter().flatten() {
                self.collect_tile(tile);
            }
        }
        if !self.panes.is_empty() {
            // Panes come after what they show.
            self.painter.shade_all(&self.faces);
            self.panes.sort_by_key(|(kind, ..)| *kind);
            for (kind, behind, hit) in self.panes.drain(..) {
                self.painter.push_pane(&self.faces, kind, &hit, behind);
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

    /// Asks for the faces of a block.
    fn ask(&mut self, tile: &Tile) {
        let survey = match &tile.shown {
            Shown::Face(face) => return self.faces.ask(*face),
            Shown::Rows(rows) => rows,
        };
        let block = self.buffer.solid(tile.number);
        for row in 0..tile.rows {
            if let Some(panes) = self.panes_before(tile, row) {
                for i in 0..BLOCK {
                    self.ask_behind_panes(two(block, row, i), two(panes, row, i));
                }
                continue;
            }
            let shown = &survey[row];
            // Where something else begins.
            let mut first = (shown.hits[0] | shown.hits[1]) & !(shown.joined << 1);
            while first != 0 {
                let i = first.trailing_zeros() as usize % BLOCK;
                first &= first - 1;
                let (a, b) = (block.face[2 * row][i], block.face[2 * row + 1][i]);
                match shown.hits.map(|bits| bits >> i & 1) {
                    [1, 1] => self.faces.ask_two(a, b),
                    [1, _] => self.faces.ask(a),
                    _ => self.faces.ask(b),
                }
            }
        }
    }

    /// All faces of a pixel in a row with panes, except for panes behind what is solid.
    fn ask_behind_panes(&mut self, solid: Two, panes: Two) {
        for (solid, pane) in solid.into_iter().zip(panes) {
            if solid.0 > 0.0 {
                self.faces.ask(solid.1);
            }
            if pane.0 > solid.0 {
                self.faces.ask(pane.1);
            }
        }
    }

    /// The panes of a block, if in a row of pixels any of them lies before what is solid.
    fn panes_before(&self, tile: &Tile, row: usize) -> Option<&'a Block> {
        let buffer = self.buffer;
        let (solid, panes) = (buffer.solid(tile.number), buffer.panes(tile.number)?);
        let is_before = |line: usize| (0..BLOCK).any(|i| panes.nearness[line][i] > solid.nearness[line][i]);
        (is_before(2 * row) || is_before(2 * row + 1)).then_some(panes)
    }

    fn collect_tile(&mut self, tile: &Tile) {
        let buffer = self.buffer;
        let survey = match &tile.shown {
            Shown::Face(face) => return self.collect_face(tile, *face),
            Shown::Rows(rows) => rows,
        };
        let block = buffer.solid(tile.number);
        for row in 0..tile.rows {
            let line = tile.top + row;
            let first = line * self.width + tile.left;
            let pixel = Pixel { column: tile.left, row: line, number: first as u32, place: tile.place };
            if let Some(panes) = self.panes_before(tile, row) {
                let depths = depths_of(block, row);
                for i in 0..tile.columns {
                    let (solid, panes) = (two(block, row, i), two(panes, row, i));
                    if (0..2).any(|i| panes[i].0 > solid[i].0) {
                        let pixel = Pixel { column: tile.left + i, number: (first + i) as u32, ..pixel };
                        self.collect_behind_panes(solid, panes, pixel);
                    } else {
                        let _ = self.collect_pixel(block, row, survey[row], i..i + 1, &depths, pixel);
                    }
                }
                continue;
            }
            let shown = survey[row];
            if shown.is_sky() {
                self.sky.fill(tile.left, line, self.painter.row(first, tile.columns));
                continue;
            }
            let depths = depths_of(block, row);
            if shown.is_one_face() {
                self.collect_run(block.face[2 * row][0], pixel, &depths, 0..tile.columns);
                continue;
            }
            let mut i = 0;
            while i < tile.columns {
                i += self.collect_pixel(block, row, shown, i..tile.columns, &depths, pixel);
            }
        }
    }

    /// A block without panes that shows one face: its depths follow from the face's plane.
    fn collect_face(&mut self, tile: &Tile, face: u32) {
        let [first, by_column, by_row] = self.buffer.faces[face as usize].nearness_on_image(self.intrinsics);
        let middle = f64::from(MIDDLE_PX);
        let (left, top) = (tile.left as f64 + middle, tile.top as f64 + middle);
        let (mut nearness, by_column) = ((first + by_column * left + by_row * top) as f32, by_column as f32);
        for line in tile.top..tile.top + tile.rows {
            let mut depths = [1.0; 2 * BLOCK];
            for i in 0..BLOCK {
                depths[i] = 1.0 / (nearness + by_column * i as f32);
            }
            let number = (line * self.width + tile.left) as u32;
            let pixel = Pixel { column: tile.left, row: line, number, place: tile.place };
            self.collect_run(face, pixel, &depths, 0..tile.columns);
            nearness += by_row as f32;
        }
    }

    /// Neighbouring pixels of a block's row that show one face: of `first` in the first column.
    #[inline]
    fn collect_run(&mut self, face: u32, first: Pixel, mean_depth: &Depths, columns: Range<usize>) {
        let (index, kind) = self.faces.made(face);
        let (from, count) = (columns.start, columns.len());
        let (u, v) = ((first.column + from) as f32 + MIDDLE_PX, first.row as f32 + MIDDLE_PX);
        let middle = count / 2;
        let Some(depth) = mean_depth[from.min(BLOCK)..].first_chunk::<RUN>() else { return };
        let open = self.faces.open_index(index, first.place, u + middle as f32, v, depth[middle % RUN]);
        let hit = Hit { face: index, open, target: first.number + from as u32, weight: 1.0, u, v, depth: 0.0 };
        self.painter.push_run(&self.faces, kind, &hit, depth, count);
    }

    /// A pixel without panes, or several that show one face: a hit for each of its faces. Faces of one plant are shaded as
    /// one, by the first: they differ without order; so are faces that are alike. `first` is the pixel in column 0. Returns
    /// how many pixels these were.
    #[inline]
    fn collect_pixel(
        &mut self,
        block: &Block,
        row: usize,
        shown: Row,
        columns: Range<usize>,
        depths: &Depths,
        first: Pixel,
    ) -> usize {
        let i = columns.start % BLOCK;
        let [a, b] = two(block, row, i);
        if shown.whole >> i & 1 == 1 {
            let count = shown.run_from(i).min(columns.len());
            self.collect_run(a.1, first, depths, i..i + count);
            return count;
        }
        let pixel = Pixel { column: first.column + i, number: first.number + i as u32, ..first };
        let at = pixel.number;
        match (shown.hits[0] >> i & 1 == 1, shown.hits[1] >> i & 1 == 1) {
            (true, true) if self.faces.are_of_one_plant(a.1, b.1) => {
                self.collect(a.1, pixel, at, 1.0, pixel.sample(0), 1.0 / a.0);
            }
            (true, true) if self.faces.are_alike(a.1, b.1) => {
                self.collect(a.1, pixel, at, 1.0, pixel.uv(), depths[i]);
            }
            (false, false) => self.sky.fill(pixel.column, pixel.row, self.painter.row(at as usize, 1)),
            hits => {
                for (k, (nearness, face), is_hit) in [(0, a, hits.0), (1, b, hits.1)] {
                    if is_hit {
                        self.collect(face, pixel, at, 0.5, pixel.sample(k), 1.0 / nearness);
                    } else {
                        self.add_sky(pixel);
                    }
                }
            }
        }
        1
    }

    /// The sky in one sample of a pixel.
    fn add_sky(&mut self, pixel: Pixel) {
        self.painter.add(pixel.number, 0.5, self.sky.at(pixel.column, pixel.row));
    }

    /// A hit of one face, whose colour goes to `target`.
    #[inline]
    fn collect(&mut self, face: u32, pixel: Pixel, target: u32, weight: f32, (u, v): (f32, f32), depth: f32) {
        let (index, kind) = self.faces.made(face);
        let open = self.faces.open_index(index, pixel.place, u, v, depth);
        self.painter.push(&self.faces, kind, &Hit { face: index, open, target, weight, u, v, depth });
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
                self.collect(solid[i].1, pixel, pixel.number, 0.5, uv, 1.0 / solid[i].0);
            } else {
                self.add_sky(pixel);
            }
        }
    }

    fn collect_pane(&mut self, solid: (f32, u32), pane: (f32, u32), pixel: Pixel, weight: f32, (u, v): (f32, f32)) {
        let behind = if solid.0 > 0.0 {
            let behind = self.painter.new_behind([0.0; 3]);
            self.collect(solid.1, pixel, behind, 1.0, (u, v), 1.0 / solid.0);
            behind
        } else {
            self.painter.new_behind(self.sky.at(pixel.column, pixel.row))
        };
        let depth = 1.0 / pane.0;
        let (face, kind) = self.faces.made(pane.1);
        let open = self.faces.open_index(face, pixel.place, u, v, depth);
        self.panes.push((kind, behind, Hit { face, open, target: pixel.number, weight, u, v, depth }));
    }
}
