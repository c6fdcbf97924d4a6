//! Puts things on the ground, and knows what is taken.

pub(crate) mod boundary;
pub(crate) mod clearance;
pub(crate) mod occupancy;
pub(crate) mod placer;
pub(crate) mod prop_config;
