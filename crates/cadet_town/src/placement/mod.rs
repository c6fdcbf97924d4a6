//! Puts things on the ground, and knows what is taken.

mod boundary;
mod clearance;
mod occupancy;
mod placer;
mod prop_config;

pub(crate) use boundary::Boundary;
pub(crate) use clearance::{ClearanceGrid, MAX_MARGIN_M};
pub(crate) use occupancy::{Occupancy, Site};
pub(crate) use placer::{Placer, PropFootprint, draw_plant, footprint};
pub use prop_config::PropConfig;
