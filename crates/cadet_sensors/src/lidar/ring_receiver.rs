//! The receiver of a ring: its sensor's and its laser's.

use super::laser_receiver::LaserReceiver;
use super::receiver::Receiver;
use super::reflection::{peak_share, spot_pulses_per_m};

/// What all echoes of a ring have in common.
#[derive(Debug, Clone, Copy)]
pub(super) struct RingReceiver {
    pub receiver: Receiver,
    pub laser: LaserReceiver,
    /// [`spot_pulses_per_m`]'s of the receiver.
    spot_pulses_per_m: f64,
    pub min_range_m: f64,
    pub max_range_m: f64,
}

impl RingReceiver {
    /// The receiver of a laser whose points from the first range to the second are kept, meters.
    pub fn new(receiver: Receiver, laser: LaserReceiver, [min_range_m, max_range_m]: [f64; 2]) -> Self {
        Self { receiver, laser, spot_pulses_per_m: spot_pulses_per_m(&receiver), min_range_m, max_range_m }
    }

    /// What the slant of a surface leaves of its echo's peak.
    #[inline(always)]
    pub fn peak_share(&self, range_m: f64, cos_incidence: f64) -> f64 {
        peak_share(self.spot_pulses_per_m, range_m, cos_incidence)
    }

    /// What a surface's power counts for detection: its peak, as far as it falls on the detector.
    #[inline(always)]
    pub fn detected_share(&self, range_m: f64, cos_incidence: f64) -> f64 {
        self.laser.focused(range_m) * self.peak_share(range_m, cos_incidence)
    }
}
