//! What stands on the green between the two directions of a main road: trees, hedges, lamps, or nothing.

use crate::network::{Lane, LaneKind, RoadNetwork};
use crate::placement::{Boundary, Placer};
use crate::props::is_island;
use cadet_assets::props::ARM_LAMP;
use cadet_assets::scenery::{StreetLight, TreeKind, num_variants, tree};
use cadet_base::math::{DVec2, DVec3};
use cadet_base::rng::StreamKey;

/// Nothing stands nearer to the ends of a median.
const CLEAR_OF_ENDS_M: f64 = 7.0;
/// Hedges need medians this wide, trees this.
const HEDGE_FROM_M: f64 = 2.2;
const TREES_FROM_M: f64 = 1.8;
/// Pieces in which a hedge follows a bend.
const HEDGE_PIECE_M: f64 = 6.0;

/// Furnishes the medians of a network; an imported map's as well.
pub(crate) fn furnish(key: &StreamKey, network: &RoadNetwork, greenery: f64, placer: &mut Placer) {
    let is_median = |l: &&Lane| l.kind == LaneKind::Median && l.junction.is_none() && !is_island(l);
    let medians: Vec<&Lane> = network.lanes.iter().filter(is_median).collect();
    let is_first = |lane: &&&Lane| medians.iter().find(|o| o.road == lane.road).is_some_and(|o| o.id == lane.id);
    for lane in medians.iter().filter(is_first) {
        let other = medians.iter().find(|o| o.road == lane.road && o.id != lane.id).copied();
        furnish_one(key, lane, other, greenery, placer);
    }
}

/// `lane` is the half of the median on one side of the road's middle, or all of it where there is no `other`.
fn furnish_one(key: &StreamKey, lane: &Lane, other: Option<&Lane>, greenery: f64, placer: &mut Placer) {
    let s = &mut key.indexed("median", u64::from(lane.road));
    let [_, tree_variants, hedges] = num_variants();
    let width_m = lane.width_at(lane.length_m() / 2.0) + other.map_or(0.0, |o| o.width_at(o.length_m() / 2.0));
    let middle = |at_m: f64| -> (DVec2, DVec2) {
        let pose = lane.pose_at(at_m);
        let (p, along) = (pose.translation, (pose.rotation * DVec3::X).truncate().normalize_or(DVec2::X));
        let half = along.perp() * (lane.width_at(at_m) / 2.0);
        let Some(other) = other else { return (p.truncate(), along) };
        let sides = [1.0, -1.0].map(|side| p + (half * side).extend(0.0));
        let nearer = usize::from(other.project(sides[1]).1 < other.project(sides[0]).1);
        (sides[nearer].truncate(), along)
    };
    let end_m = lane.length_m() - CLEAR_OF_ENDS_M;
    let (wants_trees, wants_hedge, wants_lamps) =
        (s.chance(0.6 * greenery.min(1.5)), s.chance(0.3 * greenery.min(1.5)), s.chance(0.4));
    let (spacing_m, variant) = (s.range(7.0, 14.0), s.below(tree_variants));
    if wants_trees && width_m >= TREES_FROM_M {
        let mut at_m = CLEAR_OF_ENDS_M + s.range(0.0, 4.0);
        while at_m < end_m {
            let model = tree(TreeKind::Street, variant + s.below(2));
            let _ = placer.plant_model(TreeKind::Street, &model, s, middle(at_m).0);
            at_m += spacing_m * s.range(0.85, 1.2);
        }
    }
    if wants_hedge && width_m >= HEDGE_FROM_M {
        let boundary = Boundary::Hedge(s.below(hedges));
        let palette = boundary.palette(s);
        let mut at_m = CLEAR_OF_ENDS_M;
        while at_m + HEDGE_PIECE_M < end_m {
            placer.run(boundary, &palette, middle(at_m).0, middle(at_m + HEDGE_PIECE_M).0);
            at_m += HEDGE_PIECE_M;
        }
    }
    if wants_lamps && !wants_trees {
        let variant = s.below(ARM_LAMP.num_variants());
        let mut at_m = CLEAR_OF_ENDS_M + s.range(0.0, 12.0);
        while at_m < end_m {
            let (model, (at, along)) = (ARM_LAMP.model(variant), middle(at_m));
            let facing = along.perp() * if s.chance(0.5) { 1.0 } else { -1.0 };
            placer.put(&model, ARM_LAMP.lit(StreetLight::Neutral, variant, &model.palette), at, facing);
            at_m += s.range(28.0, 38.0);
        }
    }
}
