//! The parking bays along one street: on which sides, how wide, and from where to where.

use crate::plan::{AISLE_BAY_M, LineStyle, StreetKind, SuburbConfig};
use cadet_base::rng::Stream;

/// Width of a parallel parking bay, gutter included.
const BAY_WIDTH_M: f64 = 2.25;
/// How much wider bays are beside a cycle lane: doors open there.
const DOORS_M: f64 = 0.5;
/// Depth of bays in which cars stand at an angle or across, and share of the streets with bays at both curbs that have
/// them at both.
const DEEP_BAY_M: f64 = 5.5;
const BOTH_DEEP_SHARE: f64 = 0.3;
/// Bays begin so far from a junction, deep ones this much farther.
const MARGIN_M: (f64, f64) = (5.0, 9.0);
const DEEP_BAY_MARGIN_M: f64 = 4.0;
/// Shorter stretches have no bays.
const LEAST_STRETCH_M: f64 = 20.0;
/// Beside narrower lanes cars stand half on the sidewalk: in a bay they would be grazed.
const MIN_LANE_BESIDE_BAYS_M: f64 = 2.55;
/// Share of the streets with wide lanes where cars stand half on the sidewalk all the same.
const HALF_BAYS_SHARE: f64 = 0.15;
/// How far such cars stand from the middle of the lane, and how much of a car of usual width is on the sidewalk.
const HALF_BAY_FLANK_M: f64 = 1.6;
const ON_SIDEWALK_M: (f64, f64) = (0.4, 1.0);
const CAR_WIDTH_M: f64 = 1.65;
/// Left of the sidewalk for walkers.
const LEFT_FOR_WALKERS_M: f64 = 0.95;

/// The bays of a street; sides are in the order right, left.
#[derive(Debug, Clone, Copy)]
pub(crate) struct StreetBays {
    /// From where to where along the street; `None` where there are none.
    pub stretch_m: Option<(f64, f64)>,
    /// 0 on a side without bays.
    pub widths_m: [f64; 2],
}

impl StreetBays {
    /// Draws the bays of a street of a style and a length.
    pub fn draw(style: &LineStyle, length_m: f64, config: &SuburbConfig, stream: &mut Stream) -> Self {
        let mut margins_m = [(); 2].map(|()| stream.within(MARGIN_M));
        let mut has_bays = [(); 2].map(|()| stream.chance(config.parking_share));
        let on_sidewalk_m = stream.within(ON_SIDEWALK_M);
        let (half_all_the_same, is_right) = (stream.chance(HALF_BAYS_SHARE), stream.chance(0.5));
        let (is_deep, both_deep) = (stream.chance(config.angled_share), stream.chance(BOTH_DEEP_SHARE));
        let preferred = [is_right, !is_right];
        let has_any = has_bays.contains(&true);
        let mut bay_m = BAY_WIDTH_M;
        if style.lane_width_m < MIN_LANE_BESIDE_BAYS_M
            || (half_all_the_same && !style.is_main_road() && style.cycle_lane.is_none())
        {
            let on_sidewalk_m = on_sidewalk_m.min(style.sidewalk_width_m - LEFT_FOR_WALKERS_M);
            bay_m = HALF_BAY_FLANK_M + CAR_WIDTH_M - on_sidewalk_m - style.lane_width_m / 2.0;
            // On one side alone: the other sidewalk stays free.
            has_bays = preferred.map(|is_here| has_any && is_here);
        }
        let mut widths_m = has_bays.map(|has_bays| if has_bays { bay_m } else { 0.0 });
        if style.cycle_lane.is_some() {
            // Nobody backs out over a cycle lane.
            widths_m = widths_m.map(|m| if m > 0.0 { m + DOORS_M } else { 0.0 });
        } else if is_deep && has_any {
            for (width_m, is_here) in widths_m.iter_mut().zip(preferred) {
                if is_here || (both_deep && *width_m > 0.0) {
                    *width_m = DEEP_BAY_M;
                }
            }
            margins_m = margins_m.map(|m| m + DEEP_BAY_MARGIN_M);
        }
        let is_lined_aisle = style.kind == StreetKind::Aisle && (has_any || !is_deep);
        if is_lined_aisle {
            widths_m = [AISLE_BAY_M; 2];
            margins_m = margins_m.map(|m| m.max(2.0 * DEEP_BAY_MARGIN_M));
        }
        let end_m = length_m - margins_m[1];
        let has_room =
            end_m - margins_m[0] > LEAST_STRETCH_M && style.country.is_none() && style.kind != StreetKind::Campus;
        Self { stretch_m: (has_room && (has_any || is_lined_aisle)).then_some((margins_m[0], end_m)), widths_m }
    }
}
