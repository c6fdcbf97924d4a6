//! How a generated place is laid out, before it is written as OpenDRIVE.

pub(crate) mod country_roads;
pub(crate) mod cycle_lanes;
pub(crate) mod junction;
pub(crate) mod motorway;
pub(crate) mod place_streets;
pub(crate) mod plan_curve;
pub(crate) mod relief;
pub(crate) mod street_bays;
pub(crate) mod street_grid;
pub(crate) mod street_plan;
pub(crate) mod suburb;
pub(crate) mod suburb_config;
pub(crate) mod xodr;
