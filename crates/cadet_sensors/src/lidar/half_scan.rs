//! The halves of a turn: over each of them the time of a beam rises or falls with its azimuth, without a seam.

use std::sync::{Arc, OnceLock};

use super::spec::{LidarSpec, Scanner};
use super::spin::{Spin, SpinDirection};
use crate::sense::{HalfTurn, SpinningGrid};
use cadet_base::math::{DPose3, TAU};

/// Half of a turn: its columns as a grid of their own.
#[derive(Debug, Clone)]
pub(super) struct HalfScan {
    pub half: HalfTurn,
    pub grid: SpinningGrid,
    /// The turn's columns, rising.
    pub columns: Vec<usize>,
}

/// The halves that were made last, and of which spin: making them takes as long as a scan.
pub(super) type HalvesMade = Arc<OnceLock<(Spin, Arc<Vec<HalfScan>>)>>;

impl Spin {
    /// The first and the second half of a turn.
    fn halves(&self) -> [HalfTurn; 2] {
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

impl LidarSpec {
    /// The halves of a turn that have columns; None for a sensor that does not spin.
    pub(super) fn half_scans(&self) -> Option<Arc<Vec<HalfScan>>> {
        let Scanner::Spinning(_, made) = &self.scanner else { return None };
        let (of, halves) = made.get_or_init(|| (self.spin, Arc::new(self.make_halves())));
        Some(if *of == self.spin { Arc::clone(halves) } else { Arc::new(self.make_halves()) })
    }

    fn make_halves(&self) -> Vec<HalfScan> {
        let make = |(number, half): (usize, HalfTurn)| {
            let is_in = |column: &usize| usize::from(self.spin.share(self.azimuths_rad[*column]) >= 0.5) == number;
            let columns: Vec<usize> = (0..self.num_columns()).filter(is_in).collect();
            let azimuths_rad: Vec<f64> = columns.iter().map(|column| self.azimuths_rad[*column]).collect();
            let offsets_rad = &self.azimuth_offsets_rad;
            let grid = SpinningGrid::staggered(DPose3::IDENTITY, self.rings(), &azimuths_rad, offsets_rad).ok()?;
            Some(HalfScan { half, grid, columns })
        };
        self.spin.halves().into_iter().enumerate().filter_map(make).collect()
    }
}
