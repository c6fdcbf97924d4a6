//! What stands in open country: along the roads, on the fields, and where the land ends.

mod farms;
mod growth;
mod horizon;
mod motorway;
#[cfg(test)]
mod tests;
mod verges;

pub(super) use horizon::hills;

use std::ops::Range;

use crate::ground::land::Land;
use crate::network::{ParkingSpot, RoadNetwork};
use crate::placement::{Occupancy, Placer, PropConfig};
use crate::plots::{Frontage, distance_from_streets};
use crate::signals::Signals;
use cadet_assets::scenery::{SceneryModel, TreeKind};
use cadet_base::math::DVec2;
use cadet_base::rng::{Stream, StreamKey};

/// Farther from all roads nothing is seen but the woods' outer trees.
const SEEN_M: f64 = 150.0;

/// The land that is furnished.
struct Country<'a, 'b> {
    land: &'a Land,
    greenery: f64,
    /// Plots, ways to them, bridges, and noise walls.
    taken: Occupancy,
    placer: &'a mut Placer<'b>,
}

impl Country<'_, '_> {
    /// Whether a place keeps so far from roads, and from what is taken.
    fn is_clear(&self, at: DVec2, from_roads_m: f64, from_taken_m: f64) -> bool {
        self.placer.site.is_clear(at, from_roads_m) && self.taken.is_free_at(at, from_taken_m)
    }

    /// Plants a tree or shrub where it is not in the way: where leaves hang low, farther from the carriageway.
    fn plant(&mut self, kind: TreeKind, model: &SceneryModel, s: &mut Stream, at: DVec2) {
        let from_roads_m = match kind {
            TreeKind::Street => 2.2,
            _ => (model.footprint_max.x + 0.8).clamp(1.2, 5.6),
        };
        if self.is_clear(at, from_roads_m, 2.0) {
            let _ = self.placer.plant_model(kind, model, s, at);
        }
    }
}

/// Furnishes the land about all roads; drives of farms become places to park.
pub(super) fn furnish(
    key: &StreamKey,
    (network, signals, land): (&RoadNetwork, &Signals, &Land),
    frontages: &[Frontage],
    config: &PropConfig,
    placer: &mut Placer,
) -> Vec<ParkingSpot> {
    let streets = distance_from_streets(frontages, 4, SEEN_M);
    let country = &mut Country { land, greenery: config.greenery, taken: Occupancy::default(), placer };
    let mut drives = Vec::new();
    if network.is_motorway() {
        motorway::furnish(key, network, frontages, country);
    } else {
        for (i, frontage) in frontages.iter().enumerate() {
            let s = &mut key.indexed("country/farms", i as u64);
            farms::build(key, s, frontage, config, country, &mut drives);
        }
        for (i, frontage) in frontages.iter().enumerate() {
            let s = &mut key.indexed("country/roadside", i as u64);
            verges::furnish((key, network, signals), s, frontage, country);
        }
    }
    growth::grow(key, &streets, country);
    drives
}

/// The runs of pieces that are wanted.
fn runs(wanted: &[bool]) -> Vec<Range<usize>> {
    let pieces: Vec<usize> = (0..wanted.len()).filter(|k| wanted[*k]).collect();
    pieces.chunk_by(|a, b| b - a == 1).map(|run| run[0]..run[run.len() - 1] + 1).collect()
}
