//! Where vehicles stop before junctions.

use crate::town::{LaneId, STOP_LINE_M as PAINTED_M};
use crate::world::streets::Roads;

/// Where the front bumper stops before a junction's first point: out of the sweep of those who turn in.
pub(crate) const STOP_LINE_M: f64 = 3.3;
/// The same before the line of a light.
pub(crate) const LIGHT_LINE_M: f64 = PAINTED_M.1 + 0.9;

/// Where the front bumper stops at the end of a lane before a junction: fords are kept free.
pub(crate) fn line_m(before: LaneId, roads: &Roads) -> f64 {
    let has_ford = roads.signals().arm_of(before).is_some() || roads.signals().has_zebra(before);
    if has_ford { LIGHT_LINE_M } else { STOP_LINE_M }
}
