//! Where vehicles stop before junctions.

use crate::params::junctions::{LIGHT_LINE_M, STOP_LINE_M};
use crate::streets::LaneGraph;
use cadet_town::LaneId;

/// Where the front bumper stops at the end of a lane before a junction: fords are kept free.
pub(crate) fn line_m(before: LaneId, graph: &LaneGraph) -> f64 {
    let has_ford = graph.signals().arm_of(before).is_some() || graph.signals().has_zebra(before);
    if has_ford { LIGHT_LINE_M } else { STOP_LINE_M }
}
