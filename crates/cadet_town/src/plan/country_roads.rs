//! Roads in open country: their lanes, lines and verges, and how they wind.

use crate::plan::{CountryRoad, LineStyle, PlanCurve, PlanPose};
use cadet_base::rng::Stream;

/// Share of the roads that are major: wider, faster, with edge lines.
const MAJOR_SHARE: f64 = 0.6;
/// Width of a lane, edge strip included (RAL: carriageways of 6.5 to 7 m, and of 5.5 m on minor roads).
const MAJOR_LANE_M: (f64, f64) = (3.25, 3.55);
const MINOR_LANE_M: (f64, f64) = (2.75, 3.0);
const MAJOR_SPEEDS_KMH: [u32; 2] = [70, 80];
const MINOR_SPEEDS_KMH: [u32; 2] = [50, 60];
/// Width of the grass between the asphalt and the ditch.
const VERGE_M: (f64, f64) = (1.1, 1.6);
/// The middle of an edge line lies so far inside of the asphalt's edge.
pub(crate) const EDGE_LINE_INSET_M: f64 = 0.25;
/// Line and gap of a broken line out of town (RMS-1).
pub(crate) const DASH_M: (f64, f64) = (4.0, 8.0);
/// Radius at a bend between two blocks, and what junctions' corners have more than in town.
pub(crate) const BEND_RADIUS_M: (f64, f64) = (55.0, 95.0);
pub(crate) const CORNER_MORE_M: f64 = 4.0;
/// A road swings from side to side: about so far apart, by so much of that distance.
const SWING_M: f64 = 130.0;
const SWING_SHARE: (f64, f64) = (0.015, 0.075);
/// Shorter roads don't.
const SHORTEST_M: f64 = 90.0;

/// Makes country roads of all streets, or of none.
pub(crate) fn draw(stream: &mut Stream, share: f64, styles: &mut [LineStyle]) {
    let is_country = stream.chance(share);
    let verge_m = round_to(stream.within(VERGE_M), 0.1);
    for style in styles {
        let (is_major, is_faster) = (stream.chance(MAJOR_SHARE), stream.chance(0.5));
        let (major_m, minor_m) = (stream.within(MAJOR_LANE_M), stream.within(MINOR_LANE_M));
        let has_edge_lines = is_major || stream.chance(0.3);
        if is_country {
            let (lane_m, speeds_kmh) = if is_major { (major_m, MAJOR_SPEEDS_KMH) } else { (minor_m, MINOR_SPEEDS_KMH) };
            let usual = LineStyle::new(round_to(lane_m, 0.05), verge_m, speeds_kmh[usize::from(is_faster)]);
            *style = LineStyle { country: Some(CountryRoad { has_edge_lines }), ..usual };
        }
    }
}

fn round_to(value: f64, step: f64) -> f64 {
    (value / step).round() * step
}

/// Adds swings to both sides of a way; its ends stay.
pub(crate) fn wind(curve: &PlanCurve, stream: &mut Stream) -> PlanCurve {
    let length_m = curve.length_m();
    let count = (length_m / SWING_M).round() as usize;
    let mut side = if stream.chance(0.5) { 1.0 } else { -1.0 };
    if length_m < SHORTEST_M || count < 1 {
        return curve.clone();
    }
    let mut wound = PlanCurve::default();
    let mut at = curve.pose_at(0.0);
    for k in 0..count {
        let on = curve.pose_at(length_m * (k as f64 + stream.range(0.4, 0.6)) / count as f64);
        let aside_m = side * SWING_M * stream.within(SWING_SHARE);
        let next = PlanPose::new(on.at + on.direction().perp() * aside_m, on.heading_rad);
        wound.extend_to(at, next);
        at = next;
        // Most swings go to the other side.
        side *= if stream.chance(0.8) { -1.0 } else { 1.0 };
    }
    wound.extend_to(at, curve.pose_at(length_m));
    wound
}
