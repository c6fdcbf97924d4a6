//! The ways through a town: what agents know of it.

mod abreast;
mod roads;
mod room;
mod route;
mod sidewalk;
mod track;

use std::sync::Arc;

pub(super) use roads::Roads;
pub(super) use room::Needs;
pub(super) use route::{Ahead, CAR_STRAIGHT, EGO_STRAIGHT, LONG_STRAIGHT, Route};
pub(super) use sidewalk::Sidewalks;
pub(super) use track::Track;

use crate::town::Town;

/// Roads to drive on and sidewalks to walk on.
pub(super) struct Streets {
    pub roads: Roads,
    pub sidewalks: Sidewalks,
}

impl Streets {
    pub fn new(town: &Arc<Town>) -> Self {
        Self { roads: Roads::new(Arc::clone(town)), sidewalks: Sidewalks::new(Arc::clone(town)) }
    }
}
