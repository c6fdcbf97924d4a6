//! The ways through a town: what controllers know of it.

use std::sync::Arc;

use super::roads::Roads;
use super::sidewalk::Sidewalks;
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
