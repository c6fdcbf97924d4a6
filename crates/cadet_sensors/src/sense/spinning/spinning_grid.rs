//! The beams of a spinning LIDAR: rings of lasers on one vertical axis, firing at the same azimuths but for an offset a
//! ring.

use std::ops::Range;
use std::sync::Arc;

use super::azimuth_ticks::{AZIMUTH_MARGIN_RAD, TURN_RAD, azimuth_rad_of};
use super::laser_ring::LaserRing;
use super::row_planes::{EIGHT, PlaneLanes, RowPlanes};
use super::spinning_table::{POLAR_SHARE, SpinningTable};
use crate::sense::grids::{Beam, BeamGrid, Hits, Window, tangents_of_circle};
use crate::wide_registers::array_of;
use cadet_base::error::{Error, Result, finite};
use cadet_base::geometry::{LANES, Lanes};
use cadet_base::math::{DPose3, DVec3, TAU, Vec3, greater, lesser};

/// Columns that a wide window is searched by.
const SEARCH_COLUMNS: usize = 32;

/// The farthest from the axis that a laser may sit.
const MOST_LEFT_M: f64 = 0.5;

/// The beams of a spinning LIDAR in the world: row = ring (in the order given), column = azimuth. Depth is the range from
/// the laser's own origin ([`LaserRing::origin_velo`]).
#[derive(Debug, Clone)]
pub struct SpinningGrid {
    world_from_velo: DPose3,
    table: Arc<SpinningTable>,
}

impl SpinningGrid {
    /// A LIDAR with these lasers, all firing at `azimuths_rad`: rising, in [0, 2 pi), counter-clockwise from x.
    ///
    /// # Errors
    /// [`Error::NotFinite`]; [`Error::OutOfRange`] for no ring or column, more than 65,535 of them, an elevation beyond
    /// 89 degrees, or azimuths that do not rise within one turn.
    pub fn new(world_from_velo: DPose3, rings: &[LaserRing], azimuths_rad: &[f64]) -> Result<Self> {
        Self::staggered(world_from_velo, rings, azimuths_rad, &vec![0.0; rings.len()])
    }

    /// A LIDAR whose rings each fire a little later in the turn: ring k at `azimuths_rad[j] + offsets_rad[k]`, with
    /// offsets of at least 0 that keep the last column inside the turn.
    ///
    /// # Errors
    /// As [`SpinningGrid::new`]; [`Error::Shape`] for another number of offsets than of rings.
    pub fn staggered(
        world_from_velo: DPose3,
        rings: &[LaserRing],
        azimuths_rad: &[f64],
        offsets_rad: &[f64],
    ) -> Result<Self> {
        let out_of_range =
            |what, value: String, expected: &str| Err(Error::OutOfRange { what, value, expected: expected.to_owned() });
        for (what, n) in [("number of rings", rings.len()), ("number of columns", azimuths_rad.len())] {
            if n == 0 || n > usize::from(u16::MAX) {
                return out_of_range(what, n.to_string(), "1 to 65535");
            }
        }
        for ring in rings {
            let _ = finite("ring height", ring.height_m)?;
            if finite("ring's distance from the axis", ring.left_m)?.abs() > MOST_LEFT_M {
                return out_of_range("ring's distance from the axis", ring.left_m.to_string(), "at most 0.5 m");
            }
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
        if offsets_rad.len() != rings.len() {
            return Err(Error::Shape {
                what: "azimuth offsets",
                got: format!("({},)", offsets_rad.len()),
                expected: format!("({},)", rings.len()),
            });
        }
        let most = TAU - azimuths_rad[azimuths_rad.len() - 1];
        for offset in offsets_rad {
            if !(0.0..most).contains(&finite("azimuth offset", *offset)?) {
                let expected = format!("0 to below {most} rad, the gap behind the last column");
                return out_of_range("azimuth offset", offset.to_string(), &expected);
            }
        }
        Ok(Self { world_from_velo, table: Arc::new(SpinningTable::new(rings, azimuths_rad, offsets_rad)) })
    }

    /// Cosine and sine of the azimuth of every column of a ring.
    #[must_use]
    pub fn headings(&self, ring: usize) -> &[[f64; 2]] {
        self.table.headings(ring)
    }

    /// Returns this LIDAR at another pose; the tables are shared.
    #[must_use]
    pub fn at(&self, world_from_velo: DPose3) -> Self {
        Self { world_from_velo, table: Arc::clone(&self.table) }
    }
}

/// Where a vertex falls on the grid: the first of the rows that may pass through it, the first tick of the
/// azimuth, and the ends of both counted down from `u16::MAX`. The bounds of several are the least of each number.
///
/// A vertex near the axis or at the seam has all ticks: what it belongs to takes the slow path.
pub type SpinningFootprint = [u16; 4];

impl BeamGrid for SpinningGrid {
    type Footprint = SpinningFootprint;

    fn rows(&self) -> usize {
        self.table.rings.len()
    }

    fn columns(&self) -> usize {
        self.table.azimuths_rad.len()
    }

    fn world_from_grid(&self) -> DPose3 {
        self.world_from_velo
    }

    fn beam(&self, row: usize, column: usize) -> Beam {
        let ring = self.table.rings[row];
        let heading = self.table.headings(row)[column];
        Beam {
            origin_world: self.world_from_velo.transform_point(ring.origin_velo(heading)),
            direction_world: self.world_from_velo.rotation * ring.directions_velo()(heading),
        }
    }

    #[inline]
    fn sphere_windows(&self, c: Vec3, radius_m: f32) -> ([Window; 2], f32) {
        let table = &*self.table;
        let [lowest, highest] = table.height_span_m;
        // One origin in the middle sees a sphere that is larger by half the span, and by the way from the axis.
        let reach = radius_m + 0.5 * (highest - lowest) + table.most_left_m + 1e-4;
        let z = c.z - 0.5 * (lowest + highest);
        let rho = (c.x * c.x + c.y * c.y).sqrt();
        let near = (rho * rho + z * z).sqrt() * 0.999_99 - reach;
        let everywhere = Window { rows: 0..table.rows.len(), columns: 0..table.azimuths_rad.len() };
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
        let half = share * (1.0 + 0.571 * share * share) + AZIMUTH_MARGIN_RAD;
        let azimuth = azimuth_rad_of(c.x, c.y);
        (
            table.columns_between(azimuth - half, azimuth + half).map(|columns| Window { rows: rows.clone(), columns }),
            near,
        )
    }

    #[inline]
    fn row_start(&self, inner_row: usize) -> usize {
        self.table.ring_of_row[inner_row] as usize * self.table.azimuths_rad.len()
    }

    #[inline(always)]
    fn footprints(&self, [x, y, z]: &Lanes, out: &mut [Self::Footprint; LANES]) {
        let table = &*self.table;
        let (mut rho, mut per_rho, mut azimuth) = ([0.0_f32; LANES], [0.0_f32; LANES], [0.0_f32; LANES]);
        let (mut bin, mut first_tick, mut end_tick) = ([0_u32; LANES], [0_u16; LANES], [0_u16; LANES]);
        let middle = table.middle_height_m();
        for i in 0..LANES {
            rho[i] = greater((x[i] * x[i] + y[i] * y[i]).sqrt(), 1e-6);
            per_rho[i] = 1.0 / rho[i];
            azimuth[i] = azimuth_rad_of(x[i], y[i]);
            bin[i] = table.row_of_tangent.bin((middle - z[i]) * per_rho[i]);
        }
        for i in 0..LANES {
            // Lasers beside the axis look past it: asin x <= 1.001 x up to x = 1 / OFF_AXIS.
            let aside = 1.001 * table.most_left_m * per_rho[i];
            let awkward = (rho[i] <= POLAR_SHARE * (z[i].abs() + rho[i]))
                | (rho[i] < table.least_rho_m)
                | (azimuth[i] < 2.0 * AZIMUTH_MARGIN_RAD + table.max_offset_rad + aside)
                | (azimuth[i] > TURN_RAD - 2.0 * AZIMUTH_MARGIN_RAD - aside);
            let (first, end) = table.ticks.between(azimuth[i] - table.max_offset_rad - aside, azimuth[i] + aside);
            first_tick[i] = if awkward { 0 } else { first };
            end_tick[i] = if awkward { 0 } else { u16::MAX - end };
        }
        let mut rows = [[0_u16; 2]; LANES];
        if let Some(rows_of_bin) = &table.rows_of_bin {
            for i in 0..LANES {
                rows[i] = rows_of_bin[bin[i] as usize];
            }
        } else {
            let mut place = [0_u32; LANES];
            for i in 0..LANES {
                place[i] = SpinningTable::place(per_rho[i], bin[i]);
            }
            for i in 0..LANES {
                rows[i] = table.rows_of_place[place[i] as usize];
            }
        }
        for i in 0..LANES {
            out[i] = [rows[i][0], u16::MAX - rows[i][1], first_tick[i], end_tick[i]];
        }
    }

    #[inline(always)]
    fn may_meet(&self, footprints: &[Self::Footprint; 4]) -> bool {
        let [first, end, first_tick, end_tick] = bounds_of(footprints);
        (end_tick - first_tick > i32::from(self.table.ticks.narrow)) | ((first < end) & (first_tick < end_tick))
    }

    #[inline(always)]
    fn windows(&self, corners_grid: &[DVec3; 4], footprints: &[Self::Footprint; 4]) -> [Window; 2] {
        let table = &*self.table;
        let [first, end, first_tick, end_tick] = bounds_of(footprints);
        if end_tick - first_tick > i32::from(table.ticks.narrow) {
            return table.wide_windows(corners_grid.map(|p| p.as_vec3()));
        }
        let columns = table.ticks.columns(first_tick as u16, end_tick as u16);
        [Window { rows: first as usize..end as usize, columns }, Window::default()]
    }

    #[inline(always)]
    fn near_m(&self, corners_grid: &[DVec3; 4]) -> f32 {
        let [lowest, highest] = self.table.height_span_m;
        let middle = 0.5 * (lowest + highest);
        let (x, y) = (corners_grid.map(|p| p.x as f32), corners_grid.map(|p| p.y as f32));
        let z = corners_grid.map(|p| p.z as f32 - middle);
        let (mut corners, mut sides) = ([0.0; 4], [0.0; 4]);
        let square = |x: f32, y: f32, z: f32| x * x + y * y + z * z;
        for i in 0..4 {
            let k = (i + 1) % 4;
            corners[i] = square(x[i], y[i], z[i]);
            sides[i] = square(x[k] - x[i], y[k] - y[i], z[k] - z[i]);
        }
        let corner = lesser(lesser(corners[0], corners[1]), lesser(corners[2], corners[3]));
        let side = greater(greater(sides[0], sides[1]), greater(sides[2], sides[3]));
        let edge = greater(side, square(x[2] - x[0], y[2] - y[0], z[2] - z[0]));
        // Of both triangles: no point is farther from all corners than the longest edge / sqrt 3, the nearest point to the
        // origin included; and seen from there the corners lie beyond it or at a right angle. Ten times what rounding takes.
        let nearest = (corner * 0.999_995 - edge * 0.333_34).max(0.0).sqrt();
        nearest * 0.999_99 - 0.5 * (highest - lowest) - self.table.most_left_m - 1e-4
    }

    #[inline(always)]
    fn most_offset_m(&self) -> f64 {
        let [lowest, highest] = self.table.height_span_m.map(|z| f64::from(z.abs()));
        lowest.max(highest) + f64::from(self.table.most_left_m)
    }

    #[inline(always)]
    fn is_turned_away(&self, [a, b, c]: &[DVec3; 3]) -> bool {
        let [lowest, highest] = self.table.height_span_m.map(f64::from);
        let normal = (*b - *a).cross(*c - *a);
        let aside = f64::from(self.table.most_left_m) * (normal.x.abs() + normal.y.abs());
        // Of the origins, the one that lies farthest along the normal.
        a.dot(normal) > (normal.z * lowest).max(normal.z * highest) + aside
    }

    #[inline]
    fn cover(&self, triangle: &[DVec3; 3], window: &Window, mut visit: impl FnMut(usize, f64)) {
        self.meet(triangle, window, |at, [depth, _]| visit(at, depth));
    }

    #[inline(always)]
    fn cast(&self, triangle: &[DVec3; 3], window: &Window, hits: &mut Hits, ids: [u32; 2]) {
        let table = &*self.table;
        if table.azimuths_rad.len() < EIGHT {
            return self.meet(triangle, window, |at, met| hits.keep_nearer(at, met.map(|v| v as f32), ids));
        }
        let triangle = PlaneLanes::new(triangle);
        for row in window.rows.clone() {
            let ring = table.ring_of_row[row] as usize;
            let base = [ring * table.azimuths_rad.len(), table.headings_of_ring[ring] as usize];
            let row = &table.rows[row];
            let (volume, sides) = RowPlanes::sides(&triangle, row);
            for side in sides.into_iter().flatten() {
                let planes = RowPlanes::seen_from(side, &triangle, row, volume);
                self.cast_row(&planes, base, &window.columns, hits, ids);
            }
        }
    }
}

impl SpinningGrid {
    /// As [`BeamGrid::cover`], with the cosine of the incidence angle beside the depth. `cast` walks over rows and sides by itself:
    /// a closure there would run without wide registers.
    #[inline]
    fn meet(&self, triangle: &[DVec3; 3], window: &Window, mut visit: impl FnMut(usize, [f64; 2])) {
        let triangle = PlaneLanes::new(triangle);
        for row in window.rows.clone() {
            let base = self.row_start(row);
            let headings = self.table.headings(self.table.ring_of_row[row] as usize);
            let row = &self.table.rows[row];
            let (volume, sides) = RowPlanes::sides(&triangle, row);
            for side in sides.into_iter().flatten() {
                let planes = RowPlanes::seen_from(side, &triangle, row, volume);
                for column in window.columns.clone() {
                    if let Some(met) = planes.meet(headings[column]) {
                        visit(base + column, met);
                    }
                }
            }
        }
    }

    /// `base` is where the row begins among the beams, and among the headings.
    #[inline(always)]
    fn cast_row(&self, planes: &RowPlanes, base: [usize; 2], columns: &Range<usize>, hits: &mut Hits, ids: [u32; 2]) {
        if columns.len() < 2 * SEARCH_COLUMNS {
            return self.cast_columns(planes, base, columns.clone(), hits, ids);
        }
        // Wide windows are mostly empty: skip blocks of columns that lie outside one edge altogether.
        let table = &*self.table;
        let edges_at = |column: usize| planes.at([table.cos[base[1] + column], table.sin[base[1] + column]]);
        let last = columns.end - 1;
        let mut start = columns.start;
        let mut here = edges_at(start);
        while start < last {
            let stop = (start + SEARCH_COLUMNS).min(last);
            let there = edges_at(stop);
            let width = f64::from(table.azimuths_rad[stop] - table.azimuths_rad[start]);
            // A sinusoid of amplitude R rises above its chord by at most R width^2 / 8.
            let is_outside = (0..3).any(|i| {
                let [a, b, c] = planes.edge(i);
                let reach = a.abs() + b.abs();
                here[i].max(there[i]) + reach * (0.126 * width * width + 1e-9) + 1e-12 * c.abs() < 0.0
            });
            if !is_outside {
                self.cast_columns(planes, base, start..stop + usize::from(stop == last), hits, ids);
            }
            (start, here) = (stop, there);
        }
    }

    /// The columns of a row, eight at a time.
    #[inline(always)]
    fn cast_columns(
        &self,
        planes: &RowPlanes,
        [base, headings]: [usize; 2],
        columns: Range<usize>,
        hits: &mut Hits,
        ids: [u32; 2],
    ) {
        let last_eight = self.table.azimuths_rad.len() - EIGHT;
        let mut column = columns.start;
        while column < columns.end {
            // The last eight of a row may take in some columns before the window: they are tested too.
            let first = column.min(last_eight);
            planes.cast_eight(self.table.eight_headings(headings + first), hits, base + first, ids);
            column = first + EIGHT;
        }
    }
}

/// The bounds of a piece's corners: first row, end of rows, first tick, end of ticks.
#[inline(always)]
fn bounds_of([a, b, c, d]: &[SpinningFootprint; 4]) -> [i32; 4] {
    let least: SpinningFootprint = array_of(|i| a[i].min(b[i]).min(c[i].min(d[i])));
    let [first, end, first_tick, end_tick] = least.map(i32::from);
    let most = i32::from(u16::MAX);
    [first, most - end, first_tick, most - end_tick]
}
