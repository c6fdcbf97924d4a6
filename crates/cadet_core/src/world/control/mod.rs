//! Who decides what an agent does: drivers, pedestrians, scripts, nobody.

mod avoidance;
mod controller;
mod crossing;
mod cyclist;
mod driver;
mod footing;
mod hazards;
mod idm;
mod lane_change;
mod lane_view;
mod motion;
mod on_road;
mod overtaking;
mod parked;
mod path;
mod pedestrian;
mod pursuit;
mod scripted;
mod stop_line;
mod tram;
mod turning;

pub(super) use controller::{Controller, Own};
pub(super) use cyclist::Cyclist;
pub(super) use driver::Driver;
pub(super) use footing::{BODY_M, nearness};
pub(super) use hazards::Cause;
pub(super) use idm::IdmParameters;
pub(super) use lane_view::LaneView;
pub(super) use motion::{Company, Motion, Walk};
pub(super) use parked::Parked;
pub(super) use path::TimedPath;
pub(super) use pedestrian::Pedestrian;
pub(super) use scripted::{PERSON_HALF_CHORD_M, Scripted};
pub(super) use tram::{Coupled, Train, TramCar};
