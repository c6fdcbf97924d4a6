//! The beams of a pinhole camera, at any spacing on the image plane.

use std::ops::Range;

use super::edges::EdgePlanes;
use super::grid::{Beam, BeamGrid, Window, tangents_of_circle};
use cadet_base::error::{Error, Result, finite};
use cadet_base::geometry::{LANES, Lanes};
use cadet_base::math::{DPose3, DVec3, Vec3, greater, lesser};

/// Samples of an image: row r, column c lies at `u = u0 + c * du`, `v = v0 + r * dv`, where the beam's direction is
/// `((u - cx) / fx, (v - cy) / fy, 1)` in the camera's frame. Depth is z along the optical axis.
///
/// In a quincunx ([`PinholeGrid::quincunx`]) the samples of odd rows lie half a column further to the right.
#[derive(Debug, Clone)]
pub struct PinholeGrid {
    world_from_cam: DPose3,
    /// (u - cx) / fx of every column of even and of odd rows, rising.
    columns_x: [Vec<f64>; 2],
    /// (v - cy) / fy of every row, rising.
    rows_y: Vec<f64>,
    /// Column = x / z * scale + offset, and the same for rows.
    pub(crate) column_scale: f64,
    pub(crate) offset_columns: f64,
    pub(crate) row_scale: f64,
    pub(super) offset_rows: f64,
    /// Columns by which the samples of odd rows lie further to the right: 0 or 1/2.
    pub(crate) odd_shift_columns: f64,
}

/// How far the single-precision projection may err, in samples.
const MARGIN: f32 = 0.02;
/// Windows wider than this are narrowed row by row.
const NARROW_ABOVE: usize = 6;

impl PinholeGrid {
    /// A grid in the image of a camera with focal lengths `fx`, `fy` and principal point `cx`, `cy` (pixels).
    ///
    /// `world_from_cam`: x right, y down, z forward, origin in the optical center.
    ///
    /// # Errors
    /// [`Error::NotFinite`], and [`Error::OutOfRange`] for focal lengths or spacings that are not positive or an empty
    /// grid.
    pub fn new(
        world_from_cam: DPose3,
        [fx, fy, cx, cy]: [f64; 4],
        [u0, v0, du, dv]: [f64; 4],
        rows: usize,
        columns: usize,
    ) -> Result<Self> {
        for (what, value) in [("fx", fx), ("fy", fy), ("du", du), ("dv", dv)] {
            if finite(what, value)? <= 0.0 {
                return Err(Error::OutOfRange { what, value: value.to_string(), expected: "above 0".to_owned() });
            }
        }
        for (what, value) in [("cx", cx), ("cy", cy), ("u0", u0), ("v0", v0)] {
            let _ = finite(what, value)?;
        }
        if rows == 0 || columns == 0 {
            return Err(Error::OutOfRange {
                what: "rows x columns",
                value: format!("{rows} x {columns}"),
                expected: "at least 1 x 1".to_owned(),
            });
        }
        let columns_x: Vec<f64> = (0..columns).map(|c| (u0 + c as f64 * du - cx) / fx).collect();
        Ok(Self {
            world_from_cam,
            columns_x: [columns_x.clone(), columns_x],
            rows_y: (0..rows).map(|r| (v0 + r as f64 * dv - cy) / fy).collect(),
            column_scale: fx / du,
            offset_columns: (cx - u0) / du,
            row_scale: fy / dv,
            offset_rows: (cy - v0) / dv,
            odd_shift_columns: 0.0,
        })
    }

    /// Two samples a pixel: on its center, and half a pixel to the right and below. Rows lie half a pixel apart, the
    /// first at `v0`; each has one sample a pixel, the first at `u0` or, in odd rows, half a pixel right of it.
    ///
    /// # Errors
    /// Those of [`PinholeGrid::new`].
    pub fn quincunx(
        world_from_cam: DPose3,
        [fx, fy, cx, cy]: [f64; 4],
        [u0, v0]: [f64; 2],
        rows: usize,
        columns: usize,
    ) -> Result<Self> {
        let mut grid = Self::new(world_from_cam, [fx, fy, cx, cy], [u0, v0, 1.0, 0.5], rows, columns)?;
        grid.odd_shift_columns = 0.5;
        for (c, x) in grid.columns_x[1].iter_mut().enumerate() {
            *x = (u0 + (c as f64 + 0.5) - cx) / fx;
        }
        Ok(grid)
    }

    /// True if a circle about (across, along) in a plane through the optical axis lies on one side of all beams.
    fn is_beside(&self, across: f32, along: f32, radius_m: f32, scale: f64, offset: f64, n: usize) -> bool {
        // A sample beyond the first and the last.
        let [low, high] = [-1.0 - offset, n as f64 + 1.0 - offset].map(|at| (at / scale) as f32);
        let beyond = |slope: f32| (across - slope * along) / (1.0 + slope * slope).sqrt();
        beyond(low) < -radius_m || beyond(high) > radius_m
    }

    fn edges(&self) -> [f64; 4] {
        let (w, h) = (self.columns() - 1, self.rows_y.len() - 1);
        [self.columns_x[0][0], self.columns_x[1][w], self.rows_y[0], self.rows_y[h]]
    }

    /// A face that reaches behind the camera or nearly so: everything, unless one side of the view excludes it.
    #[cold]
    fn window_of_crossing(&self, corners: &[DVec3]) -> Window {
        let [left, right, top, bottom] = self.edges();
        let slack = |p: &DVec3| 1e-6 * (p.x.abs() + p.y.abs() + p.z.abs());
        let outside = corners.iter().all(|p| p.z < -slack(p))
            || corners.iter().all(|p| p.x - left * p.z < -slack(p) * (1.0 + left.abs()))
            || corners.iter().all(|p| p.x - right * p.z > slack(p) * (1.0 + right.abs()))
            || corners.iter().all(|p| p.y - top * p.z < -slack(p) * (1.0 + top.abs()))
            || corners.iter().all(|p| p.y - bottom * p.z > slack(p) * (1.0 + bottom.abs()));
        if outside { Window::default() } else { Window { rows: 0..self.rows(), columns: 0..self.columns() } }
    }
}

impl BeamGrid for PinholeGrid {
    /// Column and row, clamped to just outside the grid; NaN where the point is not clearly in front.
    type Footprint = [f32; 2];

    fn rows(&self) -> usize {
        self.rows_y.len()
    }

    fn columns(&self) -> usize {
        self.columns_x[0].len()
    }

    fn world_from_grid(&self) -> DPose3 {
        self.world_from_cam
    }

    fn beam(&self, row: usize, column: usize) -> Beam {
        Beam {
            origin_world: self.world_from_cam.translation,
            direction_world: self.world_from_cam.rotation
                * DVec3::new(self.columns_x(row)[column], self.rows_y[row], 1.0),
        }
    }

    #[inline]
    fn sphere_windows(&self, c: Vec3, radius_m: f32) -> ([Window; 2], f32) {
        let range = |across: f32, scale: f64, offset: f64, n: usize| {
            let Some([lo, hi]) = tangents_of_circle(across, c.z, radius_m) else { return 0..0 };
            if hi == f32::INFINITY && self.is_beside(across, c.z, radius_m, scale, offset, n) {
                return 0..0;
            }
            let (lo, hi) = (lo * scale as f32 + offset as f32, hi * scale as f32 + offset as f32);
            (lo - 1.0).max(0.0) as usize..((hi + 2.0).max(0.0) as usize).min(n)
        };
        let columns = range(c.x, self.column_scale, self.offset_columns, self.columns());
        let rows = range(c.y, self.row_scale, self.offset_rows, self.rows());
        ([Window { rows, columns }, Window::default()], c.z - radius_m)
    }

    fn row_start(&self, inner_row: usize) -> usize {
        inner_row * self.columns()
    }

    #[inline]
    fn footprints(&self, points_grid: &Lanes, out: &mut [Self::Footprint; LANES]) {
        let (mut columns, mut rows) = ([0.0; LANES], [0.0; LANES]);
        self.footprint_lanes(points_grid, &mut columns, &mut rows);
        *out = std::array::from_fn(|i| [columns[i], rows[i]]);
    }

    #[inline]
    fn windows(&self, corners_grid: &[DVec3; 4], footprints: &[Self::Footprint; 4]) -> [Window; 2] {
        let [columns, rows] = [0, 1].map(|k| footprints.map(|f| [f[k]; LANES]));
        [self.window_lanes(columns.each_ref(), rows.each_ref()).of_lane(0, self, corners_grid), Window::default()]
    }

    #[inline]
    fn cover(&self, triangle: &[DVec3; 3], window: &Window, mut visit: impl FnMut(usize, f64)) {
        let triangle = EdgePlanes::new(*triangle);
        let volume = triangle.volume6_m3.abs();
        if volume == 0.0 {
            return;
        }
        let sign = if triangle.volume6_m3 > 0.0 { 1.0 } else { -1.0 };
        let [e0, e1, e2] = triangle.cross.map(|n| n * sign);
        let n = triangle.normal * sign;
        for row in window.rows.clone() {
            let y = self.rows_y[row];
            let rests = [e0.y * y + e0.z, e1.y * y + e1.z, e2.y * y + e2.z];
            let rest = n.y * y + n.z;
            let columns_x = self.columns_x(row);
            let base = row * columns_x.len();
            let mut columns = window.columns.clone();
            if columns.len() <= NARROW_ABOVE {
                for column in columns {
                    let x = columns_x[column];
                    let inside = e0.x * x + rests[0] >= 0.0 && e1.x * x + rests[1] >= 0.0 && e2.x * x + rests[2] >= 0.0;
                    let facing = n.x * x + rest;
                    if inside && facing > 0.0 {
                        visit(base + column, volume / facing);
                    }
                }
                continue;
            }
            for (slope, rest) in [(e0.x, rests[0]), (e1.x, rests[1]), (e2.x, rests[2])] {
                self.narrow(row, &mut columns, slope, rest);
            }
            if columns.is_empty() {
                continue;
            }
            for (column, x) in columns.clone().zip(&columns_x[columns]) {
                let facing = n.x * x + rest;
                if facing > 0.0 {
                    visit(base + column, volume / facing);
                }
            }
        }
    }
}

/// The windows of [`LANES`] faces.
pub(crate) struct WindowLanes {
    /// False where a window is empty.
    pub may_meet: [bool; LANES],
    rows: [[u32; LANES]; 2],
    columns: [[u32; LANES]; 2],
    /// A corner is not clearly in front.
    crosses: [bool; LANES],
}

impl WindowLanes {
    /// The window of one of them, whose corners are given.
    #[inline(always)]
    pub(crate) fn of_lane(&self, i: usize, grid: &PinholeGrid, corners_cam: &[DVec3]) -> Window {
        if self.crosses[i] {
            return grid.window_of_crossing(corners_cam);
        }
        let range = |[start, end]: &[[u32; LANES]; 2]| start[i] as usize..end[i] as usize;
        Window { rows: range(&self.rows), columns: range(&self.columns) }
    }
}

/// Adding it to a number from 0 to 2^22 leaves the nearest integer in the low bits.
const ROUNDER: f32 = 8_388_608.0;

/// The integer at or above, and at or below; for 0 to 2^22.
#[inline(always)]
fn ceil_and_floor(v: f32) -> [u32; 2] {
    let sum = v + ROUNDER;
    let (nearest, bits) = (sum - ROUNDER, sum.to_bits() & 0x007F_FFFF);
    [bits + u32::from(nearest < v), bits - u32::from(nearest > v)]
}

impl PinholeGrid {
    /// As [`BeamGrid::footprints`], columns and rows apart.
    #[inline(always)]
    pub(crate) fn footprint_lanes(&self, [x, y, z]: &Lanes, columns: &mut [f32; LANES], rows: &mut [f32; LANES]) {
        let (cs, co) = (self.column_scale as f32, self.offset_columns as f32);
        let (rs, ro) = (self.row_scale as f32, self.offset_rows as f32);
        let (last_column, last_row) = (self.columns() as f32, self.rows() as f32);
        for i in 0..LANES {
            let in_front = (z[i] > 0.01 * (x[i].abs() + y[i].abs())) & (z[i] > 1e-4);
            let inverse = if in_front { 1.0 / z[i] } else { f32::NAN };
            let column = x[i] * inverse * cs + co;
            let row = y[i] * inverse * rs + ro;
            // Comparisons that keep NaN.
            let column = if column < -2.0 { -2.0 } else { column };
            let row = if row < -2.0 { -2.0 } else { row };
            columns[i] = if column > last_column + 1.0 { last_column + 1.0 } else { column };
            rows[i] = if row > last_row + 1.0 { last_row + 1.0 } else { row };
        }
    }

    /// As [`BeamGrid::windows`], of faces whose corners fall on `columns` and `rows`.
    #[inline(always)]
    pub(crate) fn window_lanes<const N: usize>(
        &self,
        columns: [&[f32; LANES]; N],
        rows: [&[f32; LANES]; N],
    ) -> WindowLanes {
        let none = [[0; LANES]; 2];
        let mut out = WindowLanes { may_meet: [false; LANES], rows: none, columns: none, crosses: [false; LANES] };
        let (row_count, column_count) = (self.rows() as u32, self.columns() as u32);
        let odd_shift = self.odd_shift_columns as f32;
        let bounds = |corners: [&[f32; LANES]; N], i: usize| {
            let (mut low, mut high) = (corners[0][i], corners[0][i]);
            for corner in &corners[1..] {
                low = lesser(corner[i], low);
                high = greater(corner[i], high);
            }
            [low, high]
        };
        // Not where a bound is NaN, which is told below.
        let window = |[low, high]: [f32; 2], count: u32| {
            let low = greater(low, 0.0);
            let high = greater(high + 1.0, 0.0);
            let (start, end) = (ceil_and_floor(low)[0], ceil_and_floor(high)[1]);
            [start, lesser(end, count)]
        };
        for i in 0..LANES {
            let [low, high] = bounds(rows, i);
            let [start, end] = window([low - MARGIN, high + MARGIN], row_count);
            let is_one = start + 1 == end;
            let shift_low = if is_one & (start & 1 == 0) { 0.0 } else { odd_shift };
            let shift_high = if is_one & (start & 1 == 1) { odd_shift } else { 0.0 };
            let [low, high] = bounds(columns, i);
            let [left, right] = window([low - (MARGIN + shift_low), high + (MARGIN - shift_high)], column_count);
            (out.rows[0][i], out.rows[1][i]) = (start, end);
            (out.columns[0][i], out.columns[1][i]) = (left, right);
            let sum = rows[1..].iter().fold(rows[0][i], |sum, row| sum + row[i]);
            out.crosses[i] = sum.is_nan();
            out.may_meet[i] = sum.is_nan() | ((start < end) & (left < right));
        }
        out
    }

    /// x / z of every column of a row.
    #[inline]
    #[must_use]
    pub fn columns_x(&self, row: usize) -> &[f64] {
        &self.columns_x[row % 2]
    }

    /// y / z of every row.
    #[must_use]
    pub fn rows_y(&self) -> &[f64] {
        &self.rows_y
    }

    /// x / z of every column of even and of odd rows, and of those that would follow up to a multiple of `block`.
    pub(crate) fn padded_columns_x(&self, block: usize) -> [Vec<f64>; 2] {
        [(&self.columns_x[0], 0.0), (&self.columns_x[1], self.odd_shift_columns)].map(|(columns_x, shift)| {
            let n = columns_x.len();
            let at = |i: usize| (i as f64 + shift - self.offset_columns) / self.column_scale;
            columns_x.iter().copied().chain((n..n.next_multiple_of(block)).map(at)).collect()
        })
    }

    /// y / z of every row, and of those that would follow up to a multiple of `block`.
    pub(crate) fn padded_rows_y(&self, block: usize) -> Vec<f64> {
        let n = self.rows_y.len();
        let beyond = (n..n.next_multiple_of(block)).map(|i| (i as f64 - self.offset_rows) / self.row_scale);
        self.rows_y.iter().copied().chain(beyond).collect()
    }

    /// Drops the columns where `slope * x + rest` is negative, and no other: rounding keeps the order of what it
    /// rounds, so that the sum changes its sign once in a row and it is enough to look there.
    #[inline]
    fn narrow(&self, row: usize, columns: &mut Range<usize>, slope: f64, rest: f64) {
        // Wide enough for odd rows.
        let root = (-rest / slope) * self.column_scale + self.offset_columns;
        let columns_x = self.columns_x(row);
        let is_in = |column: usize| slope * columns_x[column] + rest >= 0.0;
        if slope > 0.0 {
            columns.start = columns.start.max((root - 1.0).max(0.0) as usize);
            while columns.start < columns.end && !is_in(columns.start) {
                columns.start += 1;
            }
        } else if slope < 0.0 {
            columns.end = columns.end.min((root + 2.0).max(0.0) as usize);
            while columns.start < columns.end && !is_in(columns.end - 1) {
                columns.end -= 1;
            }
        } else if rest < 0.0 {
            columns.end = columns.start;
        }
    }
}
