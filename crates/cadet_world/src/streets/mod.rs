//! The ways through a town: what agents know of it.

mod abreast;
mod lane_graph;
mod room;
mod route;
mod sidewalk;
mod track;

use std::sync::Arc;

pub(super) use lane_graph::{LaneGraph, LanePosition};
pub(super) use room::Needs;
pub(super) use route::{Ahead, CAR_STRAIGHT_WEIGHT, EGO_STRAIGHT_WEIGHT, LONG_STRAIGHT_WEIGHT, Route};
pub(super) use sidewalk::Sidewalks;
pub(super) use track::Track;

use cadet_town::Town;

/// Lanes to drive on and sidewalks to walk on.
pub(super) struct Streets {
    pub graph: LaneGraph,
    pub sidewalks: Sidewalks,
}

impl Streets {
    pub fn new(town: &Arc<Town>) -> Self {
        Self { graph: LaneGraph::new(Arc::clone(town)), sidewalks: Sidewalks::new(Arc::clone(town)) }
    }
}
