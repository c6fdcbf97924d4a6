//! Places along the outer edges of sidewalks.

use crate::plots::Frontage;
use cadet_assets::scenery::SceneryModel;
use cadet_base::math::DVec2;

/// Things keep this far from the ends of a frontage, where people turn the corner.
pub(super) const CORNER_M: f64 = 4.0;
/// Between a thing's back and the sidewalk's outer edge.
pub(super) const INSET_M: f64 = 0.06;

/// A place at a sidewalk's outer edge.
pub(super) struct EdgePlace {
    /// Where the model's origin goes.
    pub at: DVec2,
    pub facing: DVec2,
    /// The nearest point of the edge, and the way out of the street there.
    pub edge: DVec2,
    pub out: DVec2,
    pub sidewalk_m: f64,
}

/// A model with its back to the outer edge, looking at the street.
pub(super) fn at_edge(frontage: &Frontage, model: &SceneryModel, at_m: f64) -> EdgePlace {
    let (edge, out) = (frontage.at(at_m), frontage.out(at_m));
    let at = edge - out * (INSET_M - model.footprint_min.x);
    EdgePlace { at, facing: -out, edge, out, sidewalk_m: frontage.sidewalk_at(at_m) }
}

/// A model with its left side to the outer edge, looking at the traffic beside it.
pub(super) fn to_traffic(frontage: &Frontage, model: &SceneryModel, at_m: f64) -> EdgePlace {
    let place = along_edge(frontage, model, at_m, false);
    let off_middle_m = (model.footprint_min.y + model.footprint_max.y) / 2.0;
    EdgePlace { at: place.at - place.out * off_middle_m, ..place }
}

/// A model whose x axis runs along the edge, its origin in the middle of its width.
pub(super) fn along_edge(frontage: &Frontage, model: &SceneryModel, at_m: f64, is_forth: bool) -> EdgePlace {
    let (edge, along, out) = (frontage.at(at_m), frontage.along(at_m), frontage.out(at_m));
    let half = model.footprint_size().y / 2.0;
    let facing = if is_forth { along } else { -along };
    EdgePlace { at: edge - out * (INSET_M + half), facing, edge, out, sidewalk_m: frontage.sidewalk_at(at_m) }
}
