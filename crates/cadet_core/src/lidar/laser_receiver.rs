//! What one laser's receiver does otherwise than its sensor's others.

use crate::error::{Error, Result, finite};

/// What tells a laser's receiver from those of its sensor's others.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct LaserReceiver {
    /// Its sensitivity, 1 for an average one.
    pub gain: f64,
    /// By how much it measures too far, whatever it measures. Ideal scans have none.
    pub range_offset_m: f64,
    /// Where its optics are focused: [`super::Receiver::focus_m`].
    pub focus_m: f64,
}

impl Default for LaserReceiver {
    /// An average one without an error.
    fn default() -> Self {
        Self { gain: 1.0, range_offset_m: 0.0, focus_m: 0.0 }
    }
}

/// The most that a laser's range may be off.
const MOST_RANGE_OFFSET_M: f64 = 1.0;
/// The farthest that a laser's optics are focused.
const MOST_FOCUS_M: f64 = 1000.0;

impl LaserReceiver {
    /// Checks the fields, which anyone may have set.
    ///
    /// # Errors
    /// [`Error::NotFinite`] or [`Error::OutOfRange`], naming the field.
    pub fn check(&self) -> Result<()> {
        for (what, value, least, most) in [
            ("laser gain", self.gain, 0.0, f64::MAX),
            ("laser's range offset", self.range_offset_m, -MOST_RANGE_OFFSET_M, MOST_RANGE_OFFSET_M),
            ("laser's focus", self.focus_m, 0.0, MOST_FOCUS_M),
        ] {
            if !(least..=most).contains(&finite(what, value)?) {
                let expected = format!("{least:?} to {most:?}");
                return Err(Error::OutOfRange { what, value: value.to_string(), expected });
            }
        }
        Ok(())
    }
}
