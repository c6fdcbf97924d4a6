//! What a user asks of an agent: which model, where it stands or goes, and what if somebody is there already.

use cadet_base::error::{Error, Result, finite};

/// The fastest that a scripted vehicle may go, a scripted person, and a scripted cyclist.
pub const FASTEST_VEHICLE_MPS: f64 = 70.0;
pub(super) const FASTEST_PERSON_MPS: f64 = 12.0;
pub(super) const FASTEST_CYCLIST_MPS: f64 = 20.0;

/// Which model an agent gets.
#[derive(Debug, Clone, Copy)]
pub enum ModelChoice<'a> {
    /// The one that a seed draws; a person who moves is drawn again until one walks.
    Seed(u64),
    /// One of a user's, by its name.
    Named(&'a str),
}

/// A place at a time.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Waypoint {
    /// Seconds since the agent was added.
    pub t_s: f64,
    /// World frame.
    pub x_m: f64,
    /// World frame.
    pub y_m: f64,
}

/// Where an agent stands, or how it moves.
#[derive(Debug, Clone, PartialEq)]
pub enum Course {
    /// At one place.
    Stand {
        /// The middle of its box, world frame.
        x_m: f64,
        /// World frame.
        y_m: f64,
        /// Counter-clockwise from east.
        yaw_rad: f64,
    },
    /// From a place straight on at a constant speed, to the edge of the ground.
    Straight {
        /// The middle of its box at the start, world frame.
        x_m: f64,
        /// World frame.
        y_m: f64,
        /// Counter-clockwise from east.
        yaw_rad: f64,
        /// Along its heading.
        speed_mps: f64,
    },
    /// Through places at given times, straight and at a constant speed between two of them. It stands at the first one
    /// before its time, and at the last one after.
    Path(Vec<Waypoint>),
}

/// What if an agent is put where another stands.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Overlap {
    /// An error that names the other one.
    Refuse,
    /// Both stand there.
    Allow,
}

/// Checks the points of a path.
///
/// # Errors
/// [`Error::Scene`] for fewer than 2 points, times that do not rise from 0 on and speeds above `fastest_mps`,
/// [`Error::NotFinite`].
pub(super) fn check_path(points: &[Waypoint], fastest_mps: f64) -> Result<()> {
    let fail = |reason: String| Err(Error::Scene { reason: format!("path: {reason}") });
    for point in points {
        finite("path t", point.t_s)?;
        finite("path x", point.x_m)?;
        finite("path y", point.y_m)?;
    }
    let Some(first) = points.first().filter(|_| points.len() >= 2) else {
        return fail(format!("expected at least 2 points, got {}", points.len()));
    };
    if first.t_s < 0.0 {
        return fail(format!("expected times from 0 s on, got {} s at point 0", first.t_s));
    }
    for (i, pair) in points.windows(2).enumerate() {
        let (a, b) = (pair[0], pair[1]);
        if b.t_s <= a.t_s {
            return fail(format!("expected rising times, got {} s at point {} after {} s", b.t_s, i + 1, a.t_s));
        }
        let speed_mps = cadet_base::math::hypot(b.x_m - a.x_m, b.y_m - a.y_m) / (b.t_s - a.t_s);
        if speed_mps > fastest_mps {
            return fail(format!(
                "expected at most {fastest_mps} m/s, got {speed_mps:.1} m/s on the way to point {}",
                i + 1
            ));
        }
    }
    Ok(())
}
