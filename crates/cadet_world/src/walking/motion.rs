//! What a pedestrian is about, and with whom.

use crate::slot::Slot;
use cadet_base::math::DVec2;

/// What a person is about.
#[derive(Debug, Clone, Copy)]
pub(crate) enum Motion {
    /// Standing for good.
    Stands,
    /// Along a walkway, `direction` +1 or -1.
    Walks { walkway: usize, s_m: f64, direction: f64 },
    /// At the curb, looking for a gap; then over to a place of another walkway.
    Waits { from: DVec2, to: DVec2, walkway: usize, s_m: f64 },
    /// On the road.
    Crosses { to: DVec2, walkway: usize, s_m: f64 },
}

/// A place in a group, relative to the one who leads.
#[derive(Debug, Clone, Copy)]
pub(crate) struct GroupPlace {
    /// The one who leads.
    pub leader: Slot,
    /// To the left of the leader's place across the walkway's line.
    pub aside_m: f64,
    pub behind_m: f64,
}

/// What others may know of a pedestrian.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Walk {
    pub motion: Motion,
    /// 0 to stop, 1 to walk on.
    pub pace_share: f64,
    /// The line that is aimed at: offset to the left of the walkway's.
    pub wanted_m: f64,
}
