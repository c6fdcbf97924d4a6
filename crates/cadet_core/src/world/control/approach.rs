//! Who comes to a junction, and where it stops before one.

use crate::world::footprint::Footprint;
use crate::world::route::Route;
use crate::world::slot::Slot;

/// Where the front bumper stops before a junction's first point: out of the sweep of those who turn in.
pub(super) const STOP_LINE_M: f64 = 3.3;

/// Who wants to cross.
#[derive(Clone, Copy)]
pub(super) struct Crossing<'a> {
    pub slot: Slot,
    pub route: &'a Route,
    pub footprint: &'a Footprint,
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
