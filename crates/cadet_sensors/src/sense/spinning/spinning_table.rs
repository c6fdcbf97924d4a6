//! The tables of a spinning LIDAR's beams: which rows and columns may pass through a point or a triangle.

use std::ops::Range;

use super::azimuth_ticks::{AZIMUTH_MARGIN_RAD, HALF_TURN_RAD, TURN_RAD, Ticks, azimuth_rad_of};
use super::laser_ring::LaserRing;
use super::row_lookup::{
    BULGE_SHARE, INVERSE_RHO_BINS, INVERSE_RHO_STEP_PER_M, Lookup, PLACE_STRIDE, SHARED_BITS, SortedRow, TANGENT_BINS,
    rows_of_place,
};
use crate::sense::grids::Window;
use cadet_base::math::{self, Vec3, greater, lesser};

/// Points this many times as far from the axis as the lasers are look alike to all of them but for their azimuth: a
/// beam that passes the axis at `left` meets the distance rho after sqrt(rho^2 - left^2), 0.03 % less.
const OFF_AXIS: f32 = 40.0;
/// Points nearer to the axis than this fraction of their distance have no azimuth worth the name.
pub(super) const POLAR_SHARE: f32 = 0.01;
/// What does not depend on the pose. "Sorted" rows run from the highest elevation to the lowest.
#[derive(Debug)]
pub(super) struct SpinningTable {
    pub(super) rings: Vec<LaserRing>,
    /// Ring number of each sorted row.
    pub(super) ring_of_row: Vec<u32>,
    /// Tangent of the elevation, 1 / cosine of it, height: of each sorted row.
    pub(super) rows: Vec<SortedRow>,
    /// The lowest origin of any row above (and this one), and the highest of any row below: both fall with the row, so
    /// that the rows which pass above a point are a prefix even where heights and elevations are not in one order.
    pub(super) envelope: Vec<[f32; 3]>,
    pub(super) height_span_m: [f32; 2],
    /// The farthest that a laser sits beside the axis.
    pub(super) most_left_m: f32,
    /// Points nearer to the axis are left to the slow path.
    pub(super) least_rho_m: f32,
    pub(super) row_of_tangent: Lookup,
    /// Where all lasers have one origin: the first row and the end of the rows that may pass through points whose
    /// tangents lie in a bin of `row_of_tangent`.
    pub(super) rows_of_bin: Option<Vec<[u16; 2]>>,
    /// Where they have several: the same for a bin of inverse distances and a bin of tangents ([`rows_of_place`]).
    pub(super) rows_of_place: Vec<[u16; 2]>,
    pub(super) azimuths_rad: Vec<f32>,
    /// Cosines and sines of all columns' azimuths, once for each distinct offset of a ring; and both side by side.
    pub(super) cos: Vec<f64>,
    pub(super) sin: Vec<f64>,
    pub(super) cos_sin: Vec<[f64; 2]>,
    /// Where each ring's cosines and sines begin.
    pub(super) headings_of_ring: Vec<u32>,
    /// Rings fire up to this much counter-clockwise of their column's azimuth, and never clockwise.
    pub(super) max_offset_rad: f32,
    pub(super) ticks: Ticks,
}

impl SpinningTable {
    pub(super) fn new(rings: &[LaserRing], azimuths_rad: &[f64], offsets_rad: &[f64]) -> Self {
        let mut ring_of_row: Vec<u32> = (0..rings.len() as u32).collect();
        ring_of_row.sort_by(|a, b| rings[*b as usize].elevation_rad.total_cmp(&rings[*a as usize].elevation_rad));
        let rows: Vec<SortedRow> = ring_of_row
            .iter()
            .map(|r| rings[*r as usize])
            .map(|r| SortedRow {
                tangent: math::tan(r.elevation_rad),
                secant: 1.0 / math::cos(r.elevation_rad),
                level: math::cos(r.elevation_rad),
                height_m: r.height_m,
                left_m: r.left_m,
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
        let height_span_m = [heights.clone().fold(f32::INFINITY, f32::min), heights.fold(f32::NEG_INFINITY, f32::max)];
        let (top, bottom) = (rows[0].tangent as f32, rows[rows.len() - 1].tangent as f32);
        let row_of_tangent = Lookup::new(-top - 1e-3, -bottom + 1e-3, TANGENT_BINS - 1, |x| {
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
        let cos_sin: Vec<[f64; 2]> =
            distinct.iter().flat_map(|d| azimuths_rad.iter().map(move |a| heading(a + d))).collect();
        let max_offset_rad = distinct.last().map_or(0.0, |d| *d as f32);
        let most_left_m = rows.iter().map(|r| r.left_m.abs() as f32).fold(0.0, f32::max);
        let one_origin = height_span_m[0] == height_span_m[1] && most_left_m == 0.0;
        let rows_of_bin = one_origin.then(|| {
            let tangents: Vec<f32> = rows.iter().map(|r| -r.tangent as f32).collect();
            row_of_tangent.ranges_of_bins(&tangents, |t| (BULGE_SHARE + 1e-4) * t.abs() + 1e-4)
        });
        let rows_of_place = match one_origin {
            true => Vec::new(),
            false => rows_of_place(&row_of_tangent, &rows, height_span_m),
        };
        Self {
            rings: rings.to_vec(),
            ring_of_row,
            rows,
            envelope,
            height_span_m,
            most_left_m,
            least_rho_m: (OFF_AXIS * most_left_m).max(0.02),
            row_of_tangent,
            rows_of_bin,
            rows_of_place,
            cos: cos_sin.iter().map(|h| h[0]).collect(),
            sin: cos_sin.iter().map(|h| h[1]).collect(),
            cos_sin,
            headings_of_ring,
            max_offset_rad,
            ticks: Ticks::new(azimuths_rad, max_offset_rad),
            azimuths_rad: azimuths,
        }
    }

    /// Cosine and sine of a ring's azimuths.
    #[inline]
    pub(super) fn headings(&self, ring: usize) -> &[[f64; 2]] {
        let start = self.headings_of_ring[ring] as usize;
        &self.cos_sin[start..start + self.azimuths_rad.len()]
    }

    /// Cosines and sines of eight columns, from one of the headings on.
    #[inline(always)]
    pub(super) fn eight_headings<const N: usize>(&self, first: usize) -> [&[f64; N]; 2] {
        let range = first..first + N;
        let (cos, sin) = (self.cos[range.clone()].try_into(), self.sin[range].try_into());
        [cos.expect("of that length"), sin.expect("of that length")]
    }

    /// The rows that may pass through a point at distance `rho_m` from the axis and height `z_m`: those before the range
    /// pass above it, those after it below.
    #[inline]
    pub(super) fn rows_at(&self, rho_m: f32, z_m: f32) -> Range<usize> {
        let middle = self.middle_height_m();
        self.rows_from_guess(rho_m, z_m, self.row_of_tangent.guess((middle - z_m) / rho_m))
    }

    /// Which of `rows_of_place` has about [`SpinningTable::rows_at`], by 1 / rho and a bin of tangents.
    #[inline(always)]
    pub(super) fn place(inverse_rho_per_m: f32, tangent_bin: u32) -> u32 {
        let near = lesser(inverse_rho_per_m * (1.0 / INVERSE_RHO_STEP_PER_M), INVERSE_RHO_BINS as f32 - 0.75) - 0.5;
        // As in [`Lookup::bin`].
        let near = (greater(near, 0.0) + 8_388_608.0).to_bits() & 0xff;
        near * PLACE_STRIDE as u32 + (tangent_bin >> SHARED_BITS)
    }

    #[inline]
    pub(super) fn middle_height_m(&self) -> f32 {
        0.5 * (self.height_span_m[0] + self.height_span_m[1])
    }

    /// [`SpinningTable::rows_at`], from a first guess of the row.
    #[inline]
    pub(super) fn rows_from_guess(&self, rho_m: f32, z_m: f32, guess: usize) -> Range<usize> {
        let slack = (BULGE_SHARE + 4e-4 * f32::from(self.most_left_m > 0.0)) * (z_m - self.middle_height_m()).abs()
            + 2e-6 * rho_m
            + 1e-6;
        let (above, below) = (z_m + slack, z_m - slack);
        let mut first = guess;
        let height = |e: &[f32; 3], k: usize| e[k] + rho_m * e[0];
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
        first..end
    }

    /// The rows whose tangents lie between two, about.
    #[inline]
    pub(super) fn rows_between_tangents(&self, lo_tangent: f32, hi_tangent: f32) -> Range<usize> {
        let slack = |t: f32| 1e-5 * (1.0 + t.abs().min(1e3));
        let (lo, hi) = (lo_tangent.max(-1e4) - slack(lo_tangent), hi_tangent.min(1e4) + slack(hi_tangent));
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
    pub(super) fn columns_between(&self, lo_rad: f32, hi_rad: f32) -> [Range<usize>; 2] {
        let n = self.azimuths_rad.len();
        let (lo, hi) = (lo_rad - AZIMUTH_MARGIN_RAD - self.max_offset_rad, hi_rad + AZIMUTH_MARGIN_RAD);
        let columns = |lo: f32, hi: f32| {
            let (first, end) = self.ticks.between(lo, hi);
            self.ticks.columns(first, end)
        };
        if lo < 0.0 {
            [columns(lo + TURN_RAD, TURN_RAD).start..n, columns(0.0, hi)]
        } else if hi >= TURN_RAD {
            [columns(lo, TURN_RAD).start..n, columns(0.0, hi - TURN_RAD)]
        } else {
            [columns(lo, hi), 0..0]
        }
    }

    /// Bounds of a piece that is wide, near the axis or across the seam.
    pub(super) fn wide_windows(&self, corners: [Vec3; 4]) -> [Window; 2] {
        let n_columns = self.azimuths_rad.len();
        let rho = corners.map(|p| (p.x * p.x + p.y * p.y).sqrt());
        let polar = (0..4).any(|i| rho[i] <= POLAR_SHARE * (corners[i].z.abs() + rho[i]) || rho[i] < 1e-3);
        let nearest_corner = least(&rho);
        let mut azimuth = corners.map(|p| azimuth_rad_of(p.x, p.y));
        let span = |a: &[f32; 4]| (least(a), most(a));
        let (mut lo, mut hi) = span(&azimuth);
        if hi - lo > HALF_TURN_RAD - 1e-3 {
            azimuth = azimuth.map(|a| if a < HALF_TURN_RAD { a + TURN_RAD } else { a });
            (lo, hi) = span(&azimuth);
        }
        let width = hi - lo;
        // An edge is an arc of a great circle: it bulges away from the horizon by at most 1 / cos(width / 2), and
        // 1 - x^2 / 2 lies below cos x. By the same factor it comes nearer to the axis than its ends.
        let shrink = 1.0 - width * width * 0.1251;
        let is_near = self.most_left_m > 0.0 && nearest_corner * shrink < self.least_rho_m;
        if polar || is_near || width.is_nan() || width > HALF_TURN_RAD - 1e-3 {
            let rows = self.rows_of_polar(corners, rho);
            return [Window { rows, columns: 0..n_columns }, Window::default()];
        }
        let mut rows = self.rows.len()..0;
        if shrink <= 0.1 {
            rows = 0..self.rows.len();
        } else {
            for i in 0..4 {
                for r in [rho[i], rho[i] * shrink] {
                    let found = self.rows_at(r, corners[i].z);
                    rows = rows.start.min(found.start)..rows.end.max(found.end);
                }
            }
        }
        let aside = if self.most_left_m > 0.0 { 1.001 * self.most_left_m / (nearest_corner * shrink) } else { 0.0 };
        self.columns_between(lo - aside, hi + aside).map(|columns| Window { rows: rows.clone(), columns })
    }

    /// Rows of a piece around or near the axis: all of it may be above or below the sensor.
    pub(super) fn rows_of_polar(&self, corners: [Vec3; 4], rho_m: [f32; 4]) -> Range<usize> {
        let farthest = most(&rho_m) * 1.0001 + 1e-6;
        let heights = corners.map(|p| p.z);
        let (low, high) = (least(&heights), most(&heights));
        if low > self.height_span_m[1] {
            0..self.rows_at(farthest, low).end
        } else if high < self.height_span_m[0] {
            self.rows_at(farthest, high).start..self.rows.len()
        } else {
            0..self.rows.len()
        }
    }
}

fn least(of: &[f32; 4]) -> f32 {
    of[0].min(of[1]).min(of[2].min(of[3]))
}

fn most(of: &[f32; 4]) -> f32 {
    of[0].max(of[1]).max(of[2].max(of[3]))
}
