//! What returns from the air itself.

/// What has less than this share of the power that is detected half of the time is left out: it is detected 1 time in 20.
pub(super) const FAINTEST_SHARE: f64 = 0.6;

/// An echo of a drop, a flake, fog, or spray.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct AirEcho {
    pub range_m: f64,
    /// At the receiver, in units of reflectance / range^2.
    pub power: f64,
}

impl AirEcho {
    /// The stronger one of two.
    pub(super) fn or_stronger(self, other: Option<Self>) -> Self {
        other.filter(|o| o.power >= self.power).unwrap_or(self)
    }
}
