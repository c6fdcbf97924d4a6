//! What stands in open country: along the roads, on the fields, and where the land ends.

mod farms;
mod growth;
mod horizon;
mod motorway;
#[cfg(test)]
mod tests;
mod verges;

pub(super) use horizon::hills;

use crate::ground::land::fields::Land;
use crate::placement::occupancy::Occupancy;
use crate::placement::placer::Placer;
use crate::placement::prop_config::PropConfig;
use crate::plots::belt::StreetPoints;
use crate::plots::frontage::Frontage;
use crate::signals::Signals;
use crate::{ParkingSpot, RoadNetwork};
use cadet_base::rng::StreamKey;

/// Farther from all roads nothing is seen but the woods' outer trees.
const SEEN_M: f64 = 150.0;

/// Furnishes the land about all roads; drives of farms become places to park.
pub(super) fn furnish(
    key: &StreamKey,
    (network, signals, land): (&RoadNetwork, &Signals, &Land),
    frontages: &[Frontage],
    config: &PropConfig,
    placer: &mut Placer,
) -> Vec<ParkingSpot> {
    let streets = StreetPoints::new(frontages.iter().flat_map(|f| f.line.points().iter().step_by(4).copied()), SEEN_M);
    let mut taken = Occupancy::default();
    let mut drives = Vec::new();
    if network.is_motorway() {
        motorway::furnish(key, network, land, frontages, config.greenery, &mut taken, placer);
        growth::grow(key, &streets, config.greenery, &taken, placer);
        return drives;
    }
    for (i, frontage) in frontages.iter().enumerate() {
        let s = &mut key.indexed("country/farms", i as u64);
        farms::build(key, s, frontage, land, config, &mut taken, placer, &mut drives);
    }
    for (i, frontage) in frontages.iter().enumerate() {
        let s = &mut key.indexed("country/roadside", i as u64);
        verges::furnish((key, network, signals), s, frontage, land, config.greenery, &taken, placer);
    }
    growth::grow(key, &streets, config.greenery, &taken, placer);
    drives
}
