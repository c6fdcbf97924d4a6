//! Beams that are no lines: at depth edges a beam's spot lies partly on one surface and partly on another.
//!
//! A beam of divergence D (the full cone) is taken for a disc of even power. Four sub-beams at (+-D/4, +-D/4) in
//! azimuth and elevation have the disc's second moments, and each carries a quarter of the pulse. Echoes that return
//! within one pulse length of another reach the receiver as one, at their common centre: a mixed point between two
//! surfaces. What lies farther apart makes echoes of its own, of which the sensor reports the strongest or the last.
//!
//! Beams away from edges are left alone: there the middle stands for the whole spot.

use super::air::Air;
use super::returns::{Echo, echo_power, is_heard};
use super::spec::ReturnMode;
use crate::error::Result;
use crate::math::{DPose3, DVec3, TAU};
use crate::sense::{Hits, NO_HIT, TurretGrid, TurretRing};

/// Echoes nearer to each other than this are one: half the way that light goes in a pulse of 5 ns.
pub(super) const PULSE_M: f64 = 0.75;
/// Ranges of neighbouring beams that differ by more than this, and by more than twice what the slope beside them
/// explains, belong to different surfaces.
const EDGE_M: f32 = 0.25;

/// What a beam or a sub-beam met.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct SubBeam {
    /// Range from the laser's origin, infinite for a miss.
    pub range_m: f32,
    /// Index into the scene's instances, [`NO_HIT`] for a miss.
    pub instance: u32,
    /// Face of the instance's mesh.
    pub face: u32,
}

impl SubBeam {
    /// A miss.
    pub(super) const MISS: Self = Self { range_m: f32::INFINITY, instance: NO_HIT, face: NO_HIT };
}

/// The sub-beams of a sensor: a turret of twice as many rings and columns.
#[derive(Debug, Clone)]
pub(super) struct Spread {
    /// Full cone of a beam.
    pub divergence_rad: f64,
    turret: TurretGrid,
    /// The two sub-columns of each column, right and left of it.
    columns: Vec<[u32; 2]>,
}

impl Spread {
    /// The sub-beams of these rings and azimuths.
    pub(super) fn new(rings: &[TurretRing], azimuths_rad: &[f64], divergence_rad: f64) -> Result<Self> {
        let quarter = divergence_rad / 4.0;
        let sub_ring = |r: &TurretRing, offset: f64| TurretRing { elevation_rad: r.elevation_rad + offset, ..*r };
        let sub_rings: Vec<TurretRing> =
            rings.iter().flat_map(|r| [sub_ring(r, -quarter), sub_ring(r, quarter)]).collect();
        // Neighbours' sub-columns may pass each other, and the first goes around the seam.
        let mut sub_columns: Vec<(f64, usize)> = azimuths_rad
            .iter()
            .flat_map(|a| [a - quarter, a + quarter])
            .map(|a| {
                if a < 0.0 {
                    a + TAU
                } else if a >= TAU {
                    a - TAU
                } else {
                    a
                }
            })
            .enumerate()
            .map(|(i, a)| (a, i))
            .collect();
        sub_columns.sort_by(|a, b| a.0.total_cmp(&b.0).then(a.1.cmp(&b.1)));
        let mut columns = vec![[0; 2]; azimuths_rad.len()];
        for (place, (_, i)) in sub_columns.iter().enumerate() {
            columns[i / 2][i % 2] = place as u32;
        }
        let sub_azimuths: Vec<f64> = sub_columns.iter().map(|(a, _)| *a).collect();
        Ok(Self { divergence_rad, turret: TurretGrid::new(DPose3::IDENTITY, &sub_rings, &sub_azimuths)?, columns })
    }

    /// The sub-beams as a grid in the world.
    pub(super) fn grid(&self, world_from_velo: DPose3) -> TurretGrid {
        self.turret.at(world_from_velo)
    }

    /// Where a beam's four sub-beams stand in the grid: below right, below left, above right, above left.
    pub(super) fn cells(&self, beam: u32, num_columns: usize) -> [usize; 4] {
        let (ring, column) = (beam as usize / num_columns, beam as usize % num_columns);
        let [right, left] = self.columns[column].map(|c| c as usize);
        let row = |k: usize| (2 * ring + k) * 2 * num_columns;
        [row(0) + right, row(0) + left, row(1) + right, row(1) + left]
    }

    /// The directions of a beam's sub-beams, in the order of [`Spread::cells`].
    pub(super) fn directions_velo(&self, ring: &TurretRing, azimuth_rad: f64) -> [DVec3; 4] {
        let quarter = self.divergence_rad / 4.0;
        [(-1.0, -1.0), (-1.0, 1.0), (1.0, -1.0), (1.0, 1.0)]
            .map(|(up, left)| super::spec::direction(ring.elevation_rad + up * quarter, azimuth_rad + left * quarter))
    }
}

/// The beams beside a jump in range, rising.
pub(super) fn edge_beams(hits: &Hits) -> Vec<u32> {
    // Beyond everything, and finite so that differences are numbers.
    const FAR_M: f32 = 1e4;
    let (rows, columns) = (hits.rows, hits.columns);
    let range = |row: usize, column: usize| hits.depth[row * columns + column].min(FAR_M);
    let mut is_edge = vec![false; rows * columns];
    let differs = |before: Option<f32>, a: f32, b: f32, after: Option<f32>| {
        let step = (b - a).abs();
        // Most beams end here.
        step > EDGE_M && {
            let slope =
                before.map_or(f32::INFINITY, |p| (a - p).abs()).min(after.map_or(f32::INFINITY, |n| (n - b).abs()));
            step > EDGE_M + 2.0 * if slope.is_finite() { slope } else { 0.0 }
        }
    };
    for row in 0..rows {
        for column in 0..columns {
            let here = range(row, column);
            let next = (column + 1) % columns;
            if differs(
                Some(range(row, (column + columns - 1) % columns)),
                here,
                range(row, next),
                Some(range(row, (next + 1) % columns)),
            ) {
                is_edge[row * columns + column] = true;
                is_edge[row * columns + next] = true;
            }
            if row + 1 < rows {
                let before = (row > 0).then(|| range(row - 1, column));
                let after = (row + 2 < rows).then(|| range(row + 2, column));
                if differs(before, here, range(row + 1, column), after) {
                    is_edge[row * columns + column] = true;
                    is_edge[(row + 1) * columns + column] = true;
                }
            }
        }
    }
    is_edge.iter().zip(0_u32..).filter(|(edge, _)| **edge).map(|(_, beam)| beam).collect()
}

/// What the receiver makes of the echoes of a beam's four quarters: the strongest that stand apart, or the last that is
/// heard. None where none of them answers.
pub(super) fn chosen_echo(quarters: [Option<Echo>; 4], mode: ReturnMode, air: &Air, detection: f64) -> Option<Echo> {
    let mut sorted = quarters;
    sorted.sort_by(|a, b| {
        let range_m = |e: &Option<Echo>| e.map_or(f64::INFINITY, |e| e.range_m);
        range_m(a).total_cmp(&range_m(b))
    });
    let mut chosen: Option<Echo> = None;
    let mut rest = &sorted[..sorted.iter().filter(|e| e.is_some()).count()];
    while let Some(first) = rest.first().copied().flatten() {
        let joined = rest.iter().flatten().take_while(|e| e.range_m - first.range_m < PULSE_M).count();
        let echo = merged(&rest[..joined]);
        rest = &rest[joined..];
        let is_better = match mode {
            ReturnMode::Strongest => chosen.is_none_or(|c| rank(&echo, air) > rank(&c, air)),
            ReturnMode::Last => chosen.is_none() || is_heard(&echo, air, detection),
        };
        if is_better {
            chosen = Some(echo);
        }
    }
    chosen
}

/// Retro-reflectors outshine whatever stands beside them.
fn rank(echo: &Echo, air: &Air) -> f64 {
    echo_power(echo, air) * if echo.retro { 1e3 } else { 1.0 }
}

/// One echo of several that arrive together, each with a quarter of the pulse: their power adds up, their range is its
/// centre, and the strongest gives its name.
fn merged(quarters: &[Option<Echo>]) -> Echo {
    let raw_power = |e: &Echo| e.reflectance / (e.range_m * e.range_m);
    let echoes = || quarters.iter().flatten();
    let mut out = *echoes().next().expect("at least one echo");
    let total: f64 = echoes().map(raw_power).sum();
    for echo in echoes() {
        if raw_power(echo) > raw_power(&out) {
            out = *echo;
        }
    }
    if total > 0.0 {
        out.range_m = echoes().map(|e| raw_power(e) * e.range_m).sum::<f64>() / total;
    }
    out.retro = echoes().any(|e| e.retro);
    out.reflectance = 0.25 * total * out.range_m * out.range_m;
    out
}
