//! Along motorways: barriers on the median and at the edges, delineators, boards, gantries, noise walls, bridges, and what
//! grows on the slopes.

mod median_barrier;
mod road_plan;
mod road_signs;
mod shoulder_edge;
mod slope_plants;

use std::sync::Arc;

use crate::RoadNetwork;
use crate::countryside::motorway::road_plan::RoadPlan;
use crate::ground::land::fields::Land;
use crate::placement::occupancy::Occupancy;
use crate::placement::placer::{Placer, PropFootprint};
use crate::plots::frontage::{Frontage, right_of};
use cadet_assets::scenery::{BRIDGE_DECK_M, RAMP_M, SceneryModel, overpass};
use cadet_base::frames;
use cadet_base::math::{self, DVec2, DVec3};
use cadet_base::plane::OrientedRect;
use cadet_base::rng::StreamKey;

/// An abutment stands so far from the asphalt; plants keep so far from the middle of a bridge.
const ABUTMENT_OFF_M: f64 = 7.5;
const CLEAR_OF_BRIDGE_M: f64 = 21.0;

/// One side of a road: its edge, and what the land is beside it.
struct CarriagewaySide<'a> {
    frontage: &'a Frontage,
    land: &'a Land,
    plan: &'a RoadPlan,
}

impl CarriagewaySide<'_> {
    /// The place so far from the asphalt at a distance along the edge.
    fn beside(&self, at_m: f64, off_m: f64) -> DVec2 {
        let f = self.frontage;
        f.at(at_m) + right_of(f.along(at_m)) * (off_m - self.land.roadside.verge_m)
    }
}

/// Furnishes all of a motorway.
pub(super) fn furnish(
    key: &StreamKey,
    network: &RoadNetwork,
    land: &Land,
    frontages: &[Frontage],
    greenery: f64,
    taken: &mut Occupancy,
    placer: &mut Placer,
) {
    let plans = road_plan::draw(key, network);
    for road in &plans {
        if let Some(at_m) = road.bridge_m {
            build_bridge(road, at_m, land, taken, placer);
        }
        median_barrier::furnish(key, road, greenery, placer);
    }
    for (i, frontage) in frontages.iter().enumerate() {
        let Some(plan) = plans.iter().find(|p| p.road == frontage.road) else { continue };
        let side = CarriagewaySide { frontage, land, plan };
        let s = &mut key.indexed("motorway/side", i as u64);
        let posts = road_signs::place(s, &side, placer);
        shoulder_edge::furnish(s, &side, &posts, taken, placer);
        slope_plants::grow(&mut key.indexed("motorway/green", i as u64), &side, greenery, taken, placer);
    }
}

/// Stands a model at a place and height of its own.
fn stand(model: &SceneryModel, at: DVec3, facing: DVec2, placer: &mut Placer) {
    let pose = frames::upright(at, math::atan2(facing.y, facing.x));
    placer.instances.push(model.with_palette(Arc::clone(&model.palette), pose));
}

fn build_bridge(road: &RoadPlan, at_m: f64, land: &Land, taken: &mut Occupancy, placer: &mut Placer) {
    let (middle, along) = road.middle(at_m);
    let half_span_m = road.half_paved_m + ABUTMENT_OFF_M;
    let model = overpass(road.variant, half_span_m);
    stand(&model, placer.site.on_ground(middle), along, placer);
    let reach_m = RAMP_M + 10.0;
    for side in [1.0, -1.0] {
        let center = middle + along.perp() * (side * (half_span_m + reach_m / 2.0));
        taken.take(OrientedRect { center, axis: along, half: DVec2::new(CLEAR_OF_BRIDGE_M, reach_m / 2.0) });
        let center = middle + along.perp() * (side * (half_span_m + 0.7));
        let rect = OrientedRect { center, axis: along, half: DVec2::new(4.6, 0.7) };
        placer.standing.push(PropFootprint { rect, name: model.name.clone() });
    }
    debug_assert!(BRIDGE_DECK_M.0 > 4.7 && land.roadside.verge_m < ABUTMENT_OFF_M);
}
