//! The halves of a turn: over each of them the time of a beam rises or falls with its azimuth, without a seam.

use std::sync::{Arc, OnceLock};

use super::spin::{Spin, SpinDirection};
use crate::sense::{HalfTurn, SpinningGrid};
use cadet_base::math::TAU;

/// Half of a turn: its columns as a grid of their own.
#[derive(Debug, Clone)]
pub(crate) struct HalfScan {
    pub half: HalfTurn,
    pub grid: SpinningGrid,
    /// The turn's columns, rising.
    pub columns: Vec<usize>,
}

/// The halves that were made last, and of which spin: making them takes as long as a scan.
pub(crate) type HalvesMade = Arc<OnceLock<(Spin, Arc<Vec<HalfScan>>)>>;

impl Spin {
    /// The first and the second half of a turn.
    pub(crate) fn halves(&self) -> [HalfTurn; 2] {
        let sign = match self.direction {
            SpinDirection::Clockwise => -1.0,
            SpinDirection::CounterClockwise => 1.0,
        };
        let period_s = 1.0 / self.rate_hz;
        [0.25, 0.75].map(|share| HalfTurn {
            middle_rad: (self.start_rad + sign * share * TAU).rem_euclid(TAU),
            middle_s: self.span_s()[0] + share * period_s,
            slope_s_per_rad: sign * period_s / TAU,
        })
    }
}
