//! The points that one turn returns.

use super::spec::LidarSpec;
use cadet_base::material::Semantic;

/// The returns of one turn: ring-major, azimuth rising counter-clockwise from forward. The arrays of returns have one length.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct Scan {
    /// x, y, z in meters, rounded to 1 mm, and intensity in 0..=0.99, rounded to 0.01.
    pub points_velo: Vec<[f32; 4]>,
    /// Ring of each return.
    pub ring: Vec<i32>,
    /// Column of each return.
    pub column: Vec<i32>,
    /// 0 for the static world and the air, at least 1 for actors.
    pub actor_id: Vec<i32>,
    /// What it came from; [`Semantic::Sky`] for fog, drops and flakes.
    pub semantic: Vec<Semantic>,
    /// Range from the laser's own origin, before rounding.
    pub range_m: Vec<f64>,
    /// When each column of the turn fired ([`super::LidarSpec::firing_times_s`]); of another length than the others.
    pub firing_times_s: Vec<f64>,
}

impl Scan {
    pub(super) fn of_turn(spec: &LidarSpec) -> Self {
        let n = spec.num_beams();
        Self {
            points_velo: Vec::with_capacity(n),
            ring: Vec::with_capacity(n),
            column: Vec::with_capacity(n),
            actor_id: Vec::with_capacity(n),
            semantic: Vec::with_capacity(n),
            range_m: Vec::with_capacity(n),
            firing_times_s: spec.firing_times_s(),
        }
    }
}
