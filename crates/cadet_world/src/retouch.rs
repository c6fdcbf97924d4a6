//! What the sensors are shown of an actor.

use cadet_base::math::DPose3;

/// What snapshots show of an actor in place of what is there, for those who ask what it changes. The world goes on as if
/// nothing had been asked.
#[derive(Debug, Clone, Copy)]
pub enum Retouch {
    /// Nothing.
    Absent,
    /// The actor, moved and turned in its own box frame.
    Moved {
        /// Where it is shown.
        box_from_shown: DPose3,
    },
}
