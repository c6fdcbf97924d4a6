//! What stands over motorways: gantries and bridges, as wide as the road.

mod bridge;
mod gantry;

use std::sync::Arc;

pub use bridge::{BRIDGE_DECK_M, RAMP_M, overpass};
pub use gantry::gantry;

use cadet_base::material::{Material, Palette, Pattern, Semantic};
use cadet_base::rng::Stream;

/// Length of the pieces that barriers and noise walls come in.
pub const MOTORWAY_PIECE_M: f64 = 9.6;

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
    /// The back of a board.
    pub const BACK: u8 = 4;
    /// Grass on earth.
    pub const EARTH: u8 = 5;
    /// The road on a bridge.
    pub const ASPHALT: u8 = 6;
}

/// The colors.
fn palette(s: &mut Stream) -> Arc<Palette> {
    let mut tint = |rgb: [f32; 3], by: f64| {
        let scale = s.range(1.0 - by, 1.0 + by) as f32;
        rgb.map(|c| c * scale)
    };
    let steel = Material::matt(Semantic::Fence, tint([0.34, 0.35, 0.36], 0.12), Pattern::Plain, 0.4);
    let plate = |albedo: [f32; 3], reflectance: f32| {
        let mut plate = Material::matt(Semantic::TrafficSign, albedo, Pattern::Plain, reflectance).polished(0.5, 0.04);
        plate.lidar.retro = true;
        plate
    };
    Arc::new(Palette::new(vec![
        Material::matt(Semantic::Building, tint([0.30, 0.295, 0.28], 0.12), Pattern::Render, 0.36),
        steel.polished(0.5, 0.3),
        plate([0.012, 0.055, 0.29], 0.8),
        plate([0.70, 0.70, 0.68], 0.9),
        Material::matt(Semantic::TrafficSign, [0.36, 0.37, 0.38], Pattern::Plain, 0.35),
        Material::matt(Semantic::Terrain, [0.082, 0.122, 0.043], Pattern::Grass, 0.45),
        Material::matt(Semantic::Road, [0.197, 0.195, 0.191], Pattern::Asphalt, 0.23),
    ]))
}

#[cfg(test)]
mod tests {
    use super::super::SceneryModel;
    use super::*;

    #[test]
    fn trucks_pass_below_bridges_and_gantries() {
        // StVZO allows 4 m; 4.5 m are kept free over carriageways (RAA).
        let over_road = |model: &SceneryModel, half_m: f32| {
            let mesh = &model.shape.levels[0].1;
            let points = mesh.places();
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
