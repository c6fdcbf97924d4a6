//! The intensity that a receiver reports of an echo.
//!
//! Measured on KITTI's scans: compensated for range up to 18 m; below a third of white it falls faster than the logarithm
//! of the power, so that dark and far surfaces read 0; and each laser has its own scale.

use cadet_base::material::Pattern;
use cadet_base::math;

/// The receiver compensates for range up to here.
const COMPENSATED_M: f64 = 18.5;
/// Readings below this are reported as 0.
const LEAST_READING: f64 = 0.035;
/// All lasers of KITTI's sensor agree on surfaces that read this; the weak ones read less on darker ones.
const COMMON_READING: f64 = 0.5;

/// Standard deviation of the reading from beam to beam on one surface: what is finer than a beam's spot differs. What is
/// coarser on paved ground is [`crate::lidar::reflectance::ground_texture`]'s.
///
/// From the quartiles in KITTI's scans: 0.05 within a laser's readings of a road, both together, 0.13 on foliage and people.
pub(crate) fn reading_noise(pattern: Pattern) -> f64 {
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
pub(crate) fn intensity(reflectance: f64, range_m: f64, gain: f64, noise: f64) -> f64 {
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
pub(crate) fn saturated(chance: f64) -> f64 {
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
}
