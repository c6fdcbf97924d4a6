//! Along motorways: barriers on the median and at the edges, delineators, boards, gantries, noise walls, bridges, and what
//! grows on the slopes.

mod median_barrier;
mod road_plan;
mod road_signs;
mod shoulder_edge;
mod slope_plants;

use road_plan::{GANTRY_SHARE, RoadPlan};

use crate::countryside::Country;
use crate::network::RoadNetwork;
use crate::placement::{Placer, PropFootprint};
use crate::plots::Frontage;
use cadet_assets::scenery::{BRIDGE_DECK_M, RAMP_M, SceneryModel, overpass};
use cadet_base::frames;
use cadet_base::math::{DVec2, DVec3};
use cadet_base::plane::{OrientedRect, heading_rad};
use cadet_base::rng::StreamKey;

/// An abutment stands so far from the asphalt; plants keep so far from the middle of a bridge.
const ABUTMENT_OFF_M: f64 = 7.5;
const CLEAR_OF_BRIDGE_M: f64 = 21.0;

/// One side of a road: its edge, and how far that is from the asphalt.
struct CarriagewaySide<'a> {
    frontage: &'a Frontage,
    verge_m: f64,
    plan: &'a RoadPlan,
}

impl CarriagewaySide<'_> {
    /// The place so far from the asphalt at a distance along the edge.
    fn beside(&self, at_m: f64, off_m: f64) -> DVec2 {
        self.frontage.behind(at_m, off_m - self.verge_m)
    }

    /// How many pieces of about such a length it has, and how long they are.
    fn pieces(&self, about_m: f64) -> (usize, f64) {
        let count = (self.frontage.length_m() / about_m).round().max(1.0);
        (count as usize, self.frontage.length_m() / count)
    }
}

/// Furnishes all of a motorway.
pub(super) fn furnish(key: &StreamKey, network: &RoadNetwork, frontages: &[Frontage], country: &mut Country) {
    let plans = road_plan::draw(key, network);
    for road in &plans {
        if let Some(at_m) = road.bridge_m {
            build_bridge(road, at_m, country);
        }
        median_barrier::furnish(key, road, country.greenery, country.placer);
    }
    for (i, frontage) in frontages.iter().enumerate() {
        let Some(plan) = plans.iter().find(|p| p.road == frontage.road) else { continue };
        let side = CarriagewaySide { frontage, verge_m: country.land.roadside.verge_m, plan };
        let s = &mut key.indexed("motorway/side", i as u64);
        let posts = road_signs::place(s, &side, country.placer);
        shoulder_edge::furnish(s, &side, &posts, country);
        slope_plants::grow(&mut key.indexed("motorway/green", i as u64), &side, country);
    }
}

/// Stands a model at a place and height of its own.
fn stand(model: &SceneryModel, at: DVec3, facing: DVec2, placer: &mut Placer) {
    placer.instances.push(model.at(frames::upright(at, heading_rad(facing))));
}

fn build_bridge(road: &RoadPlan, at_m: f64, country: &mut Country) {
    let Country { land, taken, placer, .. } = country;
    let (middle, along) = road.middle(at_m);
    let half_span_m = road.half_paved_m + ABUTMENT_OFF_M;
    let model = overpass(road.variant, half_span_m);
    stand(&model, placer.site.on_ground(middle), along, placer);
    let reach_m = RAMP_M + 10.0;
    for side in [1.0, -1.0] {
        let rect = |off_m: f64, half: DVec2| OrientedRect {
            center: middle + along.perp() * (side * (half_span_m + off_m)),
            axis: along,
            half,
        };
        taken.take(rect(reach_m / 2.0, DVec2::new(CLEAR_OF_BRIDGE_M, reach_m / 2.0)));
        placer.standing.push(PropFootprint { rect: rect(0.7, DVec2::new(4.6, 0.7)), name: model.name.clone() });
    }
    debug_assert!(BRIDGE_DECK_M.0 > 4.7 && land.roadside.verge_m < ABUTMENT_OFF_M);
}
