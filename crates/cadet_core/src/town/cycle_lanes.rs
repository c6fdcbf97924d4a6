//! Which streets have a lane for bicycles on the carriageway, and of which kind.

use super::street_grid::{CycleLane, LineStyle, StreetKind};
use crate::rng::Stream;

/// Share of those that cars may use, of streets that are no main roads and of main roads.
const ADVISORY_SHARE: (f64, f64) = (0.55, 0.2);
/// Width of a lane for bicycles alone, line included, and of one that cars may use (RASt 06, ERA 2010).
const WIDTH_M: f64 = 1.85;
const ADVISORY_M: (f64, f64) = (1.25, 1.5);
/// Share of those that are red in junctions.
const RED_SHARE: f64 = 0.35;
/// The lane beside it is not wider.
const WIDEST_LANE_M: f64 = 3.25;

/// Gives some of the streets that are faster than others cycle lanes on both sides.
pub(super) fn draw(stream: &mut Stream, share: f64, styles: &mut [LineStyle]) {
    for style in styles {
        let (has_one, kind, red) = (stream.chance(share), stream.unit(), stream.chance(RED_SHARE));
        let advisory_m = (stream.range(ADVISORY_M.0, ADVISORY_M.1) * 20.0).round() / 20.0;
        let is_fit = style.speed_kmh > 30 && style.country.is_none() && style.kind == StreetKind::Usual;
        if has_one && is_fit {
            let is_advisory = kind < if style.is_main_road() { ADVISORY_SHARE.1 } else { ADVISORY_SHARE.0 };
            let width_m = if is_advisory { advisory_m } else { WIDTH_M };
            style.cycle_lane = Some(CycleLane { width_m, is_advisory, is_red: red });
            style.lane_width_m = style.lane_width_m.min(WIDEST_LANE_M);
        }
    }
}
