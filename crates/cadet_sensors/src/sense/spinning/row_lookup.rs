//! Which of a spinning LIDAR's rows may pass through a point: tables by the tangent of its elevation and its distance.

use cadet_base::math::{greater, lesser};

/// An edge is an arc of a great circle. Between corners `w` apart in azimuth it rises over the tangent of their
/// elevations by a factor of at most 1 / cos(w / 2), which is 1.0008 for [`super::azimuth_ticks::NARROW_RAD`].
pub(super) const BULGE_SHARE: f32 = 1e-3;

/// A laser's row, by falling elevation.
#[derive(Debug, Clone, Copy)]
pub(super) struct SortedRow {
    pub(super) tangent: f64,
    pub(super) secant: f64,
    /// Cosine of the elevation.
    pub(super) level: f64,
    pub(super) height_m: f64,
    pub(super) left_m: f64,
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
        let bin = lesser(greater(x * self.scale + self.offset, 0.0), (self.counts.len() - 1) as f32);
        // Adding 2^23 rounds to a whole number that stands in the low bits; a plain cast is slower as it saturates.
        (bin + 8_388_608.0).to_bits() & 0xf_ffff
    }

    #[inline]
    pub(super) fn guess_in_bin(&self, bin: u32) -> usize {
        usize::from(self.counts[bin as usize])
    }
}

impl Lookup {
    /// For each bin the range of `sorted` (rising) entries that lie within `slack(x)` of an x in the bin.
    pub(super) fn ranges_of_bins(&self, sorted: &[f32], slack: impl Fn(f32) -> f32) -> Vec<[u16; 2]> {
        let last = self.counts.len() - 1;
        let range = |bin: usize| {
            // Bins are rounded to, so that each reaches half a step to both sides; the outermost have no end.
            let edge = |b: f32| (b - self.offset) / self.scale;
            let (lo, hi) = (edge(bin as f32 - 0.51), edge(bin as f32 + 0.51));
            let first = if bin == 0 { 0 } else { sorted.partition_point(|t| *t < lo - slack(lo)) };
            let end = if bin == last { sorted.len() } else { sorted.partition_point(|t| *t <= hi + slack(hi)) };
            [first as u16, end as u16]
        };
        (0..=last).map(range).collect()
    }
}

/// Bins of 1 / rho: [`INVERSE_RHO_STEP_PER_M`] each, the last without an end.
pub(super) const INVERSE_RHO_BINS: usize = 48;
pub(super) const INVERSE_RHO_STEP_PER_M: f32 = 1.0 / 60.0;
/// Bins of `row_of_tangent` that share a range in [`rows_of_place`], as a power of two.
pub(super) const SHARED_BITS: u32 = 2;
pub(super) const TANGENT_BINS: usize = 4096;
pub(super) const PLACE_STRIDE: usize = TANGENT_BINS >> SHARED_BITS;

/// The rows that may pass through points of a bin of tangents (over the middle height) and a bin of inverse distances.
///
/// Seen from the middle, a row at height h passes at the tangent `tan + (h - middle) / rho`: linear in 1 / rho, so
/// that its ends in a bin bound it.
pub(super) fn rows_of_place(lookup: &Lookup, rows: &[SortedRow], height_span_m: [f32; 2]) -> Vec<[u16; 2]> {
    let middle = 0.5 * (height_span_m[0] + height_span_m[1]);
    let half_span = 0.5 * (height_span_m[1] - height_span_m[0]);
    let edge = |bin: f32| (bin - lookup.offset) / lookup.scale;
    let mut out = Vec::with_capacity(INVERSE_RHO_BINS * PLACE_STRIDE);
    for near in 0..INVERSE_RHO_BINS {
        if near + 1 == INVERSE_RHO_BINS {
            out.resize(INVERSE_RHO_BINS * PLACE_STRIDE, [0, rows.len() as u16]);
            break;
        }
        let [least, most] = [near as f32 - 0.01, near as f32 + 1.01].map(|n| n * INVERSE_RHO_STEP_PER_M);
        let passes = |r: &SortedRow, inverse_rho: f32| r.tangent as f32 + (r.height_m as f32 - middle) * inverse_rho;
        let (mut lowest, mut highest): (Vec<f32>, Vec<f32>) =
            rows.iter().map(|r| (passes(r, least), passes(r, most))).map(|(a, b)| (a.min(b), a.max(b))).unzip();
        for i in 1..rows.len() {
            lowest[i] = lowest[i].min(lowest[i - 1]);
            let j = rows.len() - 1 - i;
            highest[j] = highest[j].max(highest[j + 1]);
        }
        for bin in 0..PLACE_STRIDE {
            let (from, to) = ((bin << SHARED_BITS) as f32 - 0.51, (((bin + 1) << SHARED_BITS) - 1) as f32 + 0.51);
            // The lookup's tangents fall as the rows' rise.
            let (high, low) = (-edge(from), -edge(to));
            let slack = |t: f32| (BULGE_SHARE + 6e-4) * (t.abs() + half_span * most) + 1e-4;
            let first = if bin == 0 { 0 } else { lowest.partition_point(|t| *t > high + slack(high)) };
            let end =
                if bin + 1 == PLACE_STRIDE { rows.len() } else { highest.partition_point(|t| *t >= low - slack(low)) };
            out.push([first as u16, end.max(first) as u16]);
        }
    }
    out
}
