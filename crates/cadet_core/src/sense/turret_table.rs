//! A turret's tables: which rows and columns may pass through a point or a triangle.

use super::grid::Window;
use super::turret::TurretRing;
use crate::math::{self, Vec3};

/// Error of the single-precision azimuth, in radians: its polynomial and the rounding of coordinates.
pub(super) const AZIMUTH_MARGIN: f32 = 4e-5;
/// Triangles narrower than this are bounded by their corners, whose margins allow for the bulge of the edges.
pub(super) const NARROW_RAD: f32 = 0.02;
/// Points nearer to the axis than this fraction of their distance have no azimuth worth the name.
pub(super) const POLAR: f32 = 0.01;
pub(super) const TURN: f32 = std::f32::consts::TAU;
pub(super) const HALF_TURN: f32 = std::f32::consts::PI;

/// What does not depend on the pose. "Sorted" rows run from the highest elevation to the lowest.
#[derive(Debug)]
pub(super) struct Table {
    pub(super) rings: Vec<TurretRing>,
    /// Ring number of each sorted row.
    pub(super) ring_of_row: Vec<u32>,
    /// Tangent of the elevation, 1 / cosine of it, height: of each sorted row.
    pub(super) rows: Vec<SortedRow>,
    /// The lowest origin of any row above (and this one), and the highest of any row below: both fall with the row, so
    /// that the rows which pass above a point are a prefix even where heights and elevations are not in one order.
    pub(super) envelope: Vec<[f32; 3]>,
    pub(super) height_span: [f32; 2],
    pub(super) row_of_tangent: Lookup,
    pub(super) azimuths: Vec<f32>,
    /// Headings of all columns, once for each distinct offset of a ring.
    pub(super) cos_sin: Vec<[f64; 2]>,
    /// Where each ring's headings begin.
    pub(super) headings_of_ring: Vec<u32>,
    /// Rings fire up to this much counter-clockwise of their column's azimuth, and never clockwise.
    pub(super) max_offset: f32,
    pub(super) column_of_azimuth: Lookup,
}

#[derive(Debug, Clone, Copy)]
pub(super) struct SortedRow {
    pub(super) tangent: f64,
    pub(super) secant: f64,
    pub(super) height_m: f64,
}

/// Counts of table entries below a value, to start an exact search from.
#[derive(Debug)]
pub(super) struct Lookup {
    scale: f32,
    offset: f32,
    counts: Vec<u16>,
}

impl Lookup {
    /// `count(x)` entries lie below x, for x in lo..hi.
    pub(super) fn new(lo: f32, hi: f32, bins: usize, count: impl Fn(f32) -> usize) -> Self {
        let scale = bins as f32 / (hi - lo);
        let counts = (0..=bins).map(|b| count(lo + (b as f32 - 0.5) / scale) as u16).collect();
        Self { scale, offset: -lo * scale, counts }
    }

    /// About the number of entries below `x`, which is clamped to the table.
    #[inline]
    pub(super) fn guess(&self, x: f32) -> usize {
        self.guess_in_bin(self.bin(x))
    }

    #[inline]
    pub(super) fn bin(&self, x: f32) -> u32 {
        let bin = (x * self.scale + self.offset).max(0.0).min((self.counts.len() - 1) as f32);
        // Adding 2^23 rounds to a whole number that stands in the low bits; a plain cast is slower as it saturates.
        (bin + 8_388_608.0).to_bits() & 0xf_ffff
    }

    #[inline]
    pub(super) fn guess_in_bin(&self, bin: u32) -> usize {
        usize::from(self.counts[bin as usize])
    }
}

impl Table {
    pub(super) fn new(rings: &[TurretRing], azimuths_rad: &[f64], offsets_rad: &[f64]) -> Self {
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
        let mut distinct: Vec<f64> = offsets_rad.to_vec();
        distinct.sort_by(f64::total_cmp);
        distinct.dedup();
        let headings_of_ring = offsets_rad
            .iter()
            .map(|offset| (distinct.partition_point(|d| d < offset) * azimuths.len()) as u32)
            .collect();
        let heading = |azimuth: f64| [math::cos(azimuth), math::sin(azimuth)];
        let cos_sin = distinct.iter().flat_map(|d| azimuths_rad.iter().map(move |a| heading(a + d))).collect();
        let column_of_azimuth = Lookup::new(0.0, TURN, 8191, |x| azimuths.partition_point(|a| *a < x));
        Self {
            rings: rings.to_vec(),
            ring_of_row,
            rows,
            envelope,
            height_span,
            row_of_tangent,
            cos_sin,
            headings_of_ring,
            max_offset: distinct.last().map_or(0.0, |d| *d as f32),
            azimuths,
            column_of_azimuth,
        }
    }

    /// Cosine and sine of a ring's azimuths.
    #[inline]
    pub(super) fn headings(&self, ring: usize) -> &[[f64; 2]] {
        let start = self.headings_of_ring[ring] as usize;
        &self.cos_sin[start..start + self.azimuths.len()]
    }

    /// Number of columns below an azimuth.
    #[inline]
    pub(super) fn columns_below(&self, azimuth_rad: f32) -> usize {
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
    pub(super) fn rows_at(&self, rho: f32, z: f32) -> (usize, usize) {
        let middle = self.middle_height();
        self.rows_from_guess(rho, z, self.row_of_tangent.guess((middle - z) / rho))
    }

    #[inline]
    pub(super) fn middle_height(&self) -> f32 {
        0.5 * (self.height_span[0] + self.height_span[1])
    }

    /// [`Table::rows_at`], from a first guess of the row.
    #[inline]
    pub(super) fn rows_from_guess(&self, rho: f32, z: f32, guess: usize) -> (usize, usize) {
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
    pub(super) fn rows_between_tangents(&self, lo: f32, hi: f32) -> std::ops::Range<usize> {
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

    /// The columns any ring of which fires from one azimuth to another, which may lie up to a turn outside [0, 2 pi).
    pub(super) fn columns_between(&self, lo: f32, hi: f32) -> [std::ops::Range<usize>; 2] {
        let n = self.azimuths.len();
        let (lo, hi) = (lo - AZIMUTH_MARGIN - self.max_offset, hi + AZIMUTH_MARGIN);
        if lo < 0.0 {
            [self.columns_below(lo + TURN)..n, 0..self.columns_below(hi)]
        } else if hi >= TURN {
            [self.columns_below(lo)..n, 0..self.columns_below(hi - TURN)]
        } else {
            [self.columns_below(lo)..self.columns_below(hi), 0..0]
        }
    }

    /// Bounds of a triangle that is wide, near the axis or across the seam.
    pub(super) fn wide_windows(&self, corners: [Vec3; 3]) -> [Window; 2] {
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
    pub(super) fn rows_of_polar(&self, corners: [Vec3; 3], rho: [f32; 3]) -> std::ops::Range<usize> {
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
pub(super) fn azimuth_of(x: f32, y: f32) -> f32 {
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

#[cfg(test)]
mod tests {
    use super::*;
    use crate::math::TAU;

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
