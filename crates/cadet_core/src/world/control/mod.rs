//! Who decides what an agent does: drivers, pedestrians, nobody.

mod avoidance;
mod controller;
mod crossing;
mod driver;
mod footing;
mod idm;
mod motion;
mod parked;
mod pedestrian;
mod pursuit;
mod stop_line;

pub(super) use controller::{Controller, Own};
#[cfg(test)]
pub(super) use driver::Cause;
pub(super) use driver::Driver;
pub(super) use footing::BODY_M;
pub(super) use idm::IdmParameters;
pub(super) use motion::{Company, Motion, Walk};
pub(super) use parked::Parked;
pub(super) use pedestrian::Pedestrian;
