//! Who comes to a junction, and where it stops before one.

use super::pursuit::Axles;
use crate::town::{LaneId, STOP_LINE_M as PAINTED_M};
use crate::world::footprint::Footprint;
use crate::world::roads::Roads;
use crate::world::route::Route;
use crate::world::slot::Slot;

/// Where the front bumper stops before a junction's first point: out of the sweep of those who turn in.
pub(super) const STOP_LINE_M: f64 = 3.3;

/// The same before the line of a light.
pub(super) const LIGHT_LINE_M: f64 = PAINTED_M.1 + 0.9;

/// Where the front bumper stops at the end of a lane before a junction: fords are kept free.
pub(super) fn line_m(before: LaneId, roads: &Roads) -> f64 {
    let has_ford = roads.signals().arm_of(before).is_some() || roads.signals().has_zebra(before);
    if has_ford { LIGHT_LINE_M } else { STOP_LINE_M }
}

/// Who wants to cross.
#[derive(Clone, Copy)]
pub(super) struct Crossing<'a> {
    pub slot: Slot,
    pub route: &'a Route,
    pub footprint: &'a Footprint,
    /// Of who steers.
    pub axles: Option<Axles>,
    /// All of a train; as long as the vehicle otherwise.
    pub length_m: f64,
    /// Whether it is a tram, which all others let go first.
    pub is_tram: bool,
}

impl Crossing<'_> {
    /// Its speed ahead.
    pub fn speed_mps(&self) -> f64 {
        self.footprint.velocity.dot(self.footprint.heading)
    }
}
