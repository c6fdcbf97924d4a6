//! What drivers keep off because of people on the road.

use crate::body::Upright;
use crate::footprint::Footprint;
use crate::params::walking::{NEAR_LANE_M, ROOM_M};
use crate::streets::LaneGraph;
use cadet_base::math::DVec2;

/// Whether a place is where cars drive: `at`, at the height of somebody on foot.
pub(crate) fn is_on_road(body: &Upright, at: DVec2, graph: &LaneGraph) -> bool {
    let is_near =
        || graph.nearest(at.extend(body.position.z), None, NEAR_LANE_M).is_some() || graph.is_on_cycle_lane(at, 0.0);
    is_near() && !graph.is_sidewalk(at.extend(body.position.z))
}

/// A person, and the way of `lead_m` that the person will have gone soon.
pub(crate) fn keep_off(body: &Upright, lead_m: f64) -> Footprint {
    Footprint {
        center: body.at() + body.heading() * (lead_m / 2.0),
        heading: body.heading(),
        half_length_m: lead_m / 2.0 + ROOM_M,
        half_width_m: ROOM_M,
        z_m: body.position.z,
        velocity: DVec2::ZERO,
    }
}
