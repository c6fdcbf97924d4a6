//! What all placements need to know.

use super::config::TrafficConfig;
use crate::arena::Arena;
use crate::slot::Slot;
use crate::streets::Route;
use cadet_assets::imported::UserModels;
use cadet_base::rng::{Stream, StreamKey};

/// The streets that the ego will see while it drives this far are its way; in the side streets more cars are parked
/// and more people walk than along it, as out of sight they belong to a town but not to a picture.
pub(super) const EGO_WAY_M: f64 = 260.0;

/// Where somebody may come in.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum Entry {
    /// In the ego's view too: before the first step.
    Anywhere,
    Unseen,
    /// Where a road begins at the map's edge, in view too: on small maps nothing else is left.
    MapEdge,
}

/// Somebody who is to come in.
pub(crate) struct Newcomer<'s> {
    /// The one that it gets.
    pub slot: Slot,
    pub stream: &'s mut Stream,
    /// The distances from the ego between which it comes in.
    pub ring_m: (f64, f64),
    pub entry: Entry,
}

/// Puts agents into an arena.
pub(crate) struct Spawner<'a> {
    pub arena: &'a mut Arena,
    pub key: StreamKey,
    pub config: &'a TrafficConfig,
    pub user_models: &'a UserModels,
    /// Whether it rains.
    pub rains: bool,
}

impl Spawner<'_> {
    /// The way that the ego will drive, as far as it matters.
    pub(super) fn ego_way(&self) -> Option<Route> {
        self.arena.ego_car().route.as_ref().map(|r| r.foreseen(EGO_WAY_M, &self.arena.streets.graph))
    }
}
