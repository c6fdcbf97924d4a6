//! Tables before houses, what closes them in, and what shops put out: the things that stand together in front of a wall.

use crate::plots::Frontage;
use crate::street_things::{CORNER_M, Furnisher, INSET_M, along_edge, at_edge};
use cadet_assets::props::{ADVERT_STAND, CAFE_CHAIR, CAFE_TABLE, Drawn, PARASOL, Shipped, TALL_PLANT, TUB};
use cadet_base::rng::Stream;

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
    let [table, chair, parasol] = [CAFE_TABLE, CAFE_CHAIR, PARASOL].map(|prop| prop.draw(s));
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
            if seat_two(f, frontage, (table_m, off_m), &table, &chair) && has_parasols && k % 2 == 0 {
                put(f, frontage, &parasol, (table_m + TABLE_EVERY_M / 2.0, off_m));
            }
        }
    }
    let reach_m = ROW_EVERY_M * f64::from(rows) - 0.4;
    if has_plants {
        let plant = [TALL_PLANT, TUB][s.weighted(&[0.65, 0.35])];
        for at_m in [from_m - 1.5, end_m + 1.5] {
            screen(f, frontage, plant, at_m, reach_m, s);
        }
    }
    if has_board {
        let at = (end_m + s.range(2.0, 2.8), s.range(0.0, reach_m));
        put(f, frontage, &ADVERT_STAND.draw(s), at);
    }
}

/// A board, and plants to one or both sides of it.
pub(super) fn shop_front(f: &mut Furnisher, frontage: &Frontage, at_m: f64, s: &mut Stream) {
    let ware = [TALL_PLANT, TUB, ADVERT_STAND][s.weighted(&[0.4, 0.35, 0.25])];
    put(f, frontage, &ADVERT_STAND.draw(s), (at_m, s.range(0.0, 1.2)));
    for k in 0..1 + s.below(3) {
        let (side, off_m) = (if s.chance(0.5) { 1.0 } else { -1.0 }, s.range(0.0, 0.4));
        put(f, frontage, &ware.draw(s), (at_m + side * (1.0 + 0.8 * k as f64), off_m));
    }
}

/// A table and who may sit at it, if there is room; `off_m` from the wall.
fn seat_two(
    f: &mut Furnisher,
    frontage: &Frontage,
    (table_m, off_m): (f64, f64),
    table: &Drawn,
    chair: &Drawn,
) -> bool {
    if !put(f, frontage, table, (table_m, off_m)) {
        return false;
    }
    let size = table.model.footprint_size();
    for side in [-1.0, 1.0] {
        let seat_m = table_m + side * (size.y / 2.0 + 0.36);
        let mut place = along_edge(frontage, &chair.model, seat_m, side < 0.0);
        place.at = place.edge - place.out * (INSET_M + off_m + size.x / 2.0);
        f.put_at_edge(chair, &place);
    }
    true
}

/// Plants in a line out from the wall.
fn screen(f: &mut Furnisher, frontage: &Frontage, plant: Shipped, at_m: f64, reach_m: f64, s: &mut Stream) {
    let mut off_m = 0.0;
    while off_m < reach_m {
        let drawn = plant.draw(s);
        put(f, frontage, &drawn, (at_m, off_m));
        off_m += drawn.model.footprint_size().x + s.range(0.08, 0.3);
    }
}

/// Puts a prop with its back to the wall, `off_m` before it, if people still get past.
fn put(f: &mut Furnisher, frontage: &Frontage, drawn: &Drawn, (at_m, off_m): (f64, f64)) -> bool {
    if !(CORNER_M..frontage.length_m() - CORNER_M).contains(&at_m) {
        return false;
    }
    let mut place = at_edge(frontage, &drawn.model, at_m);
    place.at -= place.out * off_m;
    f.put_at_edge(drawn, &place)
}
