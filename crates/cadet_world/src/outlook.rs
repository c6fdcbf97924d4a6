//! What agents let each other know.

use super::footprint::Footprint;
use super::junctions::Request;
use crate::streets::Ahead;
use crate::walking::Walk;

/// What an agent lets others know from one look to the next.
#[derive(Default)]
pub(crate) struct Outlook {
    /// The way that a driver has looked at.
    pub way_ahead: Vec<Ahead>,
    /// What it wants of the next junction.
    pub request: Option<Request>,
    /// The place in the lane that it is changing to.
    pub claim: Option<Footprint>,
    /// What a pedestrian is about.
    pub walk: Option<Walk>,
}
