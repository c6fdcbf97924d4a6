//! What grows on the slopes beside a motorway, stretch by stretch: grass, shrubs, or woods.

use crate::countryside::Country;
use crate::countryside::motorway::CarriagewaySide;
use crate::placement::draw_plant;
use cadet_assets::scenery::TreeKind;
use cadet_base::rng::Stream;

/// Stretches of one kind of growth.
const STRETCH_M: (f64, f64) = (50.0, 260.0);
/// Nothing grows nearer to the asphalt; trees keep farther off.
const SHRUBS_FROM_M: f64 = 4.2;
const TREES_FROM_M: f64 = 6.5;

/// What grows along one stretch, in rows: in all but the first taller kinds where a stretch has some.
struct SlopeGrowth {
    rows: u32,
    step_m: (f64, f64),
    kinds: &'static [(TreeKind, f64)],
    kinds_behind: &'static [(TreeKind, f64)],
}

const MOSTLY_SHRUBS: &[(TreeKind, f64)] = &[(TreeKind::Shrub, 0.86), (TreeKind::Garden, 0.14)];
const SINGLE: &[(TreeKind, f64)] = &[(TreeKind::Shrub, 0.6), (TreeKind::Garden, 0.2), (TreeKind::Street, 0.2)];
const WOODS: &[(TreeKind, f64)] = &[(TreeKind::Wood, 0.6), (TreeKind::Garden, 0.3), (TreeKind::Conifer, 0.1)];
const GRASS: SlopeGrowth = SlopeGrowth { rows: 0, step_m: (1.0, 1.0), kinds: &[], kinds_behind: &[] };
const SCATTERED: SlopeGrowth = SlopeGrowth { rows: 1, step_m: (8.0, 34.0), kinds: SINGLE, kinds_behind: SINGLE };
const SHRUBS: SlopeGrowth =
    SlopeGrowth { rows: 3, step_m: (1.6, 3.6), kinds: MOSTLY_SHRUBS, kinds_behind: MOSTLY_SHRUBS };
const WOODED: SlopeGrowth = SlopeGrowth { rows: 3, step_m: (2.2, 4.2), kinds: MOSTLY_SHRUBS, kinds_behind: WOODS };

pub(super) fn grow(s: &mut Stream, side: &CarriagewaySide, country: &mut Country) {
    let length_m = side.frontage.length_m();
    let growths = [(&GRASS, 0.34 / country.greenery.max(0.2)), (&SCATTERED, 0.2), (&SHRUBS, 0.2), (&WOODED, 0.26)];
    let mut from_m = 0.0;
    while country.greenery > 0.0 && from_m < length_m {
        let to_m = (from_m + s.within(STRETCH_M)).min(length_m);
        let growth = s.pick(&growths);
        stretch(s, side, growth, (from_m, to_m), country);
        from_m = to_m;
    }
}

fn stretch(
    s: &mut Stream,
    side: &CarriagewaySide,
    growth: &SlopeGrowth,
    (from_m, to_m): (f64, f64),
    country: &mut Country,
) {
    let reach_m = country.land.roadside.reach_m();
    for row in 0..growth.rows {
        let mut at_m = from_m + s.range(0.0, growth.step_m.1);
        while at_m < to_m {
            let share = (f64::from(row) + s.unit()) / f64::from(growth.rows);
            let kind = s.pick(if row > 0 { growth.kinds_behind } else { growth.kinds });
            let model = draw_plant(kind, s);
            let nearest_m = match kind {
                TreeKind::Shrub => SHRUBS_FROM_M.max(model.footprint_max.x + 2.2),
                _ => TREES_FROM_M,
            };
            let off_m = (SHRUBS_FROM_M + share * (reach_m - SHRUBS_FROM_M)).max(nearest_m);
            let place = side.beside(at_m, off_m);
            if country.taken.is_free_at(place, 1.5) {
                let _ = country.placer.plant_model(kind, &model, s, place);
            }
            at_m += s.within(growth.step_m);
        }
    }
}
