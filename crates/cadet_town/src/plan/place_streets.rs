//! The streets of car parks, commercial areas, and campuses: how wide, how fast, and what covers them.

use crate::network::AISLE_KMH;
use crate::plan::{LineStyle, StreetKind, SuburbConfig};
use cadet_base::rng::{Stream, StreamKey};

/// Aisles between rows of bays: width of a lane, and of the strip behind the bays.
const AISLE_LANE_M: f64 = 3.0;
const AISLE_WALK_M: (f64, f64) = (1.6, 2.2);
/// Depth of the bays at an aisle.
pub(crate) const AISLE_BAY_M: f64 = 5.0;
/// Streets of commercial areas.
const WIDE_LANE_M: (f64, f64) = (3.25, 3.75);
const WIDE_WALK_M: (f64, f64) = (2.0, 3.0);
/// Lanes of a campus.
const CAMPUS_LANE_M: (f64, f64) = (2.25, 2.5);
const CAMPUS_WALK_M: (f64, f64) = (2.2, 3.6);
const CAMPUS_KMH: [u32; 2] = [10, 20];

fn tenths(s: &mut Stream, (least, most): (f64, f64)) -> f64 {
    (s.range(least, most) * 10.0).round() / 10.0
}

/// Makes aisles, wide streets, or lanes of a campus of some of the lines of a grid.
pub(crate) fn draw(key: &StreamKey, config: &SuburbConfig, styles: &mut [LineStyle]) {
    let mut s = key.stream("suburb/commercial");
    for style in styles.iter_mut() {
        let (is_wide, lane_m, walk_m) =
            (s.chance(config.industrial_share), s.within(WIDE_LANE_M), tenths(&mut s, WIDE_WALK_M));
        if is_wide && style.country.is_none() && !style.is_main_road() {
            (style.lane_width_m, style.sidewalk_width_m) = ((lane_m * 20.0).round() / 20.0, walk_m);
            style.speed_kmh = 50;
        }
    }
    let mut s = key.stream("suburb/aisles");
    for style in styles.iter_mut() {
        let (is_aisle, walk_m) = (s.chance(config.aisle_share), tenths(&mut s, AISLE_WALK_M));
        if is_aisle && style.speed_kmh == 30 && style.country.is_none() {
            (style.lane_width_m, style.sidewalk_width_m) = (AISLE_LANE_M, walk_m);
            (style.speed_kmh, style.kind) = (AISLE_KMH, StreetKind::Aisle);
        }
    }
    let mut s = key.stream("suburb/campus");
    let (is_campus, walk_m) = (s.chance(config.campus_share), tenths(&mut s, CAMPUS_WALK_M));
    let kmh = CAMPUS_KMH[s.below(2)];
    for style in styles.iter_mut() {
        let lane_m = s.within(CAMPUS_LANE_M);
        if is_campus && style.country.is_none() {
            let usual = LineStyle::new((lane_m * 20.0).round() / 20.0, walk_m, kmh);
            *style = LineStyle { kind: StreetKind::Campus, ..usual };
        }
    }
}
