//! When the beams of a turning LIDAR fire: which way it turns, how fast, and where a turn begins.

use strum::{AsRefStr, VariantArray};

use cadet_base::error::{Result, variant, within};
use cadet_base::math::{PI, TAU};

/// Which way a LIDAR turns, seen from above.
#[derive(Debug, Clone, Copy, PartialEq, Eq, AsRefStr, VariantArray)]
pub enum SpinDirection {
    /// From forward to the right.
    #[strum(serialize = "cw")]
    Clockwise,
    /// From forward to the left.
    #[strum(serialize = "ccw")]
    CounterClockwise,
}

impl SpinDirection {
    /// The direction of that name: `cw` or `ccw`.
    ///
    /// # Errors
    /// [`cadet_base::Error::Unknown`], listing the names.
    pub fn from_name(name: &str) -> Result<Self> {
        variant("spin", name, |known| known == name)
    }
}

/// How a LIDAR turns. The beam looks straight ahead at the instant of the image, as the trigger of KITTI's cameras requires.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Spin {
    /// Which way.
    pub direction: SpinDirection,
    /// Turns a second.
    pub rate_hz: f64,
    /// Where a turn begins and ends, counter-clockwise from forward, in [0, 2 pi).
    pub start_rad: f64,
}

/// KITTI's: clockwise, which its raw drives show when their scans are laid over each other, with the seam behind the car.
impl Default for Spin {
    fn default() -> Self {
        Self { direction: SpinDirection::Clockwise, rate_hz: 10.0, start_rad: PI }
    }
}

impl Spin {
    /// Refuses numbers that no LIDAR has.
    ///
    /// # Errors
    /// [`cadet_base::Error::NotFinite`] and [`cadet_base::Error::OutOfRange`].
    pub fn check(&self) -> Result<()> {
        let _ = within("rate_hz", self.rate_hz, 1.0..=100.0)?;
        let _ = within("start azimuth", self.start_rad, 0.0..=TAU)?;
        Ok(())
    }

    /// The share of a turn after which it is at an azimuth, in [0, 1).
    pub(crate) fn share(&self, azimuth_rad: f64) -> f64 {
        let turned_rad = azimuth_rad - self.start_rad;
        let turns = match self.direction {
            SpinDirection::Clockwise => -turned_rad / TAU,
            SpinDirection::CounterClockwise => turned_rad / TAU,
        };
        turns - turns.floor()
    }

    /// When a beam at an azimuth fires, in seconds from the instant of the image; 0 straight ahead.
    #[must_use]
    pub fn firing_time_s(&self, azimuth_rad: f64) -> f64 {
        (self.share(azimuth_rad) - self.share(0.0)) / self.rate_hz
    }

    /// When a turn begins and when it ends, in seconds from the instant of the image.
    #[must_use]
    pub fn span_s(&self) -> [f64; 2] {
        let ahead = self.share(0.0);
        [-ahead / self.rate_hz, (1.0 - ahead) / self.rate_hz]
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn spin(direction: SpinDirection, rate_hz: f64, start_rad: f64) -> Spin {
        Spin { direction, rate_hz, start_rad }
    }

    #[test]
    fn a_turn_is_centered_on_the_instant_and_its_seam_is_behind() {
        for (direction, left_s) in [(SpinDirection::Clockwise, -0.025), (SpinDirection::CounterClockwise, 0.025)] {
            let spin = Spin { direction, ..Spin::default() };
            let time_s = |azimuth_rad| spin.firing_time_s(azimuth_rad);
            assert_eq!(time_s(0.0), 0.0);
            assert!((time_s(PI / 2.0) - left_s).abs() < 1e-12 && (time_s(1.5 * PI) + left_s).abs() < 1e-12);
            let (before, after) = (time_s(PI - 1e-9), time_s(PI + 1e-9));
            assert!((before - 2.0 * left_s).abs() < 1e-9 && (after + 2.0 * left_s).abs() < 1e-9);
            assert_eq!(spin.span_s(), [-0.05, 0.05]);
        }
    }

    #[test]
    fn a_turn_may_begin_anywhere_and_take_any_time() {
        let begins_right = spin(SpinDirection::Clockwise, 20.0, 1.5 * PI);
        // From the right by way of behind and the left to straight ahead, three quarters of the turn.
        for (azimuth_rad, share) in [(PI, -0.5), (PI / 2.0, -0.25), (0.0, 0.0), (1.5 * PI + 1e-9, 0.25)] {
            assert!((begins_right.firing_time_s(azimuth_rad) - share / 20.0).abs() < 1e-9, "{azimuth_rad}");
        }
        let [begin_s, end_s] = begins_right.span_s();
        assert!((begin_s + 0.75 / 20.0).abs() < 1e-12 && (end_s - 0.25 / 20.0).abs() < 1e-12);
        assert_eq!(spin(SpinDirection::CounterClockwise, 5.0, 0.0).span_s(), [0.0, 0.2]);
    }

    #[test]
    fn turns_that_make_no_sense_are_refused() {
        for (rate_hz, start_rad, what) in
            [(0.0, 0.0, "rate_hz is 0"), (f64::NAN, 0.0, "rate_hz is not"), (10.0, -0.1, "start azimuth is -0.1")]
        {
            let text = spin(SpinDirection::Clockwise, rate_hz, start_rad).check().expect_err("bad").to_string();
            assert!(text.contains(what), "{text}");
        }
        assert!(SpinDirection::from_name("left").expect_err("bad").to_string().contains("known: cw, ccw"));
    }
}
