//! The beams of a spinning LIDAR: rings of lasers on one vertical axis, each firing at the same azimuths.

use std::ops::Range;
use std::sync::Arc;

use super::edges::EdgePlanes;
use super::grid::{Beam, BeamGrid, Window, tangents_of_circle};
use super::turret_table::{AZIMUTH_MARGIN, NARROW_RAD, POLAR, SortedRow, TURN, Table, azimuth_of};
use crate::error::{Error, Result, finite};
use crate::geometry::{LANES, Lanes};
use crate::math::{self, DPose3, DVec3, TAU, Vec3};

/// Columns that a wide window is searched by.
const BLOCK: usize = 16;

/// One laser of a turret.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct TurretRing {
    /// Elevation of the beam over the horizon.
    pub elevation_rad: f64,
    /// Height of the laser's origin over the sensor's frame, on the z axis.
    pub height_m: f64,
}

/// A turret in the world: row = ring (in the order given), column = azimuth. Depth is the range from the laser's own
/// origin `(0, 0, height_m)`.
#[derive(Debug, Clone)]
pub struct TurretGrid {
    world_from_velo: DPose3,
    table: Arc<Table>,
}

impl TurretGrid {
    /// A turret with these lasers, all firing at `azimuths_rad`: rising, in [0, 2 pi), counter-clockwise from x.
    ///
    /// # Errors
    /// [`Error::NotFinite`]; [`Error::OutOfRange`] for no ring or column, more than 65,535 of them, an elevation beyond
    /// 89 degrees, or azimuths that do not rise within one turn.
    pub fn new(world_from_velo: DPose3, rings: &[TurretRing], azimuths_rad: &[f64]) -> Result<Self> {
        let out_of_range =
            |what, value: String, expected: &str| Err(Error::OutOfRange { what, value, expected: expected.to_owned() });
        for (what, n) in [("number of rings", rings.len()), ("number of columns", azimuths_rad.len())] {
            if n == 0 || n > usize::from(u16::MAX) {
                return out_of_range(what, n.to_string(), "1 to 65535");
            }
        }
        for ring in rings {
            let _ = finite("ring height", ring.height_m)?;
            if finite("ring elevation", ring.elevation_rad)?.abs() > 89_f64.to_radians() {
                return out_of_range("ring elevation", ring.elevation_rad.to_string(), "within 89 degrees (1.553 rad)");
            }
        }
        for (i, azimuth) in azimuths_rad.iter().enumerate() {
            let least = if i == 0 { 0.0 } else { azimuths_rad[i - 1] };
            if !(finite("azimuth", *azimuth)? >= least && *azimuth < TAU) {
                return out_of_range("azimuth", azimuth.to_string(), "rising values in [0, 2 pi)");
            }
        }
        Ok(Self { world_from_velo, table: Arc::new(Table::new(rings, azimuths_rad)) })
    }

    /// The same turret somewhere else; the tables are shared.
    #[must_use]
    pub fn at(&self, world_from_velo: DPose3) -> Self {
        Self { world_from_velo, table: Arc::clone(&self.table) }
    }
}

/// Where a vertex falls on a turret's grid.
#[derive(Debug, Clone, Copy, Default)]
pub struct TurretFootprint {
    /// In [0, 2 pi]; NaN near the axis and at the seam, where the slow path decides.
    azimuth_rad: f32,
    rows: [u16; 2],
}

impl BeamGrid for TurretGrid {
    type Footprint = TurretFootprint;

    fn rows(&self) -> usize {
        self.table.rings.len()
    }

    fn columns(&self) -> usize {
        self.table.azimuths.len()
    }

    fn world_from_grid(&self) -> DPose3 {
        self.world_from_velo
    }

    fn beam(&self, row: usize, column: usize) -> Beam {
        let ring = self.table.rings[row];
        let [cos_azimuth, sin_azimuth] = self.table.cos_sin[column];
        let (cos, sin) = (math::cos(ring.elevation_rad), math::sin(ring.elevation_rad));
        let direction_velo = DVec3::new(cos * cos_azimuth, cos * sin_azimuth, sin);
        Beam {
            origin_world: self.world_from_velo.translation
                + self.world_from_velo.rotation * DVec3::new(0.0, 0.0, ring.height_m),
            direction_world: self.world_from_velo.rotation * direction_velo,
        }
    }

    #[inline]
    fn sphere_windows(&self, c: Vec3, radius_m: f32) -> ([Window; 2], f32) {
        let table = &*self.table;
        let [lowest, highest] = table.height_span;
        // One origin in the middle sees a sphere that is larger by half the span.
        let reach = radius_m + 0.5 * (highest - lowest) + 1e-4;
        let z = c.z - 0.5 * (lowest + highest);
        let rho = (c.x * c.x + c.y * c.y).sqrt();
        let near = (rho * rho + z * z).sqrt() * 0.999_99 - reach;
        let everywhere = Window { rows: 0..table.rows.len(), columns: 0..table.azimuths.len() };
        if near <= 0.0 {
            return ([everywhere, Window::default()], near);
        }
        let rows = match tangents_of_circle(z, rho, reach) {
            Some([lo, hi]) => table.rows_between_tangents(lo, hi),
            None => 0..table.rows.len(),
        };
        let share = reach / rho.max(1e-9);
        if rows.is_empty() {
            return Default::default();
        }
        if share >= 0.999 {
            return ([Window { rows, columns: everywhere.columns }, Window::default()], near);
        }
        // asin x <= x (1 + 0.571 x^2) on 0..1.
        let half = share * (1.0 + 0.571 * share * share) + AZIMUTH_MARGIN;
        let azimuth = azimuth_of(c.x, c.y);
        (
            table.columns_between(azimuth - half, azimuth + half).map(|columns| Window { rows: rows.clone(), columns }),
            near,
        )
    }

    #[inline]
    fn row_start(&self, inner_row: usize) -> usize {
        self.table.ring_of_row[inner_row] as usize * self.table.azimuths.len()
    }

    #[inline]
    fn footprints(&self, [x, y, z]: &Lanes, out: &mut [Self::Footprint; LANES]) {
        let table = &*self.table;
        let (mut rho, mut azimuth, mut bin) = ([0.0_f32; LANES], [0.0_f32; LANES], [0_u32; LANES]);
        let middle = table.middle_height();
        for i in 0..LANES {
            rho[i] = (x[i] * x[i] + y[i] * y[i]).sqrt().max(1e-6);
            azimuth[i] = azimuth_of(x[i], y[i]);
            bin[i] = table.row_of_tangent.bin((middle - z[i]) / rho[i]);
        }
        for i in 0..LANES {
            let awkward = rho[i] <= POLAR * (z[i].abs() + rho[i])
                || rho[i] < 1e-3
                || azimuth[i] < 2.0 * AZIMUTH_MARGIN
                || azimuth[i] > TURN - 2.0 * AZIMUTH_MARGIN;
            let (first, end) = table.rows_from_guess(rho[i], z[i], table.row_of_tangent.guess_in_bin(bin[i]));
            out[i] = TurretFootprint {
                azimuth_rad: if awkward { f32::NAN } else { azimuth[i] },
                rows: [first as u16, end as u16],
            };
        }
    }

    #[inline]
    fn windows(&self, corners_grid: impl Fn() -> [Vec3; 3], [a, b, c]: &[Self::Footprint; 3]) -> [Window; 2] {
        // NaN, the sign of an awkward corner, must not get lost in min and max.
        let [p, q, r] = [a.azimuth_rad, b.azimuth_rad, c.azimuth_rad];
        let narrow = (p - q).abs() < NARROW_RAD && (q - r).abs() < NARROW_RAD && (r - p).abs() < NARROW_RAD;
        if !narrow {
            return self.table.wide_windows(corners_grid());
        }
        let first = a.rows[0].min(b.rows[0]).min(c.rows[0]);
        let end = a.rows[1].max(b.rows[1]).max(c.rows[1]);
        if first >= end {
            return Default::default();
        }
        let rows = usize::from(first)..usize::from(end);
        // Awkward corners apart, both ends lie inside the turn.
        let columns = self.table.columns_below(p.min(q).min(r) - AZIMUTH_MARGIN)
            ..self.table.columns_below(p.max(q).max(r) + AZIMUTH_MARGIN);
        [Window { rows, columns }, Window::default()]
    }

    #[inline]
    fn cover(&self, triangle: &EdgePlanes, window: &Window, mut visit: impl FnMut(usize, f64)) {
        let table = &*self.table;
        for row in window.rows.clone() {
            let SortedRow { tangent, secant, height_m: h } = table.rows[row];
            let signed_volume = triangle.volume - h * triangle.normal.z;
            if signed_volume == 0.0 {
                continue;
            }
            let sign = if signed_volume > 0.0 { 1.0 } else { -1.0 };
            let edge = |i: usize| {
                let (n, d) = (triangle.cross[i], triangle.delta[i]);
                [sign * (n.x + h * d.y), sign * (n.y - h * d.x), sign * n.z * tangent]
            };
            let [e0, e1, e2] = [edge(0), edge(1), edge(2)];
            let n = triangle.normal;
            let n = [sign * n.x, sign * n.y, sign * n.z * tangent];
            let distance = signed_volume.abs() * secant;
            let base = table.ring_of_row[row] as usize * table.azimuths.len();
            let mut try_columns = |columns: Range<usize>| {
                for (column, [cos, sin]) in columns.clone().zip(&table.cos_sin[columns]) {
                    let at = |p: &[f64; 3]| p[0] * cos + p[1] * sin + p[2];
                    if at(&e0) >= 0.0 && at(&e1) >= 0.0 && at(&e2) >= 0.0 {
                        let facing = at(&n);
                        if facing > 0.0 {
                            visit(base + column, distance / facing);
                        }
                    }
                }
            };
            if window.columns.len() < 2 * BLOCK {
                try_columns(window.columns.clone());
                continue;
            }
            // Wide windows are mostly empty: skip blocks of columns that lie outside one edge altogether.
            let last = window.columns.end - 1;
            let mut start = window.columns.start;
            let edges = [e0, e1, e2];
            let [cos, sin] = table.cos_sin[start];
            let mut here = edges.map(|p| p[0] * cos + p[1] * sin + p[2]);
            while start < last {
                let stop = (start + BLOCK).min(last);
                let [cos, sin] = table.cos_sin[stop];
                let there = edges.map(|p| p[0] * cos + p[1] * sin + p[2]);
                let width = f64::from(table.azimuths[stop] - table.azimuths[start]);
                // A sinusoid of amplitude R rises above its chord by at most R width^2 / 8.
                let is_outside = (0..3).any(|i| {
                    let [a, b, c] = edges[i];
                    let reach = a.abs() + b.abs();
                    here[i].max(there[i]) + reach * (0.126 * width * width + 1e-9) + 1e-12 * c.abs() < 0.0
                });
                if !is_outside {
                    try_columns(start..stop + usize::from(stop == last));
                }
                (start, here) = (stop, there);
            }
        }
    }
}
