//! Beams that are no lines: at depth edges a beam's spot lies partly on one surface and partly on another.
//!
//! A beam of divergence D (the full cone) is taken for a disc of even power. Four sub-beams at (+-D/4, +-D/4) in
//! azimuth and elevation have the disc's second moments, and each carries a quarter of the pulse.
//!
//! Beams away from edges are left alone: there the middle stands for the whole spot.

use crate::sense::{BeamGrid, Hits, LaserRing, SpinningGrid};
use cadet_base::error::Result;
use cadet_base::math::{self, DPose3, DQuat, DVec3};

/// Ranges of neighboring beams that differ by more than this, and by more than twice what the slope beside them
/// explains, belong to different surfaces.
const EDGE_M: f32 = 0.25;

/// The sub-beams of a sensor: a grid with two rings for each, turned a little to the right and to the left.
#[derive(Debug, Clone)]
pub(crate) struct DivergentBeams {
    /// Full cone of a beam.
    pub divergence_rad: f64,
    grid: SpinningGrid,
    /// Rings by rising elevation.
    rings_upwards: Vec<u32>,
    /// Columns and rings that a spot reaches over.
    reach: [usize; 2],
}

impl DivergentBeams {
    /// The sub-beams of these rings, azimuths and offsets of rings.
    pub(super) fn new(
        rings: &[LaserRing],
        azimuths_rad: &[f64],
        offsets_rad: &[f64],
        divergence_rad: f64,
    ) -> Result<Self> {
        let quarter = divergence_rad / 4.0;
        let sub_ring = |r: &LaserRing, up: f64| LaserRing { elevation_rad: r.elevation_rad + up, ..*r };
        let sub_rings: Vec<LaserRing> =
            rings.iter().flat_map(|r| [sub_ring(r, -quarter), sub_ring(r, quarter)]).collect();
        let sub_offsets: Vec<f64> = offsets_rad.iter().flat_map(|o| [*o; 2]).collect();
        let elevation = |ring: &u32| rings[*ring as usize].elevation_rad;
        let mut rings_upwards: Vec<u32> = (0..rings.len() as u32).collect();
        rings_upwards.sort_by(|a, b| elevation(a).total_cmp(&elevation(b)));
        let reach = [reach(azimuths_rad.iter().copied(), quarter), reach(rings_upwards.iter().map(elevation), quarter)];
        let grid = SpinningGrid::staggered(DPose3::IDENTITY, &sub_rings, azimuths_rad, &sub_offsets)?;
        Ok(Self { divergence_rad, grid, rings_upwards, reach })
    }

    /// The sub-beams to the right and to the left of the beams, as grids in the world.
    pub(crate) fn grids(&self, world_from_velo: DPose3) -> [SpinningGrid; 2] {
        [-1.0, 1.0].map(|left| {
            let half_rad = 0.5 * left * self.divergence_rad / 4.0;
            let turn = DQuat::from_xyzw(0.0, 0.0, math::sin(half_rad), math::cos(half_rad));
            self.grid.at(DPose3 { rotation: world_from_velo.rotation * turn, ..world_from_velo })
        })
    }

    /// Where a beam's lower and upper sub-beams stand in either grid.
    pub(crate) fn cells(beam: u32, num_columns: usize) -> [usize; 2] {
        let (ring, column) = (beam as usize / num_columns, beam as usize % num_columns);
        [0, 1].map(|up| (2 * ring + up) * num_columns + column)
    }

    /// The directions of a beam's sub-beams: right below and above, left below and above.
    pub(crate) fn directions_velo(&self, beam: u32) -> [DVec3; 4] {
        let num_columns = self.grid.columns();
        let [right, left] = self.grids(DPose3::IDENTITY);
        let [below, above] = Self::cells(beam, num_columns);
        [(&right, below), (&right, above), (&left, below), (&left, above)]
            .map(|(grid, at)| grid.beam(at / num_columns, at % num_columns).direction_world)
    }

    /// The beams whose spots may reach over a jump in range, rising.
    pub(crate) fn edge_beams(&self, hits: &Hits) -> Vec<u32> {
        let columns = hits.columns as u32;
        let mut edges = DepthEdges { hits, is_edge: vec![false; hits.depth_m.len()] };
        let mut line: Vec<u32> = Vec::new();
        for ring in 0..hits.rows as u32 {
            line.clear();
            line.extend(ring * columns..(ring + 1) * columns);
            edges.look_along(&line, Ends::Joined, self.reach[0].min(line.len() / 2));
        }
        for column in 0..columns {
            line.clear();
            line.extend(self.rings_upwards.iter().map(|ring| ring * columns + column));
            edges.look_along(&line, Ends::Apart, self.reach[1]);
        }
        edges.is_edge.iter().zip(0_u32..).filter(|(edge, _)| **edge).map(|(_, beam)| beam).collect()
    }
}

/// How the ends of a line of beams lie.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum Ends {
    /// Side by side, as in a ring.
    Joined,
    Apart,
}

/// Marks the beams whose spots may reach over a jump in range, and lists them, rising.
struct DepthEdges<'a> {
    hits: &'a Hits,
    is_edge: Vec<bool>,
}

impl DepthEdges<'_> {
    /// Looks along lines of beams that lie side by side; `reach` of them to either side of a jump are marked.
    fn look_along(&mut self, line: &[u32], ends: Ends, reach: usize) {
        let (n, is_closed) = (line.len(), ends == Ends::Joined);
        let range = |i: usize| self.hits.depth_m[line[i % n] as usize].min(FAR_M);
        let num_steps = if is_closed { n } else { n.saturating_sub(1) };
        for i in 0..num_steps {
            let (here, next) = (range(i), range(i + 1));
            let step = (next - here).abs();
            // Most beams end here.
            if step <= EDGE_M {
                continue;
            }
            let before = (is_closed || i > 0).then(|| (here - range(i + n - 1)).abs());
            let after = (is_closed || i + 2 < n).then(|| (range(i + 2) - next).abs());
            let slope = before.into_iter().chain(after).fold(f32::INFINITY, f32::min);
            if step <= EDGE_M + 2.0 * if slope.is_finite() { slope } else { 0.0 } {
                continue;
            }
            for k in (i + n + 1 - reach)..=(i + n + reach) {
                let place = if is_closed { k % n } else { k.wrapping_sub(n) };
                if let Some(beam) = line.get(place) {
                    self.is_edge[*beam as usize] = true;
                }
            }
        }
    }
}

/// Further than everything, and finite so that differences are numbers.
const FAR_M: f32 = 1e4;

/// How many beams a spot's sub-beams reach over, at least 1, from sorted angles.
fn reach(sorted_rad: impl Iterator<Item = f64> + Clone, quarter_rad: f64) -> usize {
    let steps = sorted_rad.clone().skip(1).zip(sorted_rad).map(|(b, a)| b - a);
    let least = steps.filter(|s| *s > 0.0).fold(f64::INFINITY, f64::min);
    ((quarter_rad / least).ceil() as usize).clamp(1, MAX_REACH)
}

/// Beams to either side of an edge that are split at most.
const MAX_REACH: usize = 64;

#[cfg(test)]
mod tests {
    use super::*;
    use crate::lidar::LidarSpec;
    use cadet_base::math::TAU;
    use cadet_base::rng::Stream;

    #[test]
    fn the_quarters_of_a_beam_share_it_as_a_disc_does() {
        let level = LaserRing::on_axis(0.0, 0.0);
        let divergent = DivergentBeams::new(&[level], &[0.0], &[0.0], 3e-3).expect("valid");
        let spots = divergent.directions_velo(0).map(|d| (d.y / 1.5e-3, d.z / 1.5e-3));
        let mean_square = spots.iter().map(|(y, _)| y * y).sum::<f64>() / 4.0;
        assert!((mean_square - 0.25).abs() < 1e-5, "a disc's second moment is a quarter of its radius squared");
        // A straight edge at a distance u from the middle, in any direction, leaves a segment's area.
        let mut stream = Stream::from_seed("edges", 0);
        for u in [-0.6, -0.3, 0.0, 0.3, 0.6] {
            let n = 20_000;
            let mut covered = 0;
            for _ in 0..n {
                let turn = stream.range(0.0, TAU);
                let (cos, sin) = (math::cos(turn), math::sin(turn));
                covered += spots.iter().filter(|(y, z)| y * cos + z * sin < u).count();
            }
            let share = f64::from(covered as u32) / (4.0 * f64::from(n));
            let area = 0.5 + (u * (1.0 - u * u).sqrt() + math::asin(u)) / math::PI;
            assert!((share - area).abs() < 0.06, "{u}: {share} {area}");
        }
    }

    #[test]
    fn sub_beams_stand_around_their_beam() {
        for spec in [LidarSpec::hdl64e_kitti(), LidarSpec::cadet()] {
            let spec = spec.with_divergence(3e-3).expect("valid");
            let rays = spec.rays();
            let n = spec.num_beams();
            for beam in [0, 1, n / 2 + 17, n - 1] {
                let middle = rays.directions_velo[beam];
                let subs = spec.divergent().expect("set").directions_velo(beam as u32);
                let mean = (subs[0] + subs[1] + subs[2] + subs[3]) * 0.25;
                assert!((mean - middle).length() < 2e-6);
                let left = DVec3::new(-middle.y, middle.x, 0.0).normalize();
                for (sub, (side, up)) in subs.iter().zip([(-1.0, -1.0), (-1.0, 1.0), (1.0, -1.0), (1.0, 1.0)]) {
                    let rho = middle.truncate().length();
                    assert!((left.dot(*sub) - side * 0.75e-3 * rho).abs() < 1e-6);
                    assert!((math::asin(sub.z) - math::asin(middle.z) - up * 0.75e-3).abs() < 1e-12);
                }
            }
        }
    }

    #[test]
    fn edges_are_where_surfaces_part_and_not_where_they_lean() {
        let (rows, columns) = (5, 400);
        let mut hits = Hits::new(rows, columns);
        let ring = |k: usize| LaserRing::on_axis(-0.03 - 0.01 * k as f64, 0.0);
        let azimuths: Vec<f64> = (0..columns).map(|j| j as f64 * TAU / columns as f64).collect();
        let divergent = DivergentBeams::new(&[0, 1, 2, 3, 4].map(ring), &azimuths, &[0.0; 5], 3e-3).expect("valid");
        let edges_of = |hits: &Hits| divergent.edge_beams(hits);
        assert!(edges_of(&hits).is_empty(), "the sky has no edges");
        // A ring of road: from row to row the range grows by steps that grow themselves.
        for row in 0..rows {
            hits.depth_m[row * columns..(row + 1) * columns].fill([60.0, 42.0, 32.0, 26.0, 22.0][row]);
        }
        assert!(edges_of(&hits).is_empty(), "{:?}", edges_of(&hits).len());
        // A wall seen at a grazing angle, up to the top row.
        for row in 0..rows {
            for column in 0..60 {
                hits.depth_m[row * columns + 100 + column] = 2.0 / (0.3 - 0.0035 * column as f32);
            }
        }
        let inside = |b: &&u32| (103..157).contains(&(**b as usize % columns));
        assert_eq!(edges_of(&hits).iter().filter(inside).count(), 0);
        // A post one beam wide, and a hole to the sky.
        hits.depth_m[2 * columns + 300] = 9.0;
        hits.depth_m[2 * columns + 350] = f32::INFINITY;
        let edges = edges_of(&hits);
        for column in [299, 300, 301, 349, 350, 351] {
            assert!(edges.contains(&(2 * columns as u32 + column)), "{column}");
        }
        assert!(edges.windows(2).all(|w| w[0] < w[1]));
    }
}
