//! What lies in and beside sidewalks of an inner city: pits of trees, and stones where nothing grows.

use std::sync::{Arc, OnceLock};

use super::super::SceneryModel;
use crate::geometry::{LodSet, MeshBuilder};
use crate::material::{Material, Palette, Pattern, Semantic};
use crate::math::{DVec2, Vec3};

const HALF_M: f32 = 0.62;

/// A tree's pit, flush with the sidewalk.
#[must_use]
pub fn tree_pit() -> SceneryModel {
    static CELL: OnceLock<SceneryModel> = OnceLock::new();
    CELL.get_or_init(|| {
        let mut b = MeshBuilder::new();
        let half = Vec3::new(HALF_M, HALF_M, 0.0);
        b.cuboid(-half - Vec3::Z * 0.3, half + Vec3::Z * 0.02, 1);
        let inner = half - Vec3::new(0.09, 0.09, 0.0);
        b.cuboid(-inner - Vec3::Z * 0.1, inner + Vec3::Z * 0.026, 0);
        let soil = Material::matt(Semantic::Terrain, [0.075, 0.06, 0.045], Pattern::Grass, 0.2);
        let stone = Material::matt(Semantic::Sidewalk, [0.26, 0.25, 0.24], Pattern::Plain, 0.3);
        SceneryModel {
            name: "tree-pit".to_owned(),
            shape: Arc::new(LodSet::new((60.0, b.build("tree pit", 0.7)), [])),
            palette: Arc::new(Palette::new(vec![soil, stone])),
            footprint_min: DVec2::splat(f64::from(-HALF_M)),
            footprint_max: DVec2::splat(f64::from(HALF_M)),
            height_m: 0.026,
        }
    })
    .clone()
}

/// A square of flagstones like those of sidewalks, and its side.
#[must_use]
pub fn flagstones() -> (SceneryModel, f64) {
    static CELL: OnceLock<SceneryModel> = OnceLock::new();
    const SIDE_M: f32 = 1.6;
    let model = CELL.get_or_init(|| {
        let mut b = MeshBuilder::new();
        let half = Vec3::new(SIDE_M / 2.0, SIDE_M / 2.0, 0.0);
        b.cuboid(-half - Vec3::Z * 0.25, half + Vec3::Z * 0.02, 0);
        let slabs = Material::matt(Semantic::Sidewalk, [0.30, 0.29, 0.27], Pattern::Slabs, 0.33);
        let half = DVec2::splat(f64::from(SIDE_M) / 2.0);
        SceneryModel {
            name: "flagstones".to_owned(),
            shape: Arc::new(LodSet::new((150.0, b.build("flagstones", 0.7)), [])),
            palette: Arc::new(Palette::new(vec![slabs])),
            footprint_min: -half,
            footprint_max: half,
            height_m: 0.02,
        }
    });
    (model.clone(), f64::from(SIDE_M))
}
