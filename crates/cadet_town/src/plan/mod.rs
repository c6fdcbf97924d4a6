//! How a generated place is laid out, before it is written as OpenDRIVE.

mod country_roads;
mod cycle_lanes;
mod junction;
mod motorway;
mod place_streets;
mod plan_curve;
mod relief;
mod street_bays;
mod street_grid;
mod street_plan;
mod suburb;
mod suburb_config;
mod xodr;

pub(crate) use country_roads::EDGE_LINE_INSET_M;
pub(crate) use motorway::{CrossSection, Motorway};
pub(crate) use place_streets::AISLE_BAY_M;
pub(crate) use plan_curve::{PlanCurve, PlanPose, Segment};
pub(crate) use relief::Relief;
pub(crate) use street_bays::StreetBays;
pub(crate) use street_grid::{
    Chain, CountryRoad, CycleLane, LineStyle, StreetGrid, StreetKind, WhichEnd, draw_grid, draw_styles, lay_tracks,
    thin, trace, widen_main_roads,
};
pub(crate) use street_plan::{Street, StreetPlan};
pub use suburb::{Suburb, generate};
pub use suburb_config::SuburbConfig;
