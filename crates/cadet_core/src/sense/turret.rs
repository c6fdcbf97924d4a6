//! The beams of a spinning LIDAR: rings of lasers on one vertical axis, each firing at the same azimuths.

use std::sync::Arc;

use super::edges::EdgePlanes;
use super::grid::{Beam, BeamGrid, LANES, Lanes, Window, tangents_of_circle};
use crate::error::{Error, Result, finite};
use crate::math::{self, DPose3, DVec3, TAU, Vec3};

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

/// What does not depend on the pose. "Sorted" rows run from the highest elevation to the lowest.
#[derive(Debug)]
struct Table {
    rings: Vec<TurretRing>,
    /// Ring number of each sorted row.
    ring_of_row: Vec<u32>,
    /// Tangent of the elevation, 1 / cosine of it, height: of each sorted row.
    rows: Vec<SortedRow>,
    /// The lowest origin of any row above (and this one), and the highest of any row below: both fall with the row, so
    /// that the rows which pass above a point are a prefix even where heights and elevations are not in one order.
    envelope: Vec<[f32; 3]>,
    height_span: [f32; 2],
    row_of_tangent: Lookup,
    azimuths: Vec<f32>,
    cos_sin: Vec<[f64; 2]>,
    column_of_azimuth: Lookup,
}

#[derive(Debug, Clone, Copy)]
struct SortedRow {
    tangent: f64,
    secant: f64,
    height_m: f64,
}

/// Counts of table entries below a value, to start an exact search from.
#[derive(Debug)]
struct Lookup {
    scale: f32,
    offset: f32,
    counts: Vec<u16>,
}

impl Lookup {
    /// `count(x)` entries lie below x, for x in lo..hi.
    fn new(lo: f32, hi: f32, bins: usize, count: impl Fn(f32) -> usize) -> Self {
        let scale = bins as f32 / (hi - lo);
        let counts = (0..=bins).map(|b| count(lo + (b as f32 - 0.5) / scale) as u16).collect();
        Self { scale, offset: -lo * scale, counts }
    }

    /// About the number of entries below `x`, which is clamped to the table.
    #[inline]
    fn guess(&self, x: f32) -> usize {
        self.guess_in_bin(self.bin(x))
    }

    #[inline]
    fn bin(&self, x: f32) -> u32 {
        let bin = (x * self.scale + self.offset).max(0.0).min((self.counts.len() - 1) as f32);
        // Adding 2^23 rounds to a whole number that stands in the low bits; a plain cast is slower as it saturates.
        (bin + 8_388_608.0).to_bits() & 0xf_ffff
    }

    #[inline]
    fn guess_in_bin(&self, bin: u32) -> usize {
        usize::from(self.counts[bin as usize])
    }
}

/// Error of the single-precision azimuth, in radians: its polynomial and the rounding of coordinates.
const AZIMUTH_MARGIN: f32 = 4e-5;
/// Triangles narrower than this are bounded by their corners, whose margins allow for the bulge of the edges.
const NARROW_RAD: f32 = 0.02;
/// Points nearer to the axis than this fraction of their distance have no azimuth worth the name.
const POLAR: f32 = 0.01;
const TURN: f32 = std::f32::consts::TAU;
const HALF_TURN: f32 = std::f32::consts::PI;

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

impl Table {
    fn new(rings: &[TurretRing], azimuths_rad: &[f64]) -> Self {
        let mut ring_of_row: Vec<u32> = (0..rings.len() as u32).collect();
        ring_of_row.sort_by(|a, b| rings[*b as usize].elevation_rad.total_cmp(&rings[*a as usize].elevation_rad));
        let rows: Vec<SortedRow> = ring_of_row
            .iter()
            .map(|r| rings[*r as usize])
            .map(|r| SortedRow {
                tangent: math::tan(r.elevation_rad),
                secant: 1.0 / math::cos(r.elevation_rad),
                height_m: r.height_m,
            })
            .collect();
        let mut envelope: Vec<[f32; 3]> =
            rows.iter().map(|r| [r.tangent as f32, r.height_m as f32, r.height_m as f32]).collect();
        for i in 1..rows.len() {
            envelope[i][1] = envelope[i][1].min(envelope[i - 1][1]);
            let j = rows.len() - 1 - i;
            envelope[j][2] = envelope[j][2].max(envelope[j + 1][2]);
        }
        let heights = rows.iter().map(|r| r.height_m as f32);
        let height_span = [heights.clone().fold(f32::INFINITY, f32::min), heights.fold(f32::NEG_INFINITY, f32::max)];
        let (top, bottom) = (rows[0].tangent as f32, rows[rows.len() - 1].tangent as f32);
        let row_of_tangent = Lookup::new(-top - 1e-3, -bottom + 1e-3, 4095, |x| {
            rows.iter().filter(|r| r.tangent > f64::from(-x)).count()
        });
        let azimuths: Vec<f32> = azimuths_rad.iter().map(|a| *a as f32).collect();
        let column_of_azimuth = Lookup::new(0.0, TURN, 8191, |x| azimuths.partition_point(|a| *a < x));
        Self {
            rings: rings.to_vec(),
            ring_of_row,
            rows,
            envelope,
            height_span,
            row_of_tangent,
            cos_sin: azimuths_rad.iter().map(|a| [math::cos(*a), math::sin(*a)]).collect(),
            azimuths,
            column_of_azimuth,
        }
    }

    /// Number of columns below an azimuth.
    #[inline]
    fn columns_below(&self, azimuth_rad: f32) -> usize {
        let mut n = self.column_of_azimuth.guess(azimuth_rad);
        while n < self.azimuths.len() && self.azimuths[n] < azimuth_rad {
            n += 1;
        }
        while n > 0 && self.azimuths[n - 1] >= azimuth_rad {
            n -= 1;
        }
        n
    }

    /// The rows that may pass through a point at distance `rho` from the axis and height `z`: those before the range
    /// pass above it, those after it below.
    #[inline]
    fn rows_at(&self, rho: f32, z: f32) -> (usize, usize) {
        let middle = self.middle_height();
        self.rows_from_guess(rho, z, self.row_of_tangent.guess((middle - z) / rho))
    }

    #[inline]
    fn middle_height(&self) -> f32 {
        0.5 * (self.height_span[0] + self.height_span[1])
    }

    /// [`Table::rows_at`], from a first guess of the row.
    #[inline]
    fn rows_from_guess(&self, rho: f32, z: f32, guess: usize) -> (usize, usize) {
        let slack = 1e-4 * (z - self.middle_height()).abs() + 2e-6 * rho + 1e-6;
        let (above, below) = (z + slack, z - slack);
        let mut first = guess;
        let height = |e: &[f32; 3], k: usize| e[k] + rho * e[0];
        while first < self.envelope.len() && height(&self.envelope[first], 1) > above {
            first += 1;
        }
        while first > 0 && height(&self.envelope[first - 1], 1) <= above {
            first -= 1;
        }
        let mut end = first;
        while end < self.envelope.len() && height(&self.envelope[end], 2) >= below {
            end += 1;
        }
        (first, end)
    }

    /// The rows whose tangents lie between two, about.
    #[inline]
    fn rows_between_tangents(&self, lo: f32, hi: f32) -> std::ops::Range<usize> {
        let slack = |t: f32| 1e-5 * (1.0 + t.abs().min(1e3));
        let (lo, hi) = (lo.max(-1e4) - slack(lo), hi.min(1e4) + slack(hi));
        let mut first = self.row_of_tangent.guess(-hi);
        while first < self.envelope.len() && self.envelope[first][0] > hi {
            first += 1;
        }
        while first > 0 && self.envelope[first - 1][0] <= hi {
            first -= 1;
        }
        let mut end = first;
        while end < self.envelope.len() && self.envelope[end][0] >= lo {
            end += 1;
        }
        first..end
    }

    /// The columns from one azimuth to another, which may lie up to a turn outside [0, 2 pi).
    fn columns_between(&self, lo: f32, hi: f32) -> [std::ops::Range<usize>; 2] {
        let n = self.azimuths.len();
        let (lo, hi) = (lo - AZIMUTH_MARGIN, hi + AZIMUTH_MARGIN);
        if lo < 0.0 {
            [self.columns_below(lo + TURN)..n, 0..self.columns_below(hi)]
        } else if hi >= TURN {
            [self.columns_below(lo)..n, 0..self.columns_below(hi - TURN)]
        } else {
            [self.columns_below(lo)..self.columns_below(hi), 0..0]
        }
    }

    /// Bounds of a triangle that is wide, near the axis or across the seam.
    fn wide_windows(&self, corners: [Vec3; 3]) -> [Window; 2] {
        let n_columns = self.azimuths.len();
        let rho = corners.map(|p| (p.x * p.x + p.y * p.y).sqrt());
        let polar = (0..3).any(|i| rho[i] <= POLAR * (corners[i].z.abs() + rho[i]) || rho[i] < 1e-3);
        let mut azimuth = corners.map(|p| azimuth_of(p.x, p.y));
        let span = |a: &[f32; 3]| (a[0].min(a[1]).min(a[2]), a[0].max(a[1]).max(a[2]));
        let (mut lo, mut hi) = span(&azimuth);
        if hi - lo > HALF_TURN - 1e-3 {
            azimuth = azimuth.map(|a| if a < HALF_TURN { a + TURN } else { a });
            (lo, hi) = span(&azimuth);
        }
        let width = hi - lo;
        if polar || width.is_nan() || width > HALF_TURN - 1e-3 {
            let rows = self.rows_of_polar(corners, rho);
            return [Window { rows, columns: 0..n_columns }, Window::default()];
        }
        // An edge is an arc of a great circle: it bulges away from the horizon by at most 1 / cos(width / 2), and
        // 1 - x^2 / 2 lies below cos x.
        let shrink = 1.0 - width * width * 0.1251;
        let mut rows = (self.rows.len(), 0);
        if shrink <= 0.1 {
            rows = (0, self.rows.len());
        } else {
            for i in 0..3 {
                for r in [rho[i], rho[i] * shrink] {
                    let (first, end) = self.rows_at(r, corners[i].z);
                    rows = (rows.0.min(first), rows.1.max(end));
                }
            }
        }
        self.columns_between(lo, hi).map(|columns| Window { rows: rows.0..rows.1, columns })
    }

    /// Rows of a triangle around or near the axis: all of it may be above or below the sensor.
    fn rows_of_polar(&self, corners: [Vec3; 3], rho: [f32; 3]) -> std::ops::Range<usize> {
        let farthest = rho[0].max(rho[1]).max(rho[2]) * 1.0001 + 1e-6;
        let (low, high) =
            (corners[0].z.min(corners[1].z).min(corners[2].z), corners[0].z.max(corners[1].z).max(corners[2].z));
        if low > self.height_span[1] {
            0..self.rows_at(farthest, low).1
        } else if high < self.height_span[0] {
            self.rows_at(farthest, high).0..self.rows.len()
        } else {
            0..self.rows.len()
        }
    }
}

/// The azimuth in [0, 2 pi] of a point, within 2e-6 rad; some number for the axis itself.
#[inline]
fn azimuth_of(x: f32, y: f32) -> f32 {
    let (ax, ay) = (x.abs(), y.abs());
    let (small, large) = if ax < ay { (ax, ay) } else { (ay, ax) };
    let t = small / large.max(f32::MIN_POSITIVE);
    let s = t * t;
    let p = -0.011_721_2_f32;
    let p = p * s + 0.052_653_32;
    let p = p * s - 0.116_432_87;
    let p = p * s + 0.193_543_46;
    let p = p * s - 0.332_623_47;
    let p = (p * s + 0.999_977_26) * t;
    let p = if ax < ay { std::f32::consts::FRAC_PI_2 - p } else { p };
    let p = if x < 0.0 { HALF_TURN - p } else { p };
    if y < 0.0 { TURN - p } else { p }
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
        self.table.ring_of_row[inner_row] as usize * self.table.cos_sin.len()
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
            let base = table.ring_of_row[row] as usize * table.cos_sin.len();
            for column in window.columns.clone() {
                let [cos, sin] = table.cos_sin[column];
                let at = |p: &[f64; 3]| p[0] * cos + p[1] * sin + p[2];
                if at(&e0) >= 0.0 && at(&e1) >= 0.0 && at(&e2) >= 0.0 {
                    let facing = at(&n);
                    if facing > 0.0 {
                        visit(base + column, distance / facing);
                    }
                }
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_fast_azimuth_is_within_its_margin() {
        for i in 0..200_000 {
            let exact = f64::from(i) * TAU / 200_000.0;
            let (x, y) = ((3.0 * math::cos(exact)) as f32, (3.0 * math::sin(exact)) as f32);
            let error = math::wrap_angle(f64::from(azimuth_of(x, y)) - exact).abs();
            assert!(error < 0.5 * f64::from(AZIMUTH_MARGIN), "{error} at {exact}");
        }
    }
}
