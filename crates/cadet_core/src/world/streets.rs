//! The ways through a town: what controllers know of it.

use std::sync::Arc;

use super::pavement::Pavements;
use super::route::Roads;
use crate::town::Town;

/// Roads to drive on and pavements to walk on.
pub(super) struct Streets {
    pub roads: Roads,
    pub pavements: Pavements,
}

impl Streets {
    pub fn new(town: &Arc<Town>) -> Self {
        Self { roads: Roads::new(Arc::clone(town)), pavements: Pavements::new(Arc::clone(town)) }
    }
}
