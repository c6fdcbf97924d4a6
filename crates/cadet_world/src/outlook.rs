//! What agents let each other know.

use super::footprint::Footprint;
use super::junctions::Request;
use crate::streets::Ahead;
use crate::walking::Walk;

/// The place in a lane that a vehicle is changing to.
#[derive(Debug, Clone, Copy)]
pub(super) struct Claim {
    pub footprint: Footprint,
    pub is_inward: bool,
}

/// What an agent lets others know from one look to the next.
#[derive(Default)]
pub(crate) struct Outlook {
    /// The way that a driver has looked at.
    pub way_ahead: Vec<Ahead>,
    /// What it wants of the next junction.
    pub request: Option<Request>,
    /// Where it is changing lanes to.
    pub claim: Option<Claim>,
    /// What a pedestrian is about.
    pub walk: Option<Walk>,
}
