//! Puts things on the ground, and knows what is taken.

pub(in crate::town) mod boundary;
pub(in crate::town) mod clearance;
pub(in crate::town) mod occupancy;
pub(in crate::town) mod placer;
pub(in crate::town) mod prop_config;
