//! Collects the hits of a band of the image by kind, block by block of the visibility buffer: most blocks' rows show one
//! face, whose hits go into their list eight at a time.

use multiversion::multiversion;

use super::faces::{Faces, Kind, Made, NO_PLANT};
use super::look::Rays;
use super::noise::MIDDLE_PX;
use super::paint::BAND;
use super::shade::{Hit, Light, NO_SLOT};
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
    pub faces: Faces<'a>,
    /// Of the band, by kind.
    pub hits: Vec<Vec<Hit>>,
    /// Hits of panes, with their kinds.
    pub panes: Vec<(u32, Hit)>,
    /// What is seen through the band's panes.
    pub behind: Vec<[f32; 3]>,
    sky: SkyRows,
    width: usize,
    rays: &'a Rays,
    light: &'a Light,
}

/// What a row of pixels of a block shows.
#[derive(Clone, Copy, PartialEq)]
enum Row {
    /// Several faces.
    Mixed,
    Sky,
    /// One face.
    Face,
}

/// A block at a glance.
#[derive(Clone, Copy)]
struct Survey {
    rows: [Row; ROWS],
    /// Between a pixel's two samples, metres; means nothing where they see different faces.
    depth: [[f32; BLOCK]; ROWS],
}

#[multiversion(targets("x86_64+avx2"))]
fn survey(block: &Block) -> Survey {
    let mut out = Survey { rows: [Row::Mixed; ROWS], depth: [[0.0; BLOCK]; ROWS] };
    for row in 0..ROWS {
        let (a, b) = (&block.nearness[2 * row], &block.nearness[2 * row + 1]);
        let (id_a, id_b) = (&block.face[2 * row], &block.face[2 * row + 1]);
        let first = id_a[0];
        let (mut others, mut misses, mut hits) = ([0_u32; BLOCK], [0_u32; BLOCK], [0_u32; BLOCK]);
        for i in 0..BLOCK {
            others[i] = (id_a[i] ^ first) | (id_b[i] ^ first);
            misses[i] = u32::from(a[i] <= 0.0) | u32::from(b[i] <= 0.0);
            hits[i] = u32::from(a[i] > 0.0) | u32::from(b[i] > 0.0);
        }
        for i in 0..BLOCK {
            out.depth[row][i] = 2.0 / (a[i] + b[i]);
        }
        let any = |lanes: [u32; BLOCK]| lanes.into_iter().fold(0, |all, lane| all | lane) != 0;
        if !any(hits) {
            out.rows[row] = Row::Sky;
        } else if !any(misses) && !any(others) {
            out.rows[row] = Row::Face;
        }
    }
    out
}

/// A block of the band.
#[derive(Clone, Copy)]
struct Tile {
    /// Its number in the buffer.
    number: usize,
    /// Pixel row in the band, and rows and columns of it that lie in the image.
    row_in_band: usize,
    left: usize,
    rows: usize,
    columns: usize,
    survey: Survey,
}

/// A pixel.
#[derive(Clone, Copy)]
struct Place {
    column: usize,
    row: usize,
    /// Its number in the band.
    pixel: u32,
}

impl Place {
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
        width: usize,
        height: usize,
        rays: &'a Rays,
        light: &'a Light,
    ) -> Self {
        let mut hits = Vec::new();
        hits.resize_with(Kind::COUNT, Vec::new);
        Self {
            buffer,
            faces,
            hits,
            panes: Vec::new(),
            behind: Vec::new(),
            sky: SkyRows::new(width, height),
            width,
            rays,
            light,
        }
    }

    /// Collects the rows of a band; the sky goes into its colours.
    pub fn collect_band(&mut self, first_row: usize, rgb: &mut [f32]) {
        let width = self.width;
        let rows = rgb.len() / (3 * width);
        for start in (0..width).step_by(TOGETHER) {
            let mut tiles = [const { None }; TOGETHER / BLOCK * BAND / ROWS];
            let places = (0..rows)
                .step_by(ROWS)
                .flat_map(|row| (start..(start + TOGETHER).min(width)).step_by(BLOCK).map(move |left| (row, left)));
            for (tile, (row_in_band, left)) in tiles.iter_mut().zip(places) {
                let number = (first_row + row_in_band) / ROWS * self.buffer.blocks_across + left / BLOCK;
                let found = Tile {
                    number,
                    row_in_band,
                    left,
                    rows: (rows - row_in_band).min(ROWS),
                    columns: (width - left).min(BLOCK),
                    survey: survey(&self.buffer.solid[number]),
                };
                self.ask(&found);
                *tile = Some(found);
            }
            self.faces.make_asked();
            for tile in tiles.iter().flatten() {
                self.collect_tile(tile, first_row, rgb);
            }
        }
    }

    /// Asks for the faces of a block.
    fn ask(&mut self, tile: &Tile) {
        let block = &self.buffer.solid[tile.number];
        for row in 0..tile.rows {
            if let Some(panes) = self.panes_before(tile, row) {
                for i in 0..BLOCK {
                    self.ask_behind_panes(two(block, row, i), two(panes, row, i));
                }
                continue;
            }
            match tile.survey.rows[row] {
                Row::Sky => {}
                Row::Face => self.faces.ask(block.face[2 * row][0]),
                Row::Mixed => self.ask_row(block, row),
            }
        }
    }

    fn ask_row(&mut self, block: &Block, row: usize) {
        let mut last = (u32::MAX, u32::MAX);
        let [above, below] = [2 * row, 2 * row + 1];
        for i in 0..BLOCK {
            let two = (block.face[above][i], block.face[below][i]);
            match (block.nearness[above][i] > 0.0, block.nearness[below][i] > 0.0) {
                (true, true) if two != last => {
                    last = two;
                    self.faces.ask_two(two.0, two.1);
                }
                (true, false) => self.faces.ask(two.0),
                (false, true) => self.faces.ask(two.1),
                _ => {}
            }
        }
    }

    /// All faces of a pixel in a row with panes, except for panes behind what is solid.
    fn ask_behind_panes(&mut self, solid: Two, panes: Two) {
        for (solid, pane) in solid.into_iter().zip(panes) {
            if solid.0 > 0.0 {
                self.faces.ask(solid.1);
                let _ = self.faces.plant(solid.1);
            }
            if pane.0 > solid.0 {
                self.faces.ask(pane.1);
            }
        }
    }

    /// The panes of a block, if in a row of pixels any of them lies before what is solid.
    fn panes_before(&self, tile: &Tile, row: usize) -> Option<&'a Block> {
        let buffer = self.buffer;
        let (solid, panes) = (&buffer.solid[tile.number], &buffer.panes[tile.number]);
        let is_before = |line: usize| (0..BLOCK).any(|i| panes.nearness[line][i] > solid.nearness[line][i]);
        (buffer.has_panes[tile.number] && (is_before(2 * row) || is_before(2 * row + 1))).then_some(panes)
    }

    fn collect_tile(&mut self, tile: &Tile, first_row: usize, rgb: &mut [f32]) {
        let buffer = self.buffer;
        let block = &buffer.solid[tile.number];
        for row in 0..tile.rows {
            let row_in_band = tile.row_in_band + row;
            let panes = self.panes_before(tile, row);
            let mut place = Place {
                column: tile.left,
                row: first_row + row_in_band,
                pixel: (row_in_band * self.width + tile.left) as u32,
            };
            if panes.is_none() && tile.columns == BLOCK && tile.survey.rows[row] == Row::Face {
                self.collect_run(block.face[2 * row][0], place, &tile.survey.depth[row]);
                continue;
            }
            for i in 0..tile.columns {
                let solid = two(block, row, i);
                let before = panes.map(|p| two(p, row, i)).filter(|p| (0..2).any(|i| p[i].0 > solid[i].0));
                match before {
                    Some(panes) => self.collect_behind_panes(solid, panes, place, rgb),
                    None => self.collect_pixel(solid, tile.survey.depth[row][i], place, rgb),
                }
                place.column += 1;
                place.pixel += 1;
            }
        }
    }

    /// Eight pixels of a row that show one face.
    #[inline]
    fn collect_run(&mut self, face: u32, first: Place, depth: &[f32; BLOCK]) {
        let (u, v) = first.uv();
        let made = self.faces.made(face);
        let middle = BLOCK / 2;
        let open = self.faces.open_index(&made, u + middle as f32, v, depth[middle]);
        let hits = std::array::from_fn::<_, BLOCK, _>(|i| Hit {
            face: made.index,
            open,
            pixel: first.pixel + i as u32,
            slot: NO_SLOT,
            weight: 1.0,
            u: u + i as f32,
            v,
            depth: depth[i],
        });
        self.hits[made.kind as usize].extend_from_slice(&hits);
    }

    /// A pixel without panes: a hit for each of its faces. Leaves of one plant are shaded as one, by the first: they
    /// differ without order.
    #[inline]
    fn collect_pixel(&mut self, solid: Two, mean_depth: f32, place: Place, rgb: &mut [f32]) {
        let [(nearness_a, face_a), (nearness_b, face_b)] = solid;
        match (nearness_a > 0.0, nearness_b > 0.0) {
            (false, false) => {
                let color = self.sky.at(place.column, place.row, self.rays, self.light);
                rgb[place.pixel as usize * 3..place.pixel as usize * 3 + 3].copy_from_slice(&color);
            }
            (true, true) => {
                let a = self.faces.made(face_a);
                if face_a == face_b {
                    self.collect(&a, place.pixel, NO_SLOT, 1.0, place.uv(), mean_depth);
                    return;
                }
                // Where the second was not asked for, its plant is known.
                let b = self.faces.made(face_b);
                if a.plant == b.plant && a.plant != NO_PLANT {
                    self.collect(&a, place.pixel, NO_SLOT, 1.0, place.sample(0), 1.0 / nearness_a);
                } else {
                    self.collect(&a, place.pixel, NO_SLOT, 0.5, place.sample(0), 1.0 / nearness_a);
                    self.collect(&b, place.pixel, NO_SLOT, 0.5, place.sample(1), 1.0 / nearness_b);
                }
            }
            (is_first, _) => {
                let i = usize::from(!is_first);
                let made = self.faces.made(solid[i].1);
                self.collect(&made, place.pixel, NO_SLOT, 0.5, place.sample(i), 1.0 / solid[i].0);
                self.add_sky(place, rgb);
            }
        }
    }

    /// The sky in one sample of a pixel.
    fn add_sky(&mut self, place: Place, rgb: &mut [f32]) {
        let color = self.sky.at(place.column, place.row, self.rays, self.light);
        for (sum, c) in rgb[place.pixel as usize * 3..place.pixel as usize * 3 + 3].iter_mut().zip(color) {
            *sum += 0.5 * c;
        }
    }

    #[inline]
    fn collect(&mut self, face: &Made, pixel: u32, slot: u32, weight: f32, (u, v): (f32, f32), depth: f32) {
        let open = self.faces.open_index(face, u, v, depth);
        self.hits[face.kind as usize].push(Hit { face: face.index, open, pixel, slot, weight, u, v, depth });
    }

    /// A pixel some of whose samples lie behind panes: sample by sample, unless both agree.
    fn collect_behind_panes(&mut self, solid: Two, panes: Two, place: Place, rgb: &mut [f32]) {
        let is_before = |i: usize| panes[i].0 > solid[i].0;
        let same = |two: Two| two[0].1 == two[1].1 && two[0].0 > 0.0 && two[1].0 > 0.0;
        let none = solid[0].0 <= 0.0 && solid[1].0 <= 0.0;
        if (0..2).all(is_before) && (same(solid) || none) && same(panes) {
            let mean = |two: Two| (two[0].0 + two[1].0) * 0.5;
            self.collect_pane((mean(solid), solid[0].1), (mean(panes), panes[0].1), place, 1.0, place.uv());
            return;
        }
        for i in 0..2 {
            let uv = place.sample(i);
            if is_before(i) {
                self.collect_pane(solid[i], panes[i], place, 0.5, uv);
            } else if solid[i].0 > 0.0 {
                let made = self.faces.made(solid[i].1);
                self.collect(&made, place.pixel, NO_SLOT, 0.5, uv, 1.0 / solid[i].0);
            } else {
                self.add_sky(place, rgb);
            }
        }
    }

    fn collect_pane(&mut self, solid: (f32, u32), pane: (f32, u32), place: Place, weight: f32, (u, v): (f32, f32)) {
        let slot = self.behind.len() as u32;
        if solid.0 > 0.0 {
            self.behind.push([0.0; 3]);
            let made = self.faces.made(solid.1);
            self.collect(&made, place.pixel, slot, 1.0, (u, v), 1.0 / solid.0);
        } else {
            self.behind.push(self.sky.at(place.column, place.row, self.rays, self.light));
        }
        let depth = 1.0 / pane.0;
        let face = self.faces.made(pane.1);
        let open = self.faces.open_index(&face, u, v, depth);
        let hit = Hit { face: face.index, open, pixel: place.pixel, slot, weight, u, v, depth };
        self.panes.push((face.kind, hit));
    }
}
