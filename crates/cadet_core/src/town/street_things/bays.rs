//! What stands in parking places instead of cars.

use crate::assets::scenery::{THING_VARIANTS, ThingKind, thing, thing_palette};
use crate::math::DVec2;
use crate::rng::Stream;
use crate::town::street_things::{Furnisher, footprint, rect_of};
use crate::town::{ParkingSpot, SpotKind};

/// Share of the places along curbs that hold something else than a car.
const FILLED_SHARE: f64 = 0.03;
/// A thing in a place reaches no farther toward the lane than a car does.
const OVER_WIDTH_M: f64 = 0.05;

/// Fills a parking place, now and then.
pub(super) fn fill(f: &mut Furnisher, spot: &ParkingSpot, clutter: f64, s: &mut Stream) {
    if matches!(spot.kind, SpotKind::Drive | SpotKind::Lot | SpotKind::Yard)
        || !s.chance((FILLED_SHARE * clutter).min(0.3))
    {
        return;
    }
    match s.weighted(&[0.24, 0.12, 0.16, 0.16, 0.12, 0.12, 0.08]) {
        0 => along(f, spot, ThingKind::Skip, s),
        1 => along(f, spot, ThingKind::SiteContainer, s),
        2 => ahead(f, spot, ThingKind::CoveredCar, s),
        3 => {
            along(f, spot, ThingKind::Pallets, s);
            barriers(f, spot, s);
        }
        4 => {
            along(f, spot, ThingKind::Heap, s);
            barriers(f, spot, s);
        }
        5 => cycles(f, spot, s),
        _ => ahead(f, spot, ThingKind::CoveredCycle, s),
    }
}

/// Its long side along the curb.
fn along(f: &mut Furnisher, spot: &ParkingSpot, kind: ThingKind, s: &mut Stream) {
    put(f, spot, kind, s, true, DVec2::ZERO);
}

/// As a car would stand.
fn ahead(f: &mut Furnisher, spot: &ParkingSpot, kind: ThingKind, s: &mut Stream) {
    put(f, spot, kind, s, false, DVec2::ZERO);
}

/// Puts one into the place, `offset` from its middle in its own frame; the first size that fits.
fn put(f: &mut Furnisher, spot: &ParkingSpot, kind: ThingKind, s: &mut Stream, is_across: bool, offset: DVec2) {
    let place = rect_of(spot);
    let first = s.below(THING_VARIANTS);
    let palette = thing_palette(kind, s);
    let facing = if is_across { -place.axis.perp() } else { place.axis };
    let at = place.center + place.axis * offset.x + place.axis.perp() * offset.y;
    for k in 0..THING_VARIANTS {
        let model = thing(kind, first + k);
        let middle = (model.footprint_min + model.footprint_max) / 2.0;
        let axis = facing.normalize();
        let at = at - axis * middle.x - axis.perp() * middle.y;
        let rect = footprint(&model, at, facing);
        let reach = if is_across { DVec2::new(rect.half.y, rect.half.x) } else { rect.half };
        let fits =
            reach.x + offset.x.abs() <= place.half.x + 0.1 && reach.y + offset.y.abs() <= place.half.y + OVER_WIDTH_M;
        if fits && f.taken.is_free(&rect) && f.ways.is_free(&rect) {
            f.placer.put(&model, palette, at, facing);
            f.taken.take(rect);
            f.out.obstacles.push(rect);
            return;
        }
    }
}

/// At both ends of the place.
fn barriers(f: &mut Furnisher, spot: &ParkingSpot, s: &mut Stream) {
    for side in [-1.0, 1.0] {
        let offset = DVec2::new(side * (spot.length_m / 2.0 - 0.3), 0.0);
        put(f, spot, ThingKind::Barrier, s, false, offset);
    }
}

/// A row of bicycles across the place.
fn cycles(f: &mut Furnisher, spot: &ParkingSpot, s: &mut Stream) {
    let (pitch_m, fullness) = (s.range(0.62, 0.8), s.range(0.5, 1.0));
    let count = ((spot.length_m - 0.7) / pitch_m) as usize;
    for k in 0..=count {
        let x = pitch_m * (k as f64 - count as f64 / 2.0);
        if s.chance(fullness) {
            put(f, spot, ThingKind::Bicycle, s, true, DVec2::new(x, 0.0));
        }
    }
}
