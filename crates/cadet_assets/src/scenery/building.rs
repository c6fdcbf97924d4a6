//! Houses as those who place them know them: a prototype, and what its design says of it.

use std::sync::Arc;

use super::city::CityDesign;
use super::house::HouseDesign;
use super::materials::house_palette;
use super::{CityCorner, HouseKind, SceneryModel, city_palette};
use cadet_base::material::Palette;
use cadet_base::rng::Stream;

/// A house.
#[derive(Debug, Clone)]
pub struct House {
    /// The prototype.
    pub model: SceneryModel,
    pub(super) design: Design,
}

/// What a house was drawn from.
#[derive(Debug, Clone)]
pub(super) enum Design {
    /// In a garden of its own, or on the sidewalk's line of a village.
    Garden(HouseDesign),
    /// In a closed row.
    Row(CityDesign),
}

impl House {
    /// What kind it is; `None` in a closed row.
    #[must_use]
    pub fn kind(&self) -> Option<HouseKind> {
        match &self.design {
            Design::Garden(design) => Some(design.kind),
            Design::Row(_) => None,
        }
    }

    /// Whether it stands in a closed row.
    #[must_use]
    pub fn is_in_row(&self) -> bool {
        self.kind().is_none()
    }

    /// Its cut corner, where it stands at the end of a closed row.
    #[must_use]
    pub fn corner(&self) -> Option<CityCorner> {
        match &self.design {
            Design::Garden(_) => None,
            Design::Row(design) => design.corner(),
        }
    }

    /// The ways in at its front: from where to where along y, meters.
    #[must_use]
    pub fn doorways_m(&self) -> Vec<[f64; 2]> {
        let doorways = match &self.design {
            Design::Garden(design) => design.doorways(),
            Design::Row(design) => design.doorways(),
        };
        doorways.into_iter().map(|doorway| doorway.map(f64::from)).collect()
    }

    /// Draws colors for it.
    #[must_use]
    pub fn draw_palette(&self, stream: &mut Stream) -> Arc<Palette> {
        match &self.design {
            Design::Garden(design) => house_palette(stream, design.flat_roof),
            Design::Row(design) => design.lit_shops(city_palette(stream)),
        }
    }
}
