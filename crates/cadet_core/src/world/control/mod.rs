//! Who decides what an agent does: drivers, pedestrians, scripts, nobody.

mod avoidance;
mod constraints;
mod controller;
mod crossing;
mod cyclist;
mod driver;
mod footing;
mod idm;
mod junction_ahead;
mod lane_change;
mod lane_view;
mod motion;
mod on_road;
mod on_route;
mod overtaking;
mod parked;
mod path;
mod pedestrian;
mod predicted_way;
mod pursuit;
mod scripted;
mod stop_line;
mod swing_out;
mod tram;
mod turning;

pub(super) use constraints::SIDE_STANDING_M;
pub(super) use controller::{AgentParts, Controller};
pub(super) use cyclist::Cyclist;
pub(super) use driver::Driver;
pub(super) use footing::{BODY_M, nearness};
pub(super) use idm::IdmParameters;
pub(super) use lane_view::LaneView;
pub(super) use motion::{GroupPlace, Motion, Walk};
pub(super) use on_route::Cause;
pub(super) use parked::Parked;
pub(super) use path::TimedPath;
pub(super) use pedestrian::Pedestrian;
pub(super) use scripted::{PERSON_HALF_CHORD_M, Scripted};
#[cfg(test)]
pub(super) use stop_line::line_m;
pub(super) use tram::{Coupled, Trailer, Train, TramDriver};
