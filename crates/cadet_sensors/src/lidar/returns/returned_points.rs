//! The points that one turn returns.

use crate::lidar::sensor::LidarSpec;
use cadet_base::material::{Pattern, Semantic};

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
    /// Number of the echo among those of its pulse that are detected, the nearest 1.
    pub echo: Vec<u8>,
    /// What returned it, if the sensor records surfaces ([`crate::lidar::LidarSpec::records_surfaces`]); otherwise empty.
    pub surface: Vec<ReturnSurface>,
    /// Range from the laser's own origin, before rounding.
    pub range_m: Vec<f64>,
    /// When each column of the turn fired ([`crate::lidar::LidarSpec::firing_times_s`]); of another length than the others.
    pub firing_times_s: Vec<f64>,
}

/// The surface that returned a point.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct ReturnSurface {
    /// Cosine of the incidence angle, 0..=1; NaN for fog, drops and flakes.
    pub cos_incidence: f32,
    /// Against a white diffuse surface that faces the sensor, with what glass, water, snow and a beam's other parts leave of
    /// it; a retroreflector's is far above 1. NaN for fog, drops and flakes.
    pub reflectance: f32,
    /// Unit normal towards the sensor, in its frame when the laser fired; NaN for fog, drops and flakes.
    pub normal_velo: [f32; 3],
    /// What it is made of; None for fog, drops and flakes.
    pub pattern: Option<Pattern>,
}

impl ReturnSurface {
    /// Fog, a drop or a flake.
    pub(super) const AIR: Self =
        Self { cos_incidence: f32::NAN, reflectance: f32::NAN, normal_velo: [f32::NAN; 3], pattern: None };
}

impl Scan {
    pub(crate) fn of_turn(spec: &LidarSpec) -> Self {
        let n = spec.num_beams();
        Self {
            points_velo: Vec::with_capacity(n),
            ring: Vec::with_capacity(n),
            column: Vec::with_capacity(n),
            actor_id: Vec::with_capacity(n),
            semantic: Vec::with_capacity(n),
            echo: Vec::with_capacity(n),
            surface: Vec::with_capacity(if spec.records_surfaces { n } else { 0 }),
            range_m: Vec::with_capacity(n),
            firing_times_s: spec.firing_times_s(),
        }
    }
}
