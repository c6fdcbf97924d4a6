//! How much of its own beam the receiver sees at short range.

/// The receiver sees nothing nearer than this, and all of its beam from [`OPEN_M`] on.
pub(super) const CLOSED_M: f64 = 0.9;
const OPEN_M: f64 = 1.0;

/// The receiver's view of its own beam: 0 below 0.9 m, linear to 1 at 1.0 m.
pub(super) fn crossover(range_m: f64) -> f64 {
    ((range_m - CLOSED_M) / (OPEN_M - CLOSED_M)).clamp(0.0, 1.0)
}
