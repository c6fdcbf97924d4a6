//! What a receiver makes of an echo: whether it detects it, and the intensity that it reports.
//!
//! Measured on KITTI's scans. On a surface that goes on, hardly a beam is lost at random (0.1 % on the ground up to
//! 20 m, 1-2 % anywhere up to 50 m): detection is a threshold, not a chance that fades. The reported intensity is
//! compensated for range up to 18 m; below a third of white it falls faster than the logarithm of the power, so that
//! dark and far surfaces read 0; and each laser has its own scale.

use crate::error::{Error, Result, finite};
use crate::material::Pattern;
use crate::math;

/// Speed of light.
pub(super) const LIGHT_M_PER_S: f64 = 299_792_458.0;

/// A laser's beam and the receiver behind it: the same for surfaces, drops, flakes and fog, and for recorded scans.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Receiver {
    /// Half-power width of the laser's pulse. Echoes nearer to each other than [`Receiver::pulse_m`] are one.
    pub pulse_s: f64,
    /// The full cone of a beam.
    pub divergence_rad: f64,
    /// Power, in units of reflectance / range^2, that is detected half of the time.
    pub threshold: f64,
    /// Standard deviation of the range of a strong echo.
    pub range_noise_m: f64,
}

impl Default for Receiver {
    /// Velodyne's HDL-64E: by its data sheet pulses of 5 ns and beams of 2 mrad; the noise is that of KITTI's scans of roads
    /// at 5 to 20 m. The threshold is fitted to the returns of KITTI's cars over range, height, and reading: at 40 to 70 m
    /// they lose fewer beams than the data sheet's 10 % of reflectance at 50 m would tell.
    fn default() -> Self {
        Self { pulse_s: 5e-9, divergence_rad: 2e-3, threshold: 1.6e-5, range_noise_m: 0.0078 }
    }
}

impl Receiver {
    /// Half the way that light goes in a pulse.
    #[must_use]
    pub fn pulse_m(&self) -> f64 {
        0.5 * self.pulse_s * LIGHT_M_PER_S
    }

    /// Checks the fields, which anyone may have set.
    ///
    /// # Errors
    /// [`Error::NotFinite`] or [`Error::OutOfRange`], naming the field.
    pub fn check(&self) -> Result<()> {
        for (what, value, least, most) in [
            ("pulse_s", self.pulse_s, 1e-10, 1e-7),
            ("divergence", self.divergence_rad, 1e-5, MAX_DIVERGENCE_RAD),
            ("threshold", self.threshold, 1e-9, 1.0),
            ("range_noise_m", self.range_noise_m, 0.0, 10.0),
        ] {
            if !(least..=most).contains(&finite(what, value)?) {
                let expected = format!("{least} to {most}");
                return Err(Error::OutOfRange { what, value: value.to_string(), expected });
            }
        }
        Ok(())
    }

    /// True if an echo of `power` (reflectance / range^2) is detected; `chance` is uniform in [0, 1).
    #[inline(always)]
    pub(super) fn detects(&self, power: f64, chance: f64) -> bool {
        let ratio = power / self.threshold;
        let cube = ratio * ratio * ratio;
        let odds = cube * cube;
        chance * (1.0 + odds) < odds
    }

    /// Standard deviation of the range of an echo of `power`: a weak pulse's center is less certain, by up to half at
    /// the limit of detection.
    #[inline(always)]
    pub(super) fn noise_m(&self, power: f64) -> f64 {
        self.range_noise_m * (1.0 + 0.5 / (1.0 + power / self.threshold))
    }
}

/// The widest cone of a beam.
pub const MAX_DIVERGENCE_RAD: f64 = 0.02;
/// The receiver compensates for range up to here.
const COMPENSATED_M: f64 = 18.5;
/// Readings below this are reported as 0.
const LEAST_READING: f64 = 0.035;
/// All lasers of KITTI's sensor agree on surfaces that read this; the weak ones read less on darker ones.
const COMMON_READING: f64 = 0.5;

/// Standard deviation of the reading from beam to beam on one surface: what is finer than a beam's spot differs. What is
/// coarser on paved ground is [`super::ground_texture`]'s.
///
/// From the quartiles in KITTI's scans: 0.05 within a laser's readings of a road, both together, 0.13 on foliage and people.
pub(super) fn reading_noise(pattern: Pattern) -> f64 {
    match pattern {
        Pattern::Asphalt | Pattern::Slabs | Pattern::Blocks => 0.043,
        Pattern::Plain | Pattern::Paint | Pattern::Lamp | Pattern::Window | Pattern::Reflector => 0.07,
        Pattern::Bricks | Pattern::Render | Pattern::Tiles | Pattern::Wood => 0.095,
        Pattern::Grass => 0.085,
        Pattern::Leaves | Pattern::Cloth => 0.135,
    }
}

/// Reported intensity in 0..=0.99, not yet rounded, of an echo with the given reflectance (1: white, facing the
/// sensor). `gain` is the laser's, 1 for an average one; `noise` is added to an average laser's reading.
#[inline(always)]
pub(super) fn intensity(reflectance: f64, range_m: f64, gain: f64, noise: f64) -> f64 {
    let beyond = (range_m / COMPENSATED_M).max(1.0);
    let seen = reflectance / (beyond * beyond);
    if seen < 0.01 {
        return 0.0;
    }
    // Fitted to the medians of road, foliage and facades from 4 m to 70 m: 0.25 at 0.19, 0.34 at 0.4, 0 at 0.06.
    let average = 0.4455 + 0.085 * math::quick_ln(seen) - 0.011 / seen + noise;
    let reading = COMMON_READING + (average - COMMON_READING) / gain.max(1e-3);
    if reading < LEAST_READING { 0.0 } else { reading.min(0.99) }
}

/// Reported intensity of a retroreflector, which overflows the receiver; `chance` is uniform in [0, 1).
#[inline(always)]
pub(super) fn saturated(chance: f64) -> f64 {
    0.99 - 0.02 * chance
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn readings_follow_the_medians_of_real_scans() {
        // (reflectance, range, intensity): road at 10 m; what stands higher than 2 m at 14, 27, 37, 45 and 70 m.
        for (reflectance, range_m, expected) in [
            (0.2, 10.0, 0.25),
            (0.4, 14.0, 0.34),
            (0.4, 27.0, 0.25),
            (0.4, 37.0, 0.15),
            (0.4, 45.0, 0.05),
            (0.4, 70.0, 0.0),
        ] {
            let got = intensity(reflectance, range_m, 1.0, 0.0);
            assert!((got - expected).abs() < 0.04, "{reflectance} at {range_m} m: {got}");
        }
    }

    #[test]
    fn weak_lasers_read_less_on_dark_surfaces_and_the_same_on_bright_ones() {
        let read = |gain, reflectance| intensity(reflectance, 10.0, gain, 0.0);
        assert!(read(0.53, 0.17) < 0.1 && read(1.4, 0.17) > 0.3, "{} {}", read(0.53, 0.17), read(1.4, 0.17));
        assert!((read(0.53, 1.8) - read(1.4, 1.8)).abs() < 0.02);
        assert!(read(0.0, 0.17) == 0.0 && read(1e9, 0.17) <= 0.99);
    }

    #[test]
    fn detection_is_a_threshold() {
        let receiver = Receiver::default();
        let is_detected = |ratio: f64, chance| receiver.detects(ratio * receiver.threshold, chance);
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
            Receiver { threshold: f64::NAN, ..receiver },
            Receiver { range_noise_m: -1.0, ..receiver },
        ] {
            assert!(bad.check().is_err(), "{bad:?}");
        }
    }
}
