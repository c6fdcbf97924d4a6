//! What stands along motorways: barriers, noise walls, boards, gantries, bridges, and what is small.

mod bridge;
mod pieces;
mod posts;
mod writing;

use std::sync::{Arc, OnceLock};

pub use bridge::{BRIDGE_DECK_M, RAMP_M, overpass};
pub use posts::{gantry, speed_sign};

use super::{Detail, SceneryModel};
use crate::material::{Material, Palette, Pattern, Semantic};
use crate::math::DVec2;
use crate::rng::Stream;

/// Length of the pieces that barriers and noise walls come in.
pub const MOTORWAY_PIECE_M: f64 = 9.6;
/// Variants of boards and of noise walls.
pub const MOTORWAY_VARIANTS: usize = 6;

/// Pieces along +x, their front toward -y, and posts that face +x.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
pub enum MotorwayKind {
    /// A wall of concrete that throws wheels back to both sides.
    ConcreteBarrier,
    /// A steel beam to both sides of one row of posts.
    DoubleRail,
    /// A steel beam on posts.
    Rail,
    /// A wall against noise: aluminum, wood or concrete between steel posts.
    NoiseWall,
    /// A board of places and distances on two posts.
    Board,
    /// A small blue plate with the kilometer.
    KilometerPlate,
    /// An emergency telephone.
    Telephone,
}

impl MotorwayKind {
    /// Every kind.
    pub const ALL: [Self; 7] = [
        Self::ConcreteBarrier,
        Self::DoubleRail,
        Self::Rail,
        Self::NoiseWall,
        Self::Board,
        Self::KilometerPlate,
        Self::Telephone,
    ];

    /// A short name.
    #[must_use]
    pub fn name(self) -> &'static str {
        match self {
            Self::ConcreteBarrier => "concrete-barrier",
            Self::DoubleRail => "double-rail",
            Self::Rail => "motorway-rail",
            Self::NoiseWall => "noise-wall",
            Self::Board => "motorway-board",
            Self::KilometerPlate => "kilometer-plate",
            Self::Telephone => "emergency-telephone",
        }
    }

    /// Whether it is a piece of something long.
    #[must_use]
    pub fn is_piece(self) -> bool {
        matches!(self, Self::ConcreteBarrier | Self::DoubleRail | Self::Rail | Self::NoiseWall)
    }
}

/// Slots of the palette that everything here has.
pub(super) mod slot {
    /// Concrete.
    pub const CONCRETE: u8 = 0;
    /// Galvanized steel.
    pub const STEEL: u8 = 1;
    /// The face of a board.
    pub const BLUE: u8 = 2;
    /// Letters and rims.
    pub const WHITE: u8 = 3;
    /// The rim of a speed limit.
    pub const RED: u8 = 4;
    /// Its digits.
    pub const INK: u8 = 5;
    /// A telephone's housing.
    pub const ORANGE: u8 = 6;
    /// The back of a sign.
    pub const BACK: u8 = 7;
    /// Panels of a noise wall.
    pub const PANEL: u8 = 8;
    /// Grass on earth.
    pub const EARTH: u8 = 9;
    /// The road on a bridge.
    pub const ASPHALT: u8 = 10;
}

/// The colors; `panel` is that of a noise wall.
fn palette(s: &mut Stream, panel: ([f32; 3], Pattern)) -> Arc<Palette> {
    let mut tint = |rgb: [f32; 3], by: f64| {
        let scale = s.range(1.0 - by, 1.0 + by) as f32;
        rgb.map(|c| c * scale)
    };
    let mut steel = Material::matt(Semantic::Fence, tint([0.34, 0.35, 0.36], 0.12), Pattern::Plain, 0.4);
    (steel.roughness, steel.specular) = (0.5, 0.3);
    let plate = |albedo: [f32; 3], reflectance: f32| {
        let mut m = Material::matt(Semantic::TrafficSign, albedo, Pattern::Plain, reflectance);
        (m.roughness, m.specular, m.lidar.retro) = (0.5, 0.04, true);
        m
    };
    Arc::new(Palette::new(vec![
        Material::matt(Semantic::Building, tint([0.30, 0.295, 0.28], 0.12), Pattern::Render, 0.36),
        steel,
        plate([0.012, 0.055, 0.29], 0.8),
        plate([0.70, 0.70, 0.68], 0.9),
        plate([0.48, 0.03, 0.03], 0.9),
        plate([0.02, 0.02, 0.025], 0.3),
        Material::matt(Semantic::Furniture, [0.62, 0.18, 0.02], Pattern::Plain, 0.5),
        Material::matt(Semantic::TrafficSign, [0.36, 0.37, 0.38], Pattern::Plain, 0.35),
        Material::matt(Semantic::Fence, tint(panel.0, 0.1), panel.1, 0.38),
        Material::matt(Semantic::Terrain, [0.082, 0.122, 0.043], Pattern::Grass, 0.45),
        Material::matt(Semantic::Road, [0.197, 0.195, 0.191], Pattern::Asphalt, 0.23),
    ]))
}

/// What noise walls are made of: green or gray aluminum, boards, washed concrete.
const PANELS: [([f32; 3], Pattern); MOTORWAY_VARIANTS] = [
    ([0.20, 0.26, 0.20], Pattern::Plain),
    ([0.15, 0.105, 0.07], Pattern::Wood),
    ([0.29, 0.28, 0.26], Pattern::Render),
    ([0.30, 0.32, 0.33], Pattern::Plain),
    ([0.14, 0.20, 0.13], Pattern::Plain),
    ([0.30, 0.25, 0.21], Pattern::Render),
];

/// A piece or a post; a larger variant wraps.
#[must_use]
pub fn motorway_thing(kind: MotorwayKind, variant: usize) -> SceneryModel {
    const COUNT: usize = MOTORWAY_VARIANTS * MotorwayKind::ALL.len();
    static CELLS: [OnceLock<SceneryModel>; COUNT] = [const { OnceLock::new() }; COUNT];
    let variant = variant % MOTORWAY_VARIANTS;
    CELLS[kind as usize * MOTORWAY_VARIANTS + variant]
        .get_or_init(|| {
            let name = format!("{}/{variant}", kind.name());
            let palette = palette(&mut Stream::from_seed(&name, 0), PANELS[variant]);
            let limits_m = if kind.is_piece() { [30.0, 75.0, 420.0] } else { [45.0, 110.0, 420.0] };
            let shape = Detail::levels(limits_m, move |d| match kind {
                MotorwayKind::Board => posts::board(variant, d),
                MotorwayKind::KilometerPlate => posts::kilometer_plate(variant, d),
                MotorwayKind::Telephone => posts::telephone(d),
                _ => pieces::mesh(kind, variant, d),
            });
            let (low, high) = (shape.bounds.min.as_dvec3(), shape.bounds.max.as_dvec3());
            let (footprint_min, footprint_max) = if kind.is_piece() {
                (DVec2::new(0.0, low.y), DVec2::new(MOTORWAY_PIECE_M, high.y))
            } else {
                (DVec2::new(-0.15, low.y), DVec2::new(0.15, high.y))
            };
            SceneryModel { name, shape, palette, footprint_min, footprint_max, height_m: high.z }
        })
        .clone()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn everything_stands_in_the_ground_and_is_as_large_as_it_says() {
        for kind in MotorwayKind::ALL {
            for variant in 0..MOTORWAY_VARIANTS {
                let model = motorway_thing(kind, variant);
                for (_, mesh) in model.shape.levels.iter().map(|l| (l.0, &l.1)) {
                    let bounds = mesh.bounds;
                    assert!(bounds.min.z < -0.1, "{}: floats", model.name);
                    assert!((f64::from(bounds.max.z) - model.height_m).abs() < 0.16, "{}", model.name);
                    assert!(mesh.slots.iter().all(|s| usize::from(*s) < model.palette.materials().len()));
                }
                if kind.is_piece() {
                    let size = model.shape.bounds.size();
                    assert!((f64::from(size.x) - MOTORWAY_PIECE_M).abs() < 0.3, "{}: {size}", model.name);
                }
            }
        }
    }

    #[test]
    fn trucks_pass_below_bridges_and_gantries() {
        // StVZO allows 4 m; 4.5 m are kept free over carriageways (RAA).
        let over_road = |model: &SceneryModel, half_m: f32| {
            let mesh = &model.shape.levels[0].1;
            let points = mesh.faces.iter().flat_map(|f| f.map(|i| mesh.vertices[i as usize]));
            points.filter(|p| p.y.abs() < half_m && p.y.abs() > 1.2).map(|p| p.z).fold(f32::INFINITY, f32::min)
        };
        let bridge = overpass(0, 24.0);
        assert!(over_road(&bridge, 22.0) > 4.5, "{}", over_road(&bridge, 22.0));
        for variant in 0..4 {
            let gantry = gantry(variant, 8.0, 2);
            assert!(over_road(&gantry, 7.0) > 4.7, "{}", over_road(&gantry, 7.0));
        }
    }
}
