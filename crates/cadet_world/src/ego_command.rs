//! Commands to the ego by somebody who drives it in its driver's place.

use super::course::FASTEST_VEHICLE_MPS;
use cadet_base::error::{Error, Result};

/// The farthest from its lane's middle that the ego may be asked to drive.
pub const MAX_LATERAL_M: f64 = 5.0;

/// A speed and a place across the lane. Nobody brakes for others, signals or bends meanwhile.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct EgoCommand {
    /// Speed to reach and keep.
    pub speed_mps: f64,
    /// Offset to the left of the lane's middle to reach and keep.
    pub lateral_m: f64,
}

impl EgoCommand {
    /// # Errors
    /// [`Error::OutOfRange`] for a speed or an offset beyond its limits, or not finite.
    pub fn new(speed_mps: f64, lateral_m: f64) -> Result<Self> {
        for (what, value, least, most) in [
            ("speed_mps", speed_mps, 0.0, FASTEST_VEHICLE_MPS),
            ("lateral_m", lateral_m, -MAX_LATERAL_M, MAX_LATERAL_M),
        ] {
            // NaN is in no range.
            if !(least..=most).contains(&value) {
                let expected = format!("{least} to {most}");
                return Err(Error::OutOfRange { what, value: value.to_string(), expected });
            }
        }
        Ok(Self { speed_mps, lateral_m })
    }
}
