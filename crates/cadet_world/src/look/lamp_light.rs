//! What the lamps of all vehicles depend on.

use cadet_base::rng::StreamKey;

/// What lamps depend on besides who drives.
pub(crate) struct LampLight {
    pub time_s: f64,
    /// Of the scene: every agent blinks at a phase of its own.
    pub key: StreamKey,
    /// Whether it is dim enough for low beams.
    pub needs_lamps: bool,
    pub is_night: bool,
}
