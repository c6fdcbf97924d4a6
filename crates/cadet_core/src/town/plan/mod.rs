//! How a generated place is laid out, before it is written as OpenDRIVE.

pub(in crate::town) mod country_roads;
pub(in crate::town) mod cycle_lanes;
pub(in crate::town) mod junction;
pub(in crate::town) mod motorway;
pub(in crate::town) mod place_streets;
pub(in crate::town) mod plan_curve;
pub(in crate::town) mod relief;
pub(in crate::town) mod street_bays;
pub(in crate::town) mod street_grid;
pub(in crate::town) mod street_plan;
pub(in crate::town) mod suburb;
pub(in crate::town) mod suburb_config;
pub(in crate::town) mod xodr;
