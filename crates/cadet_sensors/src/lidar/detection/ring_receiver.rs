//! The receiver of a ring: its sensor's and its laser's.

use super::laser_receiver::LaserReceiver;
use super::receiver::Receiver;

/// What all echoes of a ring have in common.
#[derive(Debug, Clone, Copy)]
pub(crate) struct RingReceiver {
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

/// What the slant of a surface leaves of a pulse's peak: the spot's near and far edge return it one after the other.
///
/// `spot_pulses_per_m` is [`spot_pulses_per_m`]'s.
#[inline(always)]
fn peak_share(spot_pulses_per_m: f64, range_m: f64, cos_incidence: f64) -> f64 {
    let square = (cos_incidence * cos_incidence).max(1e-6);
    let depth = spot_pulses_per_m * range_m;
    1.0 / (1.0 + depth * depth * (1.0 - square) / square).sqrt()
}

/// How far the power of a spot spreads about its middle (a quarter of the cone, as in an even disc), in pulses per meter.
fn spot_pulses_per_m(receiver: &Receiver) -> f64 {
    receiver.divergence_rad / 4.0 / receiver.pulse_m()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_slanted_spot_returns_late_and_low() {
        let receiver = Receiver { pulse_s: 5e-9, divergence_rad: 2e-3, ..Receiver::default() };
        let share = |range_m, cos| peak_share(spot_pulses_per_m(&receiver), range_m, cos);
        assert_eq!(share(50.0, 1.0), 1.0);
        // Depth of the spot, in pulses, by hand: 30 m * 0.5 mrad * tan / 0.75 m = 0.35 at 86.7 degrees.
        let cos = 1.73 / 30.0;
        let depth = 30.0 * 0.5e-3 * cadet_base::math::tan(cadet_base::math::acos(cos)) / 0.749_481_145;
        assert!((share(30.0, cos) - 1.0 / cadet_base::math::hypot(1.0, depth)).abs() < 1e-9);
    }
}
