//! Where and when a LIDAR's beams go.

use std::sync::Arc;

use super::spec::{LidarSpec, Scanner};
use crate::lidar::scan_pattern::{Aim, Firing, HalfScan, azimuths_of};
use crate::sense::{HalfTurn, LaserRing, RigidMotion, SpinningGrid};
use cadet_base::math::{self, DPose3, DVec3, TAU, wrap_angle};

/// A sensor's beams in its own frame, ring-major, azimuth rising counter-clockwise from forward.
#[derive(Debug, Clone, PartialEq)]
pub struct Rays {
    /// Where each beam starts.
    pub origins_velo: Vec<DVec3>,
    /// Unit directions.
    pub directions_velo: Vec<DVec3>,
    /// Ring of each beam, 0 the first of the sensor's table.
    pub ring: Vec<i32>,
    /// Column of each beam.
    pub column: Vec<i32>,
}

/// Where a beam starts and where it goes, in the sensor's frame at its firing.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct BeamLine {
    pub origin_velo: DVec3,
    /// Of unit length.
    pub direction_velo: DVec3,
}

/// How far from a thing's direction beams count as pointing at it.
const TOWARD_RAD: f64 = 1.0 * TAU / 360.0;

impl LidarSpec {
    /// Firings of a scan.
    #[must_use]
    pub fn num_columns(&self) -> usize {
        self.azimuths_rad.len()
    }

    /// Beams of a scan.
    #[must_use]
    pub fn num_beams(&self) -> usize {
        self.rings().len() * self.num_columns()
    }

    /// False for a sensor whose beams follow a path ([`crate::lidar::Raster`], [`crate::lidar::Rosette`], a table).
    #[must_use]
    pub fn spins(&self) -> bool {
        matches!(self.scanner, Scanner::Spinning(..))
    }

    /// The beams as a grid in the world; None for a sensor that does not spin.
    #[must_use]
    pub fn grid(&self, world_from_velo: DPose3) -> Option<SpinningGrid> {
        match &self.scanner {
            Scanner::Spinning(grid, _) => Some(grid.at(world_from_velo)),
            Scanner::Path(_) => None,
        }
    }

    /// The beams of a ring, by their columns.
    pub(crate) fn beams(&self, ring: usize) -> impl Fn(usize) -> BeamLine + '_ {
        let (laser, offset_rad) = (self.rings()[ring], self.azimuth_offsets_rad[ring]);
        let level = laser.directions_velo();
        // Of a ring, so that it is not looked up for each of its beams.
        let (headings, aims): (&[[f64; 2]], &[Aim]) = match &self.scanner {
            Scanner::Spinning(grid, _) => (grid.headings(ring), &[]),
            Scanner::Path(aims) => (&[], aims),
        };
        move |column| {
            if let Some(heading) = headings.get(column) {
                return BeamLine { origin_velo: laser.origin_velo(*heading), direction_velo: level(*heading) };
            }
            let azimuth_rad = aims[column].azimuth_rad + offset_rad;
            let heading = [math::cos(azimuth_rad), math::sin(azimuth_rad)];
            let raised = LaserRing::on_axis(laser.elevation_rad + aims[column].elevation_rad, laser.height_m);
            BeamLine { origin_velo: raised.origin_velo(heading), direction_velo: raised.directions_velo()(heading) }
        }
    }

    /// Every beam, in the order of a scan's rows. A path that goes on from scan to scan is that of the scan at 0 s.
    #[must_use]
    pub fn rays(&self) -> Rays {
        let n = self.num_beams();
        let (ring, column) = self.beam_numbers();
        let mut rays =
            Rays { origins_velo: Vec::with_capacity(n), directions_velo: Vec::with_capacity(n), ring, column };
        for ring in 0..self.rings().len() {
            for line in (0..self.num_columns()).map(self.beams(ring)) {
                rays.origins_velo.push(line.origin_velo);
                rays.directions_velo.push(line.direction_velo);
            }
        }
        rays
    }

    /// Ring and column of every beam, in the order of a scan's rows.
    #[must_use]
    pub fn beam_numbers(&self) -> (Vec<i32>, Vec<i32>) {
        let (mut rings, mut columns) = (Vec::with_capacity(self.num_beams()), Vec::with_capacity(self.num_beams()));
        for ring in 0..self.rings().len() {
            rings.resize(rings.len() + self.num_columns(), ring as i32);
            columns.extend(0..self.num_columns() as i32);
        }
        (rings, columns)
    }

    /// The mean angle between neighboring beams of a ring; for a path as if its beams filled their field evenly.
    #[must_use]
    pub fn beam_step_rad(&self) -> f64 {
        let extent = |values: &mut dyn Iterator<Item = f64>| {
            let (least, most) = values.fold((f64::MAX, f64::MIN), |(a, b), v| (a.min(v), b.max(v)));
            most - least
        };
        let across_rad = extent(&mut self.azimuths_rad.iter().copied());
        match &self.scanner {
            Scanner::Spinning(..) => across_rad / (self.num_columns() - 1).max(1) as f64,
            Scanner::Path(aims) => {
                (across_rad * extent(&mut aims.iter().map(|aim| aim.elevation_rad)) / aims.len() as f64).sqrt()
            }
        }
    }

    /// For every column of a ring, whether the car that carries the sensor is in the way.
    pub(crate) fn blind_columns(&self, ring: usize) -> Vec<bool> {
        let sectors: Vec<_> = self.blind_sectors.iter().filter(|s| s.ring == ring).collect();
        if sectors.is_empty() {
            return vec![false; self.num_columns()];
        }
        let is_blind = |azimuth: &f64| {
            let azimuth_rad = (azimuth + self.azimuth_offsets_rad[ring]).rem_euclid(TAU);
            sectors.iter().any(|sector| (sector.from_rad..sector.to_rad).contains(&azimuth_rad))
        };
        self.azimuths_rad.iter().map(is_blind).collect()
    }

    /// When a column fires, in seconds from the scan's instant.
    #[must_use]
    pub fn firing_time_s(&self, column: usize) -> f64 {
        match &self.scanner {
            Scanner::Spinning(..) => self.spin.firing_time_s(self.azimuths_rad[column]),
            Scanner::Path(aims) => aims[column].time_s,
        }
    }

    /// When each column fires, in seconds from the instant of the image: 0 for all where nothing moves meanwhile.
    #[must_use]
    pub fn firing_times_s(&self) -> Vec<f64> {
        (0..self.num_columns()).map(|column| if self.rolling { self.firing_time_s(column) } else { 0.0 }).collect()
    }

    /// When a scan begins and when it ends, in seconds from its instant.
    #[must_use]
    pub fn span_s(&self) -> [f64; 2] {
        match &self.scanner {
            Scanner::Spinning(..) => self.spin.span_s(),
            Scanner::Path(aims) => [aims[0].time_s, aims[aims.len() - 1].time_s],
        }
    }

    /// This sensor with the path of the scan whose instant is `start_s`, where paths go on from scan to scan.
    #[must_use]
    pub fn at_time(mut self, start_s: f64) -> Self {
        if let Firing::Rosette(rosette) = self.firing()
            && let Ok(aims) = rosette.aims(start_s)
        {
            self.azimuths_rad = azimuths_of(&aims);
            self.scanner = Scanner::Path(aims);
        }
        self
    }

    /// The halves of a turn that have columns; None for a sensor that does not spin.
    pub(crate) fn half_scans(&self) -> Option<Arc<Vec<HalfScan>>> {
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
            if columns.is_empty() {
                return None;
            }
            let grid = SpinningGrid::staggered(DPose3::IDENTITY, self.rings(), &azimuths_rad, offsets_rad)
                .expect("checked with all columns");
            Some(HalfScan { half, grid, columns })
        };
        self.spin.halves().into_iter().enumerate().filter_map(make).collect()
    }

    /// The mean time at which beams point to a place, in seconds from the scan's instant; 0 where none does.
    fn time_toward_s(&self, place_velo: DVec3) -> f64 {
        let azimuth_rad = math::atan2(place_velo.y, place_velo.x);
        let Scanner::Path(aims) = &self.scanner else { return self.spin.firing_time_s(azimuth_rad) };
        let across_m = math::hypot(place_velo.x, place_velo.y);
        let elevation_rad = math::atan2(place_velo.z, across_m);
        let (mut sum_s, mut n) = (0.0, 0_u32);
        for (laser, offset_rad) in self.rings().iter().zip(&self.azimuth_offsets_rad) {
            let (left_rad, up_rad) = (azimuth_rad - offset_rad, elevation_rad - laser.elevation_rad);
            for aim in aims.iter().filter(|aim| (aim.elevation_rad - up_rad).abs() < TOWARD_RAD) {
                if wrap_angle(aim.azimuth_rad - left_rad).abs() < TOWARD_RAD {
                    (sum_s, n) = (sum_s + aim.time_s, n + 1);
                }
            }
        }
        if n > 0 { sum_s / f64::from(n) } else { 0.0 }
    }

    /// Where a moving body lies among the points of one scan, each of which is in the frame of its own firing: its pose in
    /// the sensor's frame when beams point at it, from where the sensor is at the instant 0.
    #[must_use]
    pub fn seen_pose(
        &self,
        (world_from_body, body): (&DPose3, &RigidMotion),
        (world_from_velo, sensor): (&DPose3, &RigidMotion),
    ) -> DPose3 {
        let mut seen = *world_from_body;
        // While the beam gets there, body and sensor move by less than a hundredth of their distance.
        for _ in 0..4 {
            let time_s = self.time_toward_s(world_from_velo.inverse().transform_point(seen.translation));
            let velo_from_world = (sensor.displacement(time_s) * *world_from_velo).inverse();
            seen = *world_from_velo * velo_from_world * body.displacement(time_s) * *world_from_body;
        }
        seen
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn rays_are_ring_major_unit_and_counter_clockwise() {
        let rays = LidarSpec::hdl64e_kitti().rays();
        assert_eq!(rays.directions_velo.len(), 137_728);
        let first = rays.directions_velo[0];
        assert!(first.y.abs() < 1e-12 && first.x > 0.99);
        for (i, d) in rays.directions_velo.iter().enumerate() {
            assert!((d.length() - 1.0).abs() < 1e-12);
            assert_eq!((rays.ring[i], rays.column[i]), ((i / 2152) as i32, (i % 2152) as i32));
        }
        assert!(rays.directions_velo[538].y > 0.99, "a quarter turn is to the left");
        let ring_40 = rays.directions_velo[40 * 2152];
        assert!((math::asin(ring_40.z).to_degrees() + 13.041).abs() < 1e-9);
        assert_eq!(rays.origins_velo[40 * 2152], DVec3::new(0.0, -0.026, 0.1229));
        // Odd rings sit on the left: looking to the left, that is behind.
        assert!((rays.origins_velo[41 * 2152 + 538] - DVec3::new(-0.026, 0.0, 0.1226)).length() < 1e-4);
    }
}
