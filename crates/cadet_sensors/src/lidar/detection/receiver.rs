//! A laser's beam and the receiver behind it, which detects an echo or not.
//!
//! On KITTI's scans hardly a beam is lost at random on a surface that goes on (0.1 % on the ground up to 20 m, 1-2 %
//! anywhere up to 50 m): detection is a threshold, not a chance that fades.

use cadet_base::error::{Result, within};

/// The widest halo about a beam.
const MAX_HALO_RAD: f64 = 0.1;
/// The widest cone of a beam.
pub const MAX_DIVERGENCE_RAD: f64 = 0.02;
/// Speed of light.
pub(super) const LIGHT_M_PER_S: f64 = 299_792_458.0;

/// A laser's beam and the receiver behind it: the same for surfaces, drops, flakes and fog, and for recorded scans.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Receiver {
    /// Half-power width of the laser's pulse. Echoes nearer to each other than [`Receiver::pulse_m`] are one.
    pub pulse_s: f64,
    /// The full cone of a beam.
    pub divergence_rad: f64,
    /// Range at which a target of 10 % that faces the sensor is detected half of the time: how data sheets state
    /// sensitivity.
    pub detection_range_m: f64,
    /// Standard deviation of the range of a strong echo.
    pub range_noise_m: f64,
    /// Share of a pulse that optics scatter evenly over a halo about the beam: what it meets of retroreflectors blooms.
    pub halo_share: f64,
    /// Half the cone of that halo.
    pub halo_rad: f64,
}

impl Default for Receiver {
    /// Velodyne's HDL-64E: by its data sheet pulses of 5 ns and beams of 2 mrad; the noise is that of KITTI's scans of roads
    /// at 5 to 20 m. The detection range is fitted to the returns of KITTI's cars over range, height, and reading: at 40 to
    /// 70 m they lose fewer beams than the data sheet's 10 % of reflectance at 50 m would tell. About their plates nothing blooms.
    fn default() -> Self {
        Self {
            pulse_s: 5e-9,
            divergence_rad: 2e-3,
            detection_range_m: 79.0,
            range_noise_m: 0.0078,
            halo_share: 0.0,
            halo_rad: 10e-3,
        }
    }
}

impl Receiver {
    /// Half the way that light goes in a pulse.
    #[must_use]
    pub fn pulse_m(&self) -> f64 {
        0.5 * self.pulse_s * LIGHT_M_PER_S
    }

    /// Power, in units of reflectance / range^2, that is detected half of the time.
    #[inline(always)]
    #[must_use]
    pub fn threshold(&self) -> f64 {
        0.1 / (self.detection_range_m * self.detection_range_m)
    }

    /// Checks the fields, which anyone may have set.
    ///
    /// # Errors
    /// [`cadet_base::Error::NotFinite`] or [`cadet_base::Error::OutOfRange`], naming the field.
    pub fn check(&self) -> Result<()> {
        for (what, value, least, most) in [
            ("pulse_s", self.pulse_s, 1e-10, 1e-7),
            ("divergence", self.divergence_rad, 1e-5, MAX_DIVERGENCE_RAD),
            ("detection_range_m", self.detection_range_m, 0.1, 10_000.0),
            ("range_noise_m", self.range_noise_m, 0.0, 10.0),
            ("halo_share", self.halo_share, 0.0, 0.1),
            ("halo", self.halo_rad, 0.0, MAX_HALO_RAD),
        ] {
            let _ = within(what, value, least..=most)?;
        }
        Ok(())
    }

    /// True if an echo of `power` (reflectance / range^2) is detected; `chance` is uniform in [0, 1).
    #[inline(always)]
    pub(crate) fn detects(&self, power: f64, chance: f64) -> bool {
        let ratio = power / self.threshold();
        let cube = ratio * ratio * ratio;
        let odds = cube * cube;
        chance * (1.0 + odds) < odds
    }

    /// Standard deviation of the range of an echo of `power`: a weak pulse's center is less certain, by up to half at
    /// the limit of detection.
    #[inline(always)]
    pub(crate) fn noise_m(&self, power: f64) -> f64 {
        self.range_noise_m * (1.0 + 0.5 / (1.0 + power / self.threshold()))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn detection_is_a_threshold() {
        let receiver = Receiver::default();
        let is_detected = |ratio: f64, chance| receiver.detects(ratio * receiver.threshold(), chance);
        assert!(is_detected(2.5, 0.99) && !is_detected(0.4, 0.01));
        assert!(is_detected(1.0, 0.49) && !is_detected(1.0, 0.51) && !is_detected(0.0, 0.0));
    }

    #[test]
    fn weak_echoes_are_noisier_and_a_pulse_is_as_long_as_light_goes() {
        let receiver = Receiver { range_noise_m: 0.01, ..Receiver::default() };
        assert!((receiver.noise_m(1e6) - 0.01).abs() < 1e-9 && (receiver.noise_m(0.0) - 0.015).abs() < 1e-12);
        assert!((receiver.pulse_m() - 0.749).abs() < 1e-3, "{}", receiver.pulse_m());
        for bad in [
            Receiver { pulse_s: 0.0, ..receiver },
            Receiver { divergence_rad: 0.5, ..receiver },
            Receiver { detection_range_m: f64::NAN, ..receiver },
            Receiver { range_noise_m: -1.0, ..receiver },
        ] {
            assert!(bad.check().is_err(), "{bad:?}");
        }
    }
}
