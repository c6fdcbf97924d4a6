//! The ways of bicycles through a junction that a street with cycle lanes leads to: from every arm to every other one.

use crate::plan::junction::{STRAIGHT_RAD, StreetArm, StreetEnd};
use crate::plan::{LineStyle, PlanCurve};
use cadet_base::math::{PI, wrap_angle};

/// Where a street has no cycle lane, cyclists ride in the middle of a strip of such a width, so far from the right edge of
/// its outermost lane.
const STRIP_M: f64 = 1.2;
const FROM_EDGE_M: f64 = 1.0;

/// A bicycle's way through a junction.
#[derive(Debug, Clone)]
pub(crate) struct CycleTurn {
    pub(crate) junction: usize,
    pub(crate) from: StreetEnd,
    pub(crate) to: StreetEnd,
    /// From the left edge of the one lane to the left edge of the other.
    pub(crate) curve: PlanCurve,
    /// At its beginning and its end.
    pub(crate) widths_m: [f64; 2],
    /// Whether lines are painted along it: straight on from one cycle lane to another.
    pub(crate) has_lines: bool,
    pub(crate) is_red: bool,
}

/// The ways through one junction, whose arms go round counter-clockwise; none where no arm has a cycle lane.
pub(crate) fn cycle_turns(junction: usize, arms: &[StreetArm]) -> Vec<CycleTurn> {
    let with_lanes = arms.iter().filter(|a| a.style.cycle_lane.is_some()).count();
    if with_lanes == 0 {
        return Vec::new();
    }
    let mut turns = Vec::new();
    for (i, from) in arms.iter().enumerate() {
        for (_, to) in arms.iter().enumerate().filter(|(j, _)| *j != i) {
            let ((from_right_m, from_width_m), (to_right_m, to_width_m)) = (strip(&from.style), strip(&to.style));
            let curve = PlanCurve::between(
                from.pose().reversed().shifted_right(from_right_m),
                to.pose().shifted_right(to_right_m),
            );
            let is_straight = wrap_angle(to.heading_rad - from.heading_rad - PI).abs() < STRAIGHT_RAD;
            let [leaves, reaches] = [from, to].map(|arm| arm.style.cycle_lane);
            turns.push(CycleTurn {
                junction,
                from: from.from,
                to: to.from,
                curve,
                widths_m: [from_width_m, to_width_m],
                has_lines: is_straight && leaves.is_some() && reaches.is_some(),
                // Two coats would lie on each other where streets with cycle lanes cross.
                is_red: is_straight && with_lanes == 2 && leaves.is_some_and(|c| c.is_red) && reaches.is_some(),
            });
        }
    }
    turns
}

/// From the middle of the road to the left edge of where bicycles are ridden, and the width of that.
fn strip(style: &LineStyle) -> (f64, f64) {
    let driven_m = style.driven_half_width_m();
    match style.cycle_lane {
        Some(lane) => (driven_m, lane.width_m),
        None => (driven_m - FROM_EDGE_M - STRIP_M / 2.0, STRIP_M),
    }
}
