//! Where a LIDAR points when its lasers fire: the azimuths of a turn, or a path of beams that do not spin.

use super::scan_path::{Aim, Raster, Rosette, azimuths_of, check_aims};
use cadet_base::error::{Error, Result, finite};
use cadet_base::math::{self, TAU};

/// The most columns of a turn.
pub const MAX_COLUMNS: usize = u16::MAX as usize;

/// The columns of a scan: where the scanner points when every laser fires. The first three are azimuths of a turn,
/// counter-clockwise from forward; the others do not spin.
#[derive(Debug, Clone, PartialEq)]
pub enum Firing {
    /// In equal steps, the first forward.
    Uniform {
        /// Columns a turn.
        columns: usize,
    },
    /// Evenly, with an encoder that tells the azimuth to a tick: column j fires at `ticks_per_firing * j + phase_ticks`
    /// ticks, and its points are reported at the nearest whole one.
    Encoder {
        /// Ticks a turn.
        ticks_per_turn: u32,
        /// Mean ticks from one firing to the next, at least 1.
        ticks_per_firing: f64,
        /// Where the first firing falls, in ticks, at least 0.
        phase_ticks: f64,
        /// Columns a turn.
        firings: usize,
    },
    /// At these azimuths in radians, rising, in [0, 2 pi).
    Listed(Vec<f64>),
    /// Line by line.
    Raster(Raster),
    /// As two turning prisms point it.
    Rosette(Rosette),
    /// At these aims, in the order of time.
    Table(Vec<Aim>),
}

impl Firing {
    /// Where the scanner points in the scan whose instant is `start_s`, in the order of time; None for one that spins.
    ///
    /// # Errors
    /// [`Error::NotFinite`] and [`Error::OutOfRange`] for times that fall, or what no scanner does.
    pub(crate) fn aims(&self, start_s: f64) -> Result<Option<Vec<Aim>>> {
        let aims = match self {
            Self::Raster(raster) => raster.aims()?,
            Self::Rosette(rosette) => rosette.aims(start_s)?,
            Self::Table(aims) => aims.clone(),
            Self::Uniform { .. } | Self::Encoder { .. } | Self::Listed(_) => return Ok(None),
        };
        check_aims(&aims)?;
        Ok(Some(aims))
    }

    /// The columns' azimuths in radians.
    ///
    /// # Errors
    /// [`Error::NotFinite`] and [`Error::OutOfRange`] for a pattern that does not fit one turn.
    pub fn azimuths_rad(&self) -> Result<Vec<f64>> {
        match self {
            Self::Uniform { columns } => {
                check_columns("number of columns", *columns)?;
                Ok((0..*columns).map(|j| j as f64 * TAU / *columns as f64).collect())
            }
            Self::Encoder { ticks_per_turn, ticks_per_firing, phase_ticks, firings } => {
                check_columns("firings", *firings)?;
                let wrong = |what, value: String, expected: String| Err(Error::OutOfRange { what, value, expected });
                for (what, value, least) in
                    [("ticks_per_firing", *ticks_per_firing, 1.0), ("phase_ticks", *phase_ticks, 0.0)]
                {
                    if finite(what, value)? < least {
                        return wrong(what, value.to_string(), format!("at least {least}"));
                    }
                }
                let ticks = |j: usize| ticks_per_firing * j as f64 + phase_ticks;
                let last = nearest_tick(ticks(firings - 1));
                if last >= f64::from(*ticks_per_turn) {
                    let expected = format!("below {ticks_per_turn}, the ticks of a turn");
                    return wrong("tick of the last firing", last.to_string(), expected);
                }
                let tick_rad = TAU / f64::from(*ticks_per_turn);
                Ok((0..*firings).map(|j| ticks(j) * tick_rad).collect())
            }
            Self::Listed(azimuths_rad) => Ok(azimuths_rad.clone()),
            Self::Raster(_) | Self::Rosette(_) | Self::Table(_) => {
                Ok(azimuths_of(&self.aims(0.0)?.unwrap_or_default()))
            }
        }
    }

    /// How far counter-clockwise of where it fires each of `n` columns is reported, as (cosine, sine).
    pub(crate) fn reporting_turns(&self, n: usize) -> Vec<[f64; 2]> {
        let Self::Encoder { ticks_per_turn, ticks_per_firing, phase_ticks, .. } = self else {
            return vec![[1.0, 0.0]; n];
        };
        let late_ticks = |j: usize| {
            let ticks = ticks_per_firing * j as f64 + phase_ticks;
            nearest_tick(ticks) - ticks
        };
        let tick_rad = TAU / f64::from(*ticks_per_turn);
        (0..n).map(|j| late_ticks(j) * tick_rad).map(|a| [math::cos(a), math::sin(a)]).collect()
    }

    /// An offset that stands for the same beams: with equal steps, whole steps lead from column to column.
    pub(crate) fn reduced_offset_rad(&self, offset_rad: f64) -> f64 {
        let Self::Uniform { columns } = self else {
            return offset_rad;
        };
        let steps = offset_rad / (TAU / *columns as f64);
        let part = steps - steps.floor();
        // What numbers of a few digits leave of a whole step is none.
        if (1e-6..1.0 - 1e-6).contains(&part) { part * (TAU / *columns as f64) } else { 0.0 }
    }
}

fn nearest_tick(ticks: f64) -> f64 {
    (ticks + 0.5).floor()
}

fn check_columns(what: &'static str, columns: usize) -> Result<()> {
    if !(1..=MAX_COLUMNS).contains(&columns) {
        let expected = format!("1 to {MAX_COLUMNS}");
        return Err(Error::OutOfRange { what, value: columns.to_string(), expected });
    }
    Ok(())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn firings_are_even_and_reported_at_the_nearest_tick() {
        let firing = |ticks_per_firing, phase_ticks, firings| Firing::Encoder {
            ticks_per_turn: 4000,
            ticks_per_firing,
            phase_ticks,
            firings,
        };
        let encoder = firing(1.8587, 0.25, 2152);
        let azimuths = encoder.azimuths_rad().expect("one turn");
        let turns = encoder.reporting_turns(2152);
        for (j, (azimuth, [cos, sin])) in azimuths.iter().zip(&turns).enumerate() {
            let tick_rad = TAU / 4000.0;
            assert!((azimuth / tick_rad - 1.8587 * j as f64 - 0.25).abs() < 1e-9);
            let reported = (azimuth + math::atan2(*sin, *cos)) / tick_rad;
            assert!((reported - reported.round()).abs() < 1e-9 && (reported - azimuth / tick_rad).abs() <= 0.5 + 1e-9);
        }
        let text = |f: Firing| f.azimuths_rad().expect_err("bad").to_string();
        assert!(text(firing(1.8587, 0.0, 2154)).contains("tick of the last firing is 4002"));
        assert!(text(firing(0.5, 0.0, 10)).contains("ticks_per_firing is 0.5"));
        assert!(text(firing(1.5, -1.0, 10)).contains("phase_ticks is -1"));
        assert!(text(firing(f64::NAN, 0.0, 10)).contains("ticks_per_firing"));
        assert!(text(Firing::Uniform { columns: 0 }).contains("number of columns is 0"));
    }

    #[test]
    fn whole_steps_are_no_offset() {
        let uniform = Firing::Uniform { columns: 1024 };
        let step = TAU / 1024.0;
        // The OS1's beams stand 4.22 and 1.41 degrees to either side: 12.00 and 4.01 columns.
        assert_eq!(uniform.reduced_offset_rad(-12.0 * step), 0.0);
        assert!((uniform.reduced_offset_rad(3.25 * step) - 0.25 * step).abs() < 1e-12);
        assert!((uniform.reduced_offset_rad(-0.25 * step) - 0.75 * step).abs() < 1e-12);
        assert_eq!(Firing::Listed(vec![0.0]).reduced_offset_rad(0.5), 0.5);
    }
}
