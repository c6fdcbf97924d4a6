//! How drivers decide: what they keep a gap to, how fast they go, and which line they follow.

mod constraints;
mod idm;
mod junction_ahead;
mod lane_change;
mod lane_view;
mod on_route;
mod overtaking;
mod predicted_way;
mod pursuit;
mod stop_line;
mod swing_out;
mod turning;

pub(super) use constraints::{perceive, traffic_aside};
pub(super) use idm::IdmParameters;
pub(super) use junction_ahead::leave_junctions;
pub(super) use lane_change::{Decider, LaneChoice};
pub(super) use lane_view::LaneView;
pub(super) use on_route::{Cause, OnRoute};
pub(super) use overtaking::Overtaking;
pub(super) use pursuit::{Axles, pursue};
#[cfg(test)]
pub(super) use stop_line::line_m;
pub(super) use turning::{signal_for, turn_ahead};
