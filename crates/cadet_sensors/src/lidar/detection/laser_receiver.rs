//! What one laser's receiver does otherwise than its sensor's others.

use cadet_base::error::{Result, within};

/// What tells a laser's receiver from those of its sensor's others.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct LaserReceiver {
    /// Its sensitivity, 1 for an average one.
    pub gain: f64,
    /// By how much it measures too far, whatever it measures. Ideal scans have none.
    pub range_offset_m: f64,
    /// Where its optics are focused: of what comes from nearer than this a part falls beside the detector. 0 for optics
    /// that lose nothing.
    pub focus_m: f64,
}

impl Default for LaserReceiver {
    /// An average one without an error, focused as the HDL-64E's lower block: no other sensor's near field is known.
    fn default() -> Self {
        Self { gain: 1.0, range_offset_m: 0.0, focus_m: 6.0 }
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
    /// [`cadet_base::Error::NotFinite`] or [`cadet_base::Error::OutOfRange`], naming the field.
    pub fn check(&self) -> Result<()> {
        for (what, value, least, most) in [
            ("laser gain", self.gain, 0.0, f64::MAX),
            ("laser's range offset", self.range_offset_m, -MOST_RANGE_OFFSET_M, MOST_RANGE_OFFSET_M),
            ("laser's focus", self.focus_m, 0.0, MOST_FOCUS_M),
        ] {
            let _ = within(what, value, least..=most)?;
        }
        Ok(())
    }

    /// [`focused`] by this laser's optics.
    #[inline(always)]
    pub(crate) fn focused(&self, range_m: f64) -> f64 {
        focused(self.focus_m, range_m)
    }
}

/// The share of an echo that falls on the detector, of a surface, a drop, or fog: the cube of range over focus, as fitted to
/// KITTI's cars.
#[inline(always)]
pub(crate) fn focused(focus_m: f64, range_m: f64) -> f64 {
    if range_m >= focus_m {
        return 1.0;
    }
    let near = range_m / focus_m;
    near * near * near
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_is_nearer_than_the_focus_falls_beside_the_detector() {
        let of = |focus_m| LaserReceiver { focus_m, ..LaserReceiver::default() };
        assert!((of(20.0).focused(10.0) - 0.125).abs() < 1e-12 && of(20.0).focused(30.0) == 1.0);
        assert!(of(0.0).focused(0.1) == 1.0);
    }
}
