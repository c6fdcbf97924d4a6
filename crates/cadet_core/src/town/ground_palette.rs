//! What the ground is made of.

use super::ground_mesh::Cover;
use crate::material::{Material, Palette, Pattern, Semantic};

pub(super) const ASPHALT: u8 = 0;
pub(super) const SIDEWALK: u8 = 1;
pub(super) const CURB: u8 = 2;
pub(super) const TERRAIN: u8 = 3;
pub(super) const MARKING: u8 = 4;
pub(super) const YELLOW_MARKING: u8 = 5;

pub(super) fn slot(cover: Cover) -> u8 {
    match cover {
        Cover::Carriageway => ASPHALT,
        Cover::CurbStone => CURB,
        Cover::Sidewalk => SIDEWALK,
        Cover::Terrain => TERRAIN,
    }
}

/// Old dry asphalt, concrete slabs and curb stones, grass, worn paint; reflectances at 905 nm.
pub(super) fn palette() -> Palette {
    Palette::new(vec![
        Material::matt(Semantic::Road, [0.115, 0.113, 0.110], Pattern::Asphalt, 0.23),
        Material::matt(Semantic::Sidewalk, [0.30, 0.29, 0.27], Pattern::Slabs, 0.33),
        Material::matt(Semantic::Sidewalk, [0.36, 0.35, 0.33], Pattern::Plain, 0.36),
        Material::matt(Semantic::Terrain, [0.075, 0.115, 0.040], Pattern::Grass, 0.45),
        Material::matt(Semantic::RoadMarking, [0.55, 0.55, 0.53], Pattern::Plain, 0.45),
        Material::matt(Semantic::RoadMarking, [0.55, 0.40, 0.09], Pattern::Plain, 0.45),
    ])
}
