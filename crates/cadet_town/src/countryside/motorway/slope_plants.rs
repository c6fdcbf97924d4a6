//! What grows on the slopes beside a motorway, stretch by stretch: grass, shrubs, or woods.

use crate::countryside::motorway::CarriagewaySide;
use crate::placement::occupancy::Occupancy;
use crate::placement::placer::Placer;
use cadet_assets::scenery::{TreeKind, num_variants, tree};
use cadet_base::rng::Stream;

/// Stretches of one kind of growth.
const STRETCH_M: (f64, f64) = (50.0, 260.0);
/// Nothing grows nearer to the asphalt; trees keep farther off.
const SHRUBS_FROM_M: f64 = 4.2;
const TREES_FROM_M: f64 = 6.5;

/// What grows along one stretch.
#[derive(Clone, Copy)]
enum SlopeGrowth {
    Grass,
    Scattered,
    Shrubs,
    Wooded,
}

pub(super) fn grow(s: &mut Stream, side: &CarriagewaySide, greenery: f64, taken: &Occupancy, placer: &mut Placer) {
    let length_m = side.frontage.length_m();
    let shares = [0.34 / greenery.max(0.2), 0.2, 0.2, 0.26];
    let mut from_m = 0.0;
    while greenery > 0.0 && from_m < length_m {
        let to_m = (from_m + s.range(STRETCH_M.0, STRETCH_M.1)).min(length_m);
        let growth =
            [SlopeGrowth::Grass, SlopeGrowth::Scattered, SlopeGrowth::Shrubs, SlopeGrowth::Wooded][s.weighted(&shares)];
        stretch(s, side, growth, (from_m, to_m), taken, placer);
        from_m = to_m;
    }
}

fn stretch(
    s: &mut Stream,
    side: &CarriagewaySide,
    growth: SlopeGrowth,
    (from_m, to_m): (f64, f64),
    taken: &Occupancy,
    placer: &mut Placer,
) {
    let [_, variants, ..] = num_variants();
    let reach_m = side.land.roadside.reach_m();
    // (rows, steps along them)
    let (rows, step_m) = match growth {
        SlopeGrowth::Grass => return,
        SlopeGrowth::Scattered => (1, (8.0, 34.0)),
        SlopeGrowth::Shrubs => (3, (1.6, 3.6)),
        SlopeGrowth::Wooded => (3, (2.2, 4.2)),
    };
    for row in 0..rows {
        let mut at_m = from_m + s.range(0.0, step_m.1);
        while at_m < to_m {
            let share = (f64::from(row) + s.unit()) / f64::from(rows);
            let kind = match growth {
                SlopeGrowth::Wooded if row > 0 => {
                    [TreeKind::Wood, TreeKind::Garden, TreeKind::Conifer][s.weighted(&[0.6, 0.3, 0.1])]
                }
                SlopeGrowth::Scattered => {
                    [TreeKind::Shrub, TreeKind::Garden, TreeKind::Street][s.weighted(&[0.6, 0.2, 0.2])]
                }
                _ => [TreeKind::Shrub, TreeKind::Garden][s.weighted(&[0.86, 0.14])],
            };
            let model = tree(kind, s.below(variants));
            let nearest_m = if kind == TreeKind::Shrub { SHRUBS_FROM_M } else { TREES_FROM_M };
            let off_m = (SHRUBS_FROM_M + share * (reach_m - SHRUBS_FROM_M)).max(nearest_m);
            let off_m = off_m.max(if kind == TreeKind::Shrub { model.footprint_max.x + 2.2 } else { 0.0 });
            let place = side.beside(at_m, off_m);
            if taken.is_free_at(place, 1.5) {
                let _ = placer.plant_model(kind, &model, s, place);
            }
            at_m += s.range(step_m.0, step_m.1);
        }
    }
}
