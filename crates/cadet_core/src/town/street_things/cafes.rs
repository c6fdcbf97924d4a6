//! Tables before houses, what closes them in, and what shops put out: the things that stand together in front of a wall.

use std::sync::Arc;

use crate::assets::scenery::{CHAIR_SEAT_M, THING_VARIANTS, ThingKind, thing, thing_palette};
use crate::material::Palette;
use crate::rng::Stream;
use crate::town::plots::frontage::Frontage;
use crate::town::street_things::Furnisher;
use crate::town::street_things::edge::{CORNER_M, INSET_M, along_edge, at_edge};

/// Between the tables of a row, and between rows; a second row needs a sidewalk so wide.
const TABLE_EVERY_M: f64 = 2.6;
const ROW_EVERY_M: f64 = 1.35;
const SIDEWALK_FOR_ROWS_M: f64 = 3.2;
/// Share of the cafes that have one then, of those that plants close in, and of those with a board beside them.
const SECOND_ROW_SHARE: f64 = 0.6;
const PLANTS_SHARE: f64 = 0.6;
const BOARD_SHARE: f64 = 0.5;

/// Tables with two chairs each, along the wall; often with plants at both ends and a board beside them.
pub(super) fn terrace(f: &mut Furnisher, frontage: &Frontage, from_m: f64, s: &mut Stream) {
    let (variant, chair_colors) = (s.below(THING_VARIANTS), thing_palette(ThingKind::CafeChair, s));
    let (has_parasols, has_plants, has_board) = (s.chance(0.5), s.chance(PLANTS_SHARE), s.chance(BOARD_SHARE));
    let has_rows = s.chance(SECOND_ROW_SHARE) && frontage.sidewalk_at(from_m) >= SIDEWALK_FOR_ROWS_M;
    let rows = if has_rows { 2 } else { 1 };
    let tables = 2 + s.below(4);
    let end_m = from_m + TABLE_EVERY_M * (tables - 1) as f64;
    for k in 0..tables {
        let table_m = from_m + TABLE_EVERY_M * k as f64;
        if table_m > frontage.length_m() - CORNER_M {
            break;
        }
        for row in 0..rows {
            let off_m = ROW_EVERY_M * f64::from(row);
            if seat_two(f, frontage, (table_m, off_m), variant, &chair_colors, s) && has_parasols && k % 2 == 0 {
                put(f, frontage, ThingKind::Parasol, variant, (table_m + TABLE_EVERY_M / 2.0, off_m), s);
            }
        }
    }
    let reach_m = ROW_EVERY_M * f64::from(rows) - 0.4;
    if has_plants {
        let kind = [ThingKind::TallPlant, ThingKind::Tub][s.weighted(&[0.65, 0.35])];
        for at_m in [from_m - 1.5, end_m + 1.5] {
            screen(f, frontage, kind, at_m, reach_m, s);
        }
    }
    if has_board {
        let (at_m, variant) = (end_m + s.range(2.0, 2.8), s.below(THING_VARIANTS));
        put(f, frontage, ThingKind::AdvertStand, variant, (at_m, s.range(0.0, reach_m)), s);
    }
}

/// A board, and plants to one or both sides of it.
pub(super) fn shop_front(f: &mut Furnisher, frontage: &Frontage, at_m: f64, s: &mut Stream) {
    let wares = [ThingKind::TallPlant, ThingKind::Tub, ThingKind::AdvertStand];
    let kind = wares[s.weighted(&[0.4, 0.35, 0.25])];
    put(f, frontage, ThingKind::AdvertStand, s.below(THING_VARIANTS), (at_m, s.range(0.0, 1.2)), s);
    for k in 0..1 + s.below(3) {
        let (side, off_m) = (if s.chance(0.5) { 1.0 } else { -1.0 }, s.range(0.0, 0.4));
        put(f, frontage, kind, s.below(THING_VARIANTS), (at_m + side * (1.0 + 0.8 * k as f64), off_m), s);
    }
}

/// A table and who may sit at it, if there is room; `off_m` from the wall.
fn seat_two(
    f: &mut Furnisher,
    frontage: &Frontage,
    (table_m, off_m): (f64, f64),
    variant: usize,
    chair_colors: &Arc<Palette>,
    s: &mut Stream,
) -> bool {
    let table = thing(ThingKind::CafeTable, variant);
    if !put(f, frontage, ThingKind::CafeTable, variant, (table_m, off_m), s) {
        return false;
    }
    let depth_m = INSET_M + off_m + table.footprint_size().x / 2.0;
    for side in [-1.0, 1.0] {
        let chair = thing(ThingKind::CafeChair, variant);
        let seat_m = table_m + side * (table.footprint_size().y / 2.0 + 0.36);
        let mut place = along_edge(frontage, &chair, seat_m, side < 0.0);
        place.at = place.edge - place.out * depth_m;
        if f.put_at_edge(&chair, Arc::clone(chair_colors), &place) {
            f.add_seat((0.02, 0.0), CHAIR_SEAT_M);
        }
    }
    true
}

/// Plants in a line out from the wall.
fn screen(f: &mut Furnisher, frontage: &Frontage, kind: ThingKind, at_m: f64, reach_m: f64, s: &mut Stream) {
    let mut off_m = 0.0;
    while off_m < reach_m {
        let variant = s.below(THING_VARIANTS);
        put(f, frontage, kind, variant, (at_m, off_m), s);
        off_m += thing(kind, variant).footprint_size().x + s.range(0.08, 0.3);
    }
}

/// Puts a thing with its back to the wall, `off_m` before it, if people still get past.
fn put(
    f: &mut Furnisher,
    frontage: &Frontage,
    kind: ThingKind,
    variant: usize,
    (at_m, off_m): (f64, f64),
    s: &mut Stream,
) -> bool {
    let palette = thing_palette(kind, s);
    if !(CORNER_M..frontage.length_m() - CORNER_M).contains(&at_m) {
        return false;
    }
    let model = thing(kind, variant);
    let mut place = at_edge(frontage, &model, at_m);
    place.at -= place.out * off_m;
    f.put_at_edge(&model, palette, &place)
}
