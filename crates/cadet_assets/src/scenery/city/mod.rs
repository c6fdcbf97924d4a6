//! Houses of closed rows in an inner city: three to five stories at the sidewalk, shops below.

pub(super) mod city_slot;
mod colors;
mod front;
mod kind;
mod lettering;
mod plan;
mod shop;
mod span;

pub use colors::city_palette;
use colors::light_shops;
pub use kind::CityKind;
pub(super) use lettering::write as write_name;
pub(super) use shop::{Shop, gate as fill_gate};
pub use span::{SPAN_LENS_M, span_lamp};

use std::sync::Arc;

use self::plan::{Face, Side};
use super::draw::{CREASE_RAD, range};
use super::materials::house_slot as slot;
use super::wall_plane::WallPlane;
use super::{Detail, Mesh};
use cadet_base::geometry::MeshBuilder;
use cadet_base::lamp::{Lamp, LampBeam};
use cadet_base::material::Palette;
use cadet_base::math::Vec3;
use cadet_base::rng::Stream;

/// How many houses of each kind there are.
pub const NUM_CITY_HOUSES: [usize; 3] = [12, 4, 4];
/// Widths of those between two others: enough of them that most rows close.
const ROW_WIDTHS_M: [f32; 12] = [6.5, 7.8, 9.0, 10.5, 12.0, 12.8, 13.6, 14.4, 15.2, 16.2, 17.6, 19.6];

/// Width of a shop, the share of the houses whose shops are lit at night, and the light of one: how far before the wall and how high it
/// comes from, meters, and how much falls straight down.
const SHOP_M: f32 = 5.0;
const LIT_SHOPS: f64 = 0.75;
const SHOP_LIGHT_M: (f32, f32) = (0.7, 2.7);
const SHOP_CD: f32 = 90.0;
const SHOP_COLOR: [f32; 3] = [1.08, 0.99, 0.83];
const SHOP_REACH_M: f32 = 16.0;

/// The cut corner of a corner house.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct CityCorner {
    /// Which end of the front is cut: 1 where y is largest, -1 where it is smallest.
    pub side: f64,
    /// How much of both sides is cut away.
    pub cut_m: f64,
}

#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum Roof {
    Pitched,
    Mansard,
}

/// The drawn measures of one house: x is its depth, y its width along the street.
#[derive(Debug, Clone)]
pub(super) struct CityDesign {
    pub kind: CityKind,
    pub depth_m: f32,
    pub width_m: f32,
    pub cut_m: f32,
    stories: usize,
    /// Height of the ground floor, and of those over it.
    ground_m: f32,
    story_m: f32,
    roof: Roof,
    column_m: f32,
    window: (f32, f32),
    sashes: u8,
    has_shops: bool,
    has_gate: bool,
    has_surrounds: bool,
    has_dormers: bool,
    bay_share: f64,
    balcony_share: f64,
    seed: u64,
}

impl CityDesign {
    /// Draws the measures of a variant.
    pub fn new(kind: CityKind, variant: usize) -> Self {
        let s = &mut Stream::from_seed(kind.as_ref(), variant as u64);
        let is_corner = kind != CityKind::Row;
        let width_m = if is_corner { range(s, 13.0, 17.0) } else { ROW_WIDTHS_M[variant % ROW_WIDTHS_M.len()] };
        Self {
            kind,
            depth_m: if is_corner { range(s, 12.5, 14.0) } else { range(s, 12.0, 13.5) },
            width_m,
            cut_m: if is_corner { range(s, 2.8, 3.6) } else { 0.0 },
            stories: 3 + s.weighted(&[0.3, 0.48, 0.22]),
            ground_m: range(s, 3.9, 4.4),
            story_m: range(s, 3.2, 3.6),
            roof: if is_corner || s.chance(0.5) { Roof::Mansard } else { Roof::Pitched },
            column_m: range(s, 2.2, 2.7),
            window: (range(s, 1.0, 1.3), range(s, 1.65, 2.05)),
            sashes: 1 + u8::from(s.chance(0.75)),
            has_shops: s.chance(if is_corner { 0.9 } else { 0.65 }),
            has_gate: s.chance(0.35),
            has_surrounds: s.chance(0.75),
            has_dormers: s.chance(0.75),
            bay_share: 0.3,
            balcony_share: 0.4,
            seed: s.next_u64(),
        }
    }

    /// The cut corner, where there is one.
    pub fn corner(&self) -> Option<CityCorner> {
        let side = match self.kind {
            CityKind::Row => return None,
            CityKind::FirstCorner => 1.0,
            CityKind::LastCorner => -1.0,
        };
        Some(CityCorner { side, cut_m: f64::from(self.cut_m) })
    }

    /// The ways in at the front: from where to where along y.
    pub fn doorways(&self) -> Vec<[f32; 2]> {
        let front = plan::sides(self.kind, self.depth_m, self.width_m, self.cut_m)[0];
        let along = |[u0, u1]: [f32; 2]| [front.from.y + u0, front.from.y + u1];
        front::doorways(self, front.width(), 0).into_iter().map(along).collect()
    }

    /// Height of a floor: 0 is the ground floor's.
    fn floor(&self, story: usize) -> f32 {
        if story == 0 { 0.1 } else { self.ground_m + self.story_m * (story - 1) as f32 }
    }

    /// Where the walls end and the cornice begins.
    fn cornice_m(&self) -> f32 {
        self.floor(self.stories) + 0.15
    }

    /// Where the roof begins.
    fn eaves_m(&self) -> f32 {
        self.cornice_m() + 0.4
    }

    /// Insets and heights of the roof from the eaves to the top.
    fn roof_line(&self) -> Vec<(f32, f32)> {
        let (e, ridge) = (self.eaves_m(), self.depth_m / 2.0 - 0.12);
        match (self.roof, self.kind) {
            (Roof::Pitched, _) => vec![(-0.4, e + 0.08), (ridge, e + 0.08 + 0.72 * (ridge + 0.4))],
            (Roof::Mansard, CityKind::Row) => {
                vec![(0.0, e + 0.1), (0.95, e + 2.7), (ridge, e + 2.7 + 0.36 * (ridge - 0.95))]
            }
            // The ridges of the two wings would cross: their roofs end in a flat top.
            (Roof::Mansard, _) => vec![(0.0, e + 0.1), (0.95, e + 2.7), (3.6, e + 3.6)],
        }
    }

    /// The highest point of the roof.
    pub fn height(&self) -> f32 {
        self.roof_line().last().map_or(0.0, |(_, z)| *z)
    }

    /// The palette with the light of its shops, which falls on the sidewalk at night.
    pub fn lit_shops(&self, palette: Arc<Palette>) -> Arc<Palette> {
        let are_lit = self.has_shops && Stream::from_seed("lit shops", self.seed).chance(LIT_SHOPS);
        let count = if are_lit { (self.width_m / SHOP_M).floor().max(1.0) as usize } else { 0 };
        let y = |k: usize| self.width_m * ((k as f32 + 0.5) / count as f32 - 0.5);
        let lamps = (0..count).map(|k| {
            let beam = LampBeam::Luminaire { cos_ends: -0.2, cos_full: 0.6 };
            let at = Vec3::new(0.5 * self.depth_m + SHOP_LIGHT_M.0, y(k), SHOP_LIGHT_M.1);
            Lamp::of_candela(beam, at, [-Vec3::Z, Vec3::Y], SHOP_COLOR, SHOP_CD, SHOP_REACH_M)
        });
        light_shops(palette, &lamps.collect::<Vec<_>>())
    }

    /// Draws the house.
    pub fn mesh(&self, detail: Detail) -> Mesh {
        let mut b = MeshBuilder::new();
        let sides = plan::sides(self.kind, self.depth_m, self.width_m, self.cut_m);
        for (i, side) in sides.iter().enumerate() {
            let (plane, width) = (side.plane(), side.width());
            match side.face {
                Face::Street | Face::Crossing => front::draw(&mut b, self, &plane, width, i, detail),
                Face::Court => front::draw_plain(&mut b, self, (&plane, width), (i, 3.0), detail),
                // Where no neighbor hides it, a wall without windows would be all that a side street sees.
                Face::Neighbor => front::draw_plain(&mut b, self, (&plane, width), (i, 4.2), detail),
            }
        }
        self.foot(&mut b, &sides);
        self.top(&mut b, &sides, detail);
        b.build(self.kind.as_ref(), CREASE_RAD)
    }

    /// The foundation, its edge flush with the sidewalk.
    fn foot(&self, b: &mut MeshBuilder, sides: &[Side]) {
        // Its top lies below the floors of shops.
        let line = [(0.0, -1.6), (-0.12, -1.6), (-0.12, 0.03), (-0.04, 0.05), (0.0, 0.09)];
        plan::belts(b, sides, &line.map(|(inset, z)| (inset, z, slot::PLINTH)));
    }

    /// Cornice, roof, dormers, chimneys.
    fn top(&self, b: &mut MeshBuilder, sides: &[Side], detail: Detail) {
        let (c, e) = (self.cornice_m(), self.eaves_m());
        let mut line = vec![
            (0.0, c, slot::STONE),
            (-0.15, c + 0.05, slot::STONE),
            (-0.15, c + 0.2, slot::STONE),
            (-0.38, c + 0.28, slot::STONE),
            (-0.42, e, slot::METAL),
            (-0.42, e + 0.08, slot::METAL),
        ];
        if detail == Detail::Far {
            line = vec![(0.0, c, slot::STONE), (-0.42, e, slot::STONE)];
        }
        line.extend(self.roof_line().into_iter().map(|(inset, z)| (inset, z, slot::ROOF)));
        plan::belts(b, sides, &line);
        for side in sides.iter().filter(|s| matches!(s.face, Face::Street | Face::Court)) {
            if self.has_dormers && detail != Detail::Far {
                self.dormers(b, &side.plane(), side.width());
            }
        }
        let mut s = Stream::from_seed("chimneys", self.seed);
        for k in 0..2 {
            let y = self.width_m * (range(&mut s, 0.2, 0.45) * if k == 0 { -1.0 } else { 1.0 });
            let (low, high) = (self.height() - 2.2, self.height() + 0.7);
            let middle = Vec3::new(range(&mut s, -1.6, -0.4), y, (low + high) / 2.0);
            b.block(middle, Vec3::new(0.6, 1.1, high - low), slot::CHIMNEY);
        }
    }

    /// Small gabled windows in the lower part of the roof.
    fn dormers(&self, b: &mut MeshBuilder, plane: &WallPlane, width: f32) {
        let e = self.eaves_m();
        let (front, foot, top) = match self.roof {
            Roof::Mansard => (0.2, e + 0.45, e + 2.15),
            Roof::Pitched => (1.0, e + 0.9, e + 2.5),
        };
        let back = match self.roof {
            Roof::Mansard => 1.3,
            Roof::Pitched => (top - e) / 0.72 + 0.1,
        };
        let count = (width / (2.0 * self.column_m)).floor().max(1.0) as usize;
        for k in 0..count {
            let u = width * (k as f32 + 0.5) / count as f32;
            plane.block(b, [u - 0.65, u + 0.65, foot - 0.6, top], front, back, slot::WOOD);
            plane.rect(b, [u - 0.5, u + 0.5, foot, top - 0.2], front - 0.01, slot::FRAME);
            for pane in [[u - 0.43, u - 0.04], [u + 0.04, u + 0.43]] {
                plane.rect(b, [pane[0], pane[1], foot + 0.07, top - 0.27], front - 0.015, slot::DARK_GLASS);
            }
            plane.block(b, [u - 0.8, u + 0.8, top, top + 0.14], front - 0.2, back + 0.2, slot::METAL);
        }
    }
}

#[cfg(test)]
mod tests;
