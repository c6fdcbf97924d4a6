//! Azimuths of a spinning LIDAR: of points, and of its columns on the ticks of an encoder.

use cadet_base::math::greater;

/// Error of the single-precision azimuth, in radians: its polynomial and the rounding of coordinates.
pub(super) const AZIMUTH_MARGIN_RAD: f32 = 4e-5;
/// Triangles narrower than this are bounded by their corners, with [`super::row_lookup::BULGE_SHARE`] for their edges.
pub(super) const NARROW_RAD: f32 = 0.08;
pub(super) const TURN_RAD: f32 = std::f32::consts::TAU;
pub(super) const HALF_TURN_RAD: f32 = std::f32::consts::PI;

/// A turn in equal steps on which the columns lie, exactly or nearly: an encoder has such.
#[derive(Debug)]
pub(super) struct Ticks {
    per_rad: f32,
    /// How far an azimuth in ticks may be wrong, and a column off its tick.
    margin: f32,
    /// Spans of no more ticks than this, which the rings' offsets widen, are narrower than [`NARROW_RAD`].
    pub(super) narrow: u16,
    /// Number of columns on ticks before each.
    before: Vec<u16>,
}

/// Ticks a turn.
const LEAST_TICKS: u32 = 2048;
const MOST_TICKS: u32 = 16_384;

impl Ticks {
    pub(super) fn new(azimuths_rad: &[f64], max_offset_rad: f32) -> Self {
        let off_by = |n: u32| {
            let ticks = azimuths_rad.iter().map(move |a| a * f64::from(n) / std::f64::consts::TAU);
            ticks.map(|t: f64| (t - t.round()).abs())
        };
        let fits = |n: &u32| off_by(*n).all(|off| off < 1e-4);
        let n = (LEAST_TICKS..=MOST_TICKS).find(fits).unwrap_or(MOST_TICKS);
        let per_rad = n as f32 / TURN_RAD;
        let margin = off_by(n).fold(0.0, f64::max) as f32 + AZIMUTH_MARGIN_RAD * per_rad + 1e-6 * n as f32;
        let mut before = vec![0_u16; n as usize + 3];
        for azimuth in azimuths_rad {
            before[(azimuth * f64::from(n) / std::f64::consts::TAU).round() as usize + 1] += 1;
        }
        for i in 1..before.len() {
            before[i] += before[i - 1];
        }
        Self { per_rad, margin, narrow: ((NARROW_RAD + max_offset_rad) * per_rad) as u16 - 1, before }
    }

    /// The first tick and the end of the ticks from one azimuth to another, in 0..=2 pi.
    #[inline(always)]
    pub(super) fn between(&self, lo_rad: f32, hi_rad: f32) -> (u16, u16) {
        // Adding 2^23 rounds to a whole number that stands in the low bits; a plain cast is slower as it saturates.
        let after = |t: f32| ((greater(t, -0.5) + 0.5 + 8_388_608.0).to_bits() & 0xffff) as u16;
        (after(lo_rad * self.per_rad - self.margin), after(hi_rad * self.per_rad + self.margin))
    }

    /// The columns on the ticks of a range.
    #[inline(always)]
    pub(super) fn columns(&self, first: u16, end: u16) -> std::ops::Range<usize> {
        let last = self.before.len() - 1;
        let at = |tick: u16| usize::from(self.before[usize::from(tick).min(last)]);
        at(first)..at(end)
    }
}

/// The azimuth in [0, 2 pi] of a point, within 2e-6 rad; some number for the axis itself.
#[inline]
pub(crate) fn azimuth_rad_of(x: f32, y: f32) -> f32 {
    let (ax, ay) = (x.abs(), y.abs());
    let (small, large) = if ax < ay { (ax, ay) } else { (ay, ax) };
    let t = small / greater(large, f32::MIN_POSITIVE);
    let s = t * t;
    let p = -0.011_721_2_f32;
    let p = p * s + 0.052_653_32;
    let p = p * s - 0.116_432_87;
    let p = p * s + 0.193_543_46;
    let p = p * s - 0.332_623_47;
    let p = (p * s + 0.999_977_26) * t;
    let p = if ax < ay { std::f32::consts::FRAC_PI_2 - p } else { p };
    let p = if x < 0.0 { HALF_TURN_RAD - p } else { p };
    if y < 0.0 { TURN_RAD - p } else { p }
}

#[cfg(test)]
mod tests {
    use super::*;
    use cadet_base::math::{self, TAU};

    #[test]
    fn the_fast_azimuth_is_within_its_margin() {
        for i in 0..200_000 {
            let exact = f64::from(i) * TAU / 200_000.0;
            let (x, y) = ((3.0 * math::cos(exact)) as f32, (3.0 * math::sin(exact)) as f32);
            let error = math::wrap_angle(f64::from(azimuth_rad_of(x, y)) - exact).abs();
            assert!(error < 0.5 * f64::from(AZIMUTH_MARGIN_RAD), "{error} at {exact}");
        }
    }
}
