//! The paths of beams that do not spin: rasters, rosettes, and tables of directions.

use cadet_base::error::{Error, Result, within};
use cadet_base::math::{self, TAU};

/// The most firings of a path.
pub const MAX_FIRINGS: usize = 1 << 20;

/// The most degrees by which a beam may point up or down.
const MAX_ELEVATION_RAD: f64 = 89.0 * TAU / 360.0;
/// The most seconds between a firing and the scan's instant.
const MAX_TIME_S: f64 = 10.0;

/// Where a scanner points when all its lasers fire at once.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Aim {
    /// Seconds from the scan's instant.
    pub time_s: f64,
    /// Counter-clockwise from forward.
    pub azimuth_rad: f64,
    /// Over the horizon.
    pub elevation_rad: f64,
}

/// The azimuth of every firing of a path.
pub(crate) fn azimuths_of(aims: &[Aim]) -> Vec<f64> {
    aims.iter().map(|aim| aim.azimuth_rad).collect()
}

/// Lines from the left to the right, from the top line to the bottom one, evenly through a period that is centered on the
/// scan's instant.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Raster {
    /// Number of lines.
    pub lines: usize,
    /// Firings of a line.
    pub columns: usize,
    /// Azimuths of the first and the last firing of a line.
    pub azimuth_rad: [f64; 2],
    /// Elevations of the first and the last line.
    pub elevation_rad: [f64; 2],
    /// Seconds from one scan to the next.
    pub period_s: f64,
}

/// What two turning prisms draw around straight ahead, as a Livox Mid-40's do: each deflects the beam by an angle (the paraxial
/// approximation), and deflections add up. A scan goes on where the one before ended.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Rosette {
    /// Firings of a scan.
    pub firings: usize,
    /// Angle by which either prism deflects the beam.
    pub deflections_rad: [f64; 2],
    /// Turns a second of either prism, below 0 for clockwise as the sensor sees it.
    pub prism_rates_hz: [f64; 2],
    /// Seconds from one scan to the next.
    pub period_s: f64,
}

impl Raster {
    pub(super) fn aims(&self) -> Result<Vec<Aim>> {
        let firings = self.lines.saturating_mul(self.columns);
        check_firings(firings)?;
        let at = |[first, last]: [f64; 2], k: usize, n: usize| {
            first + (last - first) * if n > 1 { k as f64 / (n - 1) as f64 } else { 0.5 }
        };
        let aim = |j: usize| Aim {
            time_s: time_s(j, firings, self.period_s),
            azimuth_rad: at(self.azimuth_rad, j % self.columns, self.columns),
            elevation_rad: at(self.elevation_rad, j / self.columns, self.lines),
        };
        Ok((0..firings).map(aim).collect())
    }
}

impl Rosette {
    /// The aims of the scan whose instant is `start_s`.
    pub(crate) fn aims(&self, start_s: f64) -> Result<Vec<Aim>> {
        check_firings(self.firings)?;
        let aim = |j: usize| {
            let time_s = time_s(j, self.firings, self.period_s);
            let (mut left_rad, mut up_rad) = (0.0, 0.0);
            for (deflection_rad, rate_hz) in self.deflections_rad.into_iter().zip(self.prism_rates_hz) {
                let turns = rate_hz * (start_s + time_s);
                let angle_rad = TAU * (turns - turns.floor());
                left_rad += deflection_rad * math::cos(angle_rad);
                up_rad += deflection_rad * math::sin(angle_rad);
            }
            let off_axis_rad = (left_rad * left_rad + up_rad * up_rad).sqrt();
            let share = if off_axis_rad > 0.0 { math::sin(off_axis_rad) / off_axis_rad } else { 1.0 };
            Aim {
                time_s,
                azimuth_rad: math::atan2(share * left_rad, math::cos(off_axis_rad)),
                elevation_rad: math::asin(share * up_rad),
            }
        };
        Ok((0..self.firings).map(aim).collect())
    }
}

/// When the j-th of n firings falls in a period that is centered on 0.
fn time_s(j: usize, n: usize, period_s: f64) -> f64 {
    ((j as f64 + 0.5) / n as f64 - 0.5) * period_s
}

fn check_firings(firings: usize) -> Result<()> {
    if !(1..=MAX_FIRINGS).contains(&firings) {
        let expected = format!("1 to {MAX_FIRINGS}");
        return Err(Error::OutOfRange { what: "number of firings", value: firings.to_string(), expected });
    }
    Ok(())
}

/// Refuses aims that no scanner has, and those out of the order of time.
pub(super) fn check_aims(aims: &[Aim]) -> Result<()> {
    check_firings(aims.len())?;
    let mut earliest_s = -MAX_TIME_S;
    for aim in aims {
        earliest_s = within("time of a firing", aim.time_s, earliest_s..=MAX_TIME_S)?;
        let _ = within("azimuth of a firing", aim.azimuth_rad, -TAU..=TAU)?;
        let _ = within("elevation of a firing", aim.elevation_rad, -MAX_ELEVATION_RAD..=MAX_ELEVATION_RAD)?;
    }
    Ok(())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_raster_fills_its_field_in_its_period() {
        let raster =
            Raster { lines: 3, columns: 5, azimuth_rad: [0.4, -0.4], elevation_rad: [0.1, -0.3], period_s: 0.2 };
        let aims = raster.aims().expect("valid");
        check_aims(&aims).expect("rising");
        let corner = |aim: &Aim| [aim.azimuth_rad, aim.elevation_rad];
        assert_eq!([corner(&aims[0]), corner(&aims[4])], [[0.4, 0.1], [-0.4, 0.1]]);
        assert!((aims[7].azimuth_rad.abs() < 1e-12) && (aims[7].elevation_rad + 0.1).abs() < 1e-12);
        assert!(aims[7].time_s.abs() < 1e-12, "the middle falls on the instant");
        assert!(aims.windows(2).all(|w| (w[1].time_s - w[0].time_s - 0.2 / 15.0).abs() < 1e-12));
        assert_eq!(Raster { lines: 1, columns: 1, ..raster }.aims().expect("valid")[0].azimuth_rad, 0.0);
        assert!(Raster { lines: 0, ..raster }.aims().is_err() && Raster { lines: 1 << 20, ..raster }.aims().is_err());
    }

    #[test]
    fn a_rosette_stays_in_its_cone_and_goes_on() {
        let rosette =
            Rosette { firings: 10_000, deflections_rad: [0.2, 0.1], prism_rates_hz: [121.57, -77.73], period_s: 0.1 };
        let off_axis_rad = |aim: &Aim| math::acos(math::cos(aim.azimuth_rad) * math::cos(aim.elevation_rad));
        let aims = rosette.aims(0.0).expect("valid");
        let off_axis: Vec<f64> = aims.iter().map(off_axis_rad).collect();
        // Between the difference and the sum of both deflections, and it gets to either.
        let (least, most) = off_axis.iter().fold((f64::MAX, 0.0_f64), |(a, b), x| (a.min(*x), b.max(*x)));
        assert!((0.1 - 1e-9..0.1002).contains(&least) && (0.2998..0.3 + 1e-9).contains(&most), "{least} {most}");
        // Both prisms stand alike once in 1 / (121.57 + 77.73) s: then the beam is farthest out.
        let peaks = off_axis.windows(3).filter(|w| w[0] < w[1] && w[1] >= w[2]).count();
        assert!((peaks as f64 - 0.1 * (121.57 + 77.73)).abs() < 1.0, "{peaks}");
        // The next scan's first firing follows this one's last at the same step.
        let next = rosette.aims(0.1).expect("valid");
        let step = |a: &Aim, b: &Aim| math::hypot(b.azimuth_rad - a.azimuth_rad, b.elevation_rad - a.elevation_rad);
        assert!(step(&aims[9_999], &next[0]) < 1.2 * aims.windows(2).map(|w| step(&w[0], &w[1])).fold(0.0, f64::max));
        assert!(step(&aims[0], &next[0]) > 0.01, "it does not repeat itself");
    }

    #[test]
    fn aims_that_no_scanner_has_are_refused() {
        let aim = Aim { time_s: 0.0, azimuth_rad: 0.0, elevation_rad: 0.0 };
        let text = |aims: &[Aim]| check_aims(aims).expect_err("bad").to_string();
        assert!(text(&[]).contains("number of firings is 0"));
        assert!(text(&[aim, Aim { time_s: -0.1, ..aim }]).contains("time of a firing is -0.1"));
        assert!(text(&[Aim { elevation_rad: 1.57, ..aim }]).contains("elevation of a firing is 1.57"));
        assert!(text(&[Aim { azimuth_rad: f64::NAN, ..aim }]).contains("azimuth of a firing"));
        check_aims(&[aim, aim]).expect("two at once");
    }
}
