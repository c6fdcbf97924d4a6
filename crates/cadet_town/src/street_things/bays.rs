//! What stands in parking places instead of cars.

use crate::network::{ParkingSpot, SpotKind};
use crate::placement::footprint;
use crate::street_things::Furnisher;
use cadet_assets::props::{BARRIER, BICYCLE, Place, Prop};
use cadet_base::math::DVec2;
use cadet_base::rng::Stream;

/// Share of the places along curbs that hold a row of bicycles instead of a car.
const CYCLES_SHARE: f64 = 0.0036;
/// No more than this share of them holds something else than a car.
const MOST_FILLED_SHARE: f64 = 0.3;
/// A thing in a place reaches no farther toward the lane than a car does.
const OVER_WIDTH_M: f64 = 0.05;

/// Fills a parking place, now and then.
pub(super) fn fill(f: &mut Furnisher, spot: &ParkingSpot, clutter: f64, s: &mut Stream) {
    if matches!(spot.kind, SpotKind::Drive | SpotKind::Lot | SpotKind::Yard) {
        return;
    }
    let rules = f.own.placed(|place| if let Place::Bay(rule) = place { Some(*rule) } else { None });
    let shares: Vec<f64> = rules.iter().map(|(_, rule)| rule.share).chain([CYCLES_SHARE]).collect();
    if !s.chance((shares.iter().sum::<f64>() * clutter).min(MOST_FILLED_SHARE)) {
        return;
    }
    match rules.get(s.weighted(&shares)) {
        Some((prop, rule)) => {
            put(f, spot, prop, s, !rule.is_ahead, DVec2::ZERO);
            if rule.has_barriers {
                barriers(f, spot, s);
            }
        }
        None => cycles(f, spot, s),
    }
}

/// Puts one into the place, `offset` from its middle in its own frame; the first size that fits. Its long side is along the
/// curb, or it stands as a car would.
fn put(f: &mut Furnisher, spot: &ParkingSpot, prop: &Prop, s: &mut Stream, is_across: bool, offset: DVec2) {
    let place = spot.rect();
    let first = s.below(prop.num_variants());
    let mut colors = Stream::from_seed("bay", s.next_u64());
    let facing = if is_across { -place.axis.perp() } else { place.axis };
    let at = place.center + place.axis * offset.x + place.axis.perp() * offset.y;
    for k in 0..prop.num_variants() {
        let model = prop.model(first + k);
        let middle = (model.footprint_min + model.footprint_max) / 2.0;
        let axis = facing.normalize();
        let at = at - axis * middle.x - axis.perp() * middle.y;
        let rect = footprint(&model, at, facing);
        let reach = if is_across { DVec2::new(rect.half.y, rect.half.x) } else { rect.half };
        let fits =
            reach.x + offset.x.abs() <= place.half.x + 0.1 && reach.y + offset.y.abs() <= place.half.y + OVER_WIDTH_M;
        if fits && f.taken.is_free(&rect) && f.ways.is_free(&rect) {
            f.stand_in_the_way(&prop.draw_variant(first + k, &mut colors), at, facing, rect);
            return;
        }
    }
}

/// At both ends of the place.
fn barriers(f: &mut Furnisher, spot: &ParkingSpot, s: &mut Stream) {
    for side in [-1.0, 1.0] {
        let offset = DVec2::new(side * (spot.length_m / 2.0 - 0.3), 0.0);
        put(f, spot, &BARRIER, s, false, offset);
    }
}

/// A row of bicycles across the place.
fn cycles(f: &mut Furnisher, spot: &ParkingSpot, s: &mut Stream) {
    let (pitch_m, fullness) = (s.range(0.62, 0.8), s.range(0.5, 1.0));
    let count = ((spot.length_m - 0.7) / pitch_m) as usize;
    for k in 0..=count {
        let x = pitch_m * (k as f64 - count as f64 / 2.0);
        if s.chance(fullness) {
            put(f, spot, &BICYCLE, s, true, DVec2::new(x, 0.0));
        }
    }
}
