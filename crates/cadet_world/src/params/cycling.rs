//! How cyclists ride.

/// Speed on a free road: mean and spread, least and greatest.
pub const CRUISE_MPS: (f64, f64) = (5.0, 0.6);
pub const CRUISE_LIMITS_MPS: (f64, f64) = (4.0, 6.0);
/// From the border of the lane that is the curb or the row of parked cars.
pub const KEEPS_M: (f64, f64) = (0.8, 1.2);
/// Room beside what stands in the lane.
pub const ASIDE_M: f64 = 0.30;
/// How fast one changes sides, meters a look.
pub const SHIFT_M: f64 = 0.03;
/// The tightest turn.
pub const TIGHTEST_PER_M: f64 = 0.55;
/// Acceleration below which a cyclist who slows down does not pedal.
pub const COASTS_MPS2: f64 = -0.3;
/// Share of cyclists who point where they turn, between which distances of a junction, and from which speed on.
pub const POINTS_SHARE: f64 = 0.8;
pub const POINTS_M: (f64, f64) = (5.0, 25.0);
pub const POINTS_MPS: f64 = 1.5;
