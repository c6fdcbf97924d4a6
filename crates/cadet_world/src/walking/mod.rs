mod avoidance;
mod crossing;
mod footing;
mod motion;
mod on_road;

pub(super) use avoidance::{OnWalkway, free_line, pace_behind};
pub(super) use crossing::{may_start, way_across};
pub(super) use footing::{Nearby, room_of};
pub(super) use motion::{GroupPlace, Motion, Walk};
pub(super) use on_road::{is_on_road, keep_off};
