//! A plot beside a street, and its house.

use crate::assets::scenery::House;
use crate::math::DVec2;

/// A plot: a rectangle whose front lies along the sidewalk.
#[derive(Debug, Clone)]
pub(in crate::town) struct Plot {
    /// Middle of the front.
    pub front: DVec2,
    /// Along the front, with the traffic beside it.
    pub along: DVec2,
    /// Extent along the front.
    pub length_m: f64,
    /// Extent away from the street.
    pub depth_m: f64,
    /// Its house, if it has one.
    pub house: Option<PlacedHouse>,
}

/// A house on its plot.
#[derive(Debug, Clone)]
pub(in crate::town) struct PlacedHouse {
    pub house: House,
    /// Middle of the house along the front, from the plot's middle.
    pub along_m: f64,
    /// Distance of its front wall from the plot's front.
    pub setback_m: f64,
    /// Bays of the garage beside it, 0 for none; it stands at the end of the plot where `along` grows.
    pub garage_bays: usize,
}

impl PlacedHouse {
    /// Depth and width of what it covers.
    pub fn size_m(&self) -> DVec2 {
        self.house.model.footprint_size()
    }
}
