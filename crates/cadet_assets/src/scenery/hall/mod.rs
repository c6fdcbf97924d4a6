//! Large buildings on lots of their own: supermarkets, works, offices, institutes.

mod colors;
mod fronts;
mod parts;
#[cfg(test)]
mod tests;

pub use colors::hall_palette;

use strum::{AsRefStr, VariantArray};

use super::draw::{CREASE_RAD, range};

use super::wall_plane::WallPlane;
use super::{Detail, Mesh, roof};
use cadet_base::geometry::MeshBuilder;

use cadet_base::rng::Stream;

/// How many buildings of each kind there are.
pub const HALL_VARIANTS: usize = 8;
/// Walls go on so far below the ground: lots are not level.
const FOOT_M: f32 = -1.8;
/// Rise over run of the roofs of works.
const SHALLOW: f32 = 0.12;

/// What a large building is for.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, AsRefStr, VariantArray)]
#[strum(serialize_all = "lowercase")]
pub enum HallKind {
    /// One story with a glass entrance under a sign.
    Market,
    /// A hall with roller gates, docks, and bands of windows.
    Works,
    /// Two to four floors of offices.
    Office,
    /// Three to five floors with bands of windows and a stairwell of glass.
    Institute,
}

/// What the walls are clad with.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Cladding {
    /// Corrugated sheet, its ribs upright.
    Sheet,
    /// Panels with seams.
    Panels,
    /// Masonry, render, or concrete.
    Plain,
}

/// The drawn measures of one building: x is its depth (the front at +x), y its width along the street.
#[derive(Debug, Clone)]
pub(super) struct HallDesign {
    kind: HallKind,
    pub depth_m: f32,
    pub width_m: f32,
    /// Height of the walls.
    eaves_m: f32,
    floors: usize,
    cladding: Cladding,
    has_gables: bool,
    seed: u64,
}

impl HallDesign {
    /// Draws the measures of a variant.
    pub fn new(kind: HallKind, variant: usize) -> Self {
        let s = &mut Stream::from_seed(kind.as_ref(), variant as u64);
        // Small ones and large ones, so that one fits most lots.
        let size = (variant % HALL_VARIANTS) as f32 / (HALL_VARIANTS - 1) as f32;
        let between =
            |s: &mut Stream, lo: f32, hi: f32| lo + (hi - lo) * (size + range(s, -0.08, 0.08)).clamp(0.0, 1.0);
        let (depth_m, width_m, floors) = match kind {
            HallKind::Market => (between(s, 17.0, 30.0), between(s, 22.0, 44.0), 1),
            HallKind::Works => (between(s, 15.0, 40.0), between(s, 20.0, 60.0), 1),
            HallKind::Office => (between(s, 10.0, 15.0), between(s, 14.0, 34.0), 2 + s.below(3)),
            HallKind::Institute => (between(s, 12.0, 16.0), between(s, 20.0, 52.0), 3 + s.below(3)),
        };
        let eaves_m = match kind {
            HallKind::Market => range(s, 5.2, 6.8),
            HallKind::Works => range(s, 6.0, 11.0),
            HallKind::Office => 0.5 + 3.3 * floors as f32,
            HallKind::Institute => 0.6 + 3.7 * floors as f32,
        };
        let cladding = match (kind, s.below(3)) {
            (HallKind::Works, 0 | 1) => Cladding::Sheet,
            (HallKind::Works, _) | (HallKind::Market, 0 | 1) => Cladding::Panels,
            _ => Cladding::Plain,
        };
        let has_gables = kind == HallKind::Works && s.chance(0.5);
        Self { kind, depth_m, width_m, eaves_m, floors, cladding, has_gables, seed: s.next_u64() }
    }

    /// The highest point, what stands on the roof left out.
    pub fn height(&self) -> f32 {
        if self.has_gables { self.eaves_m + SHALLOW * self.depth_m / 2.0 + 0.2 } else { self.eaves_m + 0.28 }
    }

    /// Draws the building.
    pub fn mesh(&self, detail: Detail) -> Mesh {
        let mut b = MeshBuilder::new();
        for (i, (plane, length_m)) in WallPlane::around(self.depth_m, self.width_m).iter().enumerate() {
            let rise_m = if self.has_gables && i % 2 == 1 { SHALLOW * self.depth_m / 2.0 } else { 0.0 };
            fronts::draw(&mut b, self, plane, (*length_m, rise_m), i, detail);
        }
        if self.has_gables {
            let pitched = roof::Pitched {
                length_m: self.width_m,
                span_m: self.depth_m,
                eaves_m: self.eaves_m,
                slope: SHALLOW,
                overhang_m: 0.3,
                hipped: false,
            };
            // Sheets have no courses.
            pitched.draw(&mut b, if detail == Detail::Near { Detail::Mid } else { detail });
        } else {
            roof::flat(&mut b, self.depth_m / 2.0, self.width_m / 2.0, self.eaves_m - 0.1);
        }
        if detail != Detail::Far {
            parts::on_roof(&mut b, self);
        }
        b.build(self.kind.as_ref(), CREASE_RAD)
    }

    /// Whether offices are stacked in it.
    fn has_floors(&self) -> bool {
        self.floors > 1
    }

    /// Height of a floor.
    fn floor(&self, story: usize) -> f32 {
        let each = (self.eaves_m - 0.4) / self.floors as f32;
        0.1 + each * story as f32
    }
}
