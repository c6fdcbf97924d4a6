//! On the median: a barrier, shrubs beside it, and the piers of bridges between.

use crate::countryside::motorway::RoadPlan;
use crate::placement::{Placer, draw_plant};
use cadet_assets::props::{CONCRETE_BARRIER, DOUBLE_RAIL, MOTORWAY_RAIL};
use cadet_assets::scenery::{MOTORWAY_PIECE_M, TreeKind};
use cadet_base::rng::StreamKey;

/// Two rows of rails stand so far from the middle where shrubs grow between them; else one row of two beams does.
const RAILS_OFF_M: f64 = 0.75;
const SHRUBS_SHARE: f64 = 0.55;
/// Shrubs grow in stretches, and leave gaps.
const STRETCH_M: (f64, f64) = (25.0, 140.0);
const SHRUB_EVERY_M: (f64, f64) = (1.3, 3.2);
const WIDEST_SHRUB_M: f64 = 1.3;
const CLEAR_OF_PIER_M: f64 = 5.0;

pub(super) fn furnish(key: &StreamKey, road: &RoadPlan, greenery: f64, placer: &mut Placer) {
    let s = &mut key.indexed("motorway/median", road.number as u64);
    // The same all along a motorway.
    let has_shrubs =
        key.stream("motorway/shrubs").chance(SHRUBS_SHARE) && !road.is_concrete && road.half_median_m > 1.6;
    let count = (road.length_m() / MOTORWAY_PIECE_M).round().max(1.0) as usize;
    let step_m = road.length_m() / count as f64;
    let (kind, offsets): (_, &[f64]) = match (road.is_concrete, has_shrubs) {
        (true, _) => (CONCRETE_BARRIER, &[0.0]),
        (_, true) => (MOTORWAY_RAIL, &[RAILS_OFF_M, -RAILS_OFF_M]),
        _ => (DOUBLE_RAIL, &[0.0]),
    };
    let model = kind.model(0);
    for k in 0..count {
        let [(a, a_along), (b, b_along)] = [k, k + 1].map(|i| road.middle(step_m * i as f64));
        for offset_m in offsets {
            let (from, to) = (a + a_along.perp() * *offset_m, b + b_along.perp() * *offset_m);
            // Fronts face -y: those to the right of the middle as they are, the others turned round.
            let [from, to] = if *offset_m > 0.0 { [to, from] } else { [from, to] };
            placer.lay_plain(&model, from, to);
        }
    }
    if !has_shrubs || greenery <= 0.0 {
        return;
    }
    let mut at_m = s.range(0.0, 30.0);
    while at_m < road.length_m() {
        let end_m = at_m + s.within(STRETCH_M);
        while at_m < end_m.min(road.length_m()) {
            let (middle, along) = road.middle(at_m);
            let place = middle + along.perp() * s.range(-0.25, 0.25);
            let model = draw_plant(TreeKind::Shrub, s);
            if model.footprint_max.x < WIDEST_SHRUB_M && road.is_clear_of_bridge(at_m, CLEAR_OF_PIER_M) {
                let _ = placer.plant_model(TreeKind::Shrub, &model, s, place);
            }
            at_m += s.within(SHRUB_EVERY_M);
        }
        at_m += s.range(5.0, 60.0);
    }
}
