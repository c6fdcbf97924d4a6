//! What drivers keep off because of people on the road.

use crate::math::DVec2;
use crate::world::body::Upright;
use crate::world::footprint::Footprint;
use crate::world::streets::Roads;

/// Half the width and length of a person with some room.
const ROOM_M: f64 = 0.5;
/// Nearer than this to the middle of a lane one is on it, unless there is a sidewalk.
const NEAR_LANE_M: f64 = 2.6;

/// Whether a place is where cars drive: `at`, at the height of somebody on foot.
pub(crate) fn is_on_road(body: &Upright, at: DVec2, roads: &Roads) -> bool {
    let is_near =
        || roads.nearest(at.extend(body.position.z), None, NEAR_LANE_M).is_some() || roads.is_on_cycle_lane(at, 0.0);
    is_near() && !roads.is_sidewalk(at)
}

/// A person, and the way of `lead_m` that the person will have gone soon.
pub(crate) fn keep_off(body: &Upright, lead_m: f64) -> Footprint {
    Footprint {
        center: body.at() + body.heading() * (lead_m / 2.0),
        heading: body.heading(),
        half_length_m: lead_m / 2.0 + ROOM_M,
        half_width_m: ROOM_M,
        velocity: DVec2::ZERO,
    }
}
