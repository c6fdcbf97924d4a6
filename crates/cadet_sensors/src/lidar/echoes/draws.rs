//! The random numbers of a beam.

use crate::zeros::Zeros;
use cadet_base::rng::{CounterRng, nearly_normal};

/// The random numbers of one beam, each in a place of its own: no beam's fate moves another's, and none is made that nobody
/// asks for.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Draws {
    key: u64,
}

/// Numbers of a beam.
const NUMBERS: u64 = 5;

impl Zeros for Draws {
    const ZEROS: Self = Self { key: 0 };
}

impl Draws {
    /// Those of a beam of a scan that has a key.
    #[inline(always)]
    pub(crate) fn new(scan_key: u64, beam: usize) -> Self {
        Self { key: CounterRng::key_at(scan_key, NUMBERS * beam as u64) }
    }

    /// Whether a pane is met where it is dirty, or snowed over.
    #[inline(always)]
    pub(super) fn pane_chance(self) -> f64 {
        unit(CounterRng::nth(self.key, 0) >> 32)
    }

    #[inline(always)]
    pub(crate) fn detection_chance(self) -> f64 {
        unit(CounterRng::nth(self.key, 0) & 0xffff_ffff)
    }

    #[inline(always)]
    pub(crate) fn saturation_chance(self) -> f64 {
        unit(CounterRng::nth(self.key, 1) >> 32)
    }

    /// Names the beam to the air.
    #[inline(always)]
    pub(crate) fn air_key(self) -> u64 {
        CounterRng::nth(self.key, 2)
    }

    #[inline(always)]
    pub(crate) fn range_deviate(self) -> f64 {
        nearly_normal(CounterRng::nth(self.key, 3))
    }

    #[inline(always)]
    pub(crate) fn gain_deviate(self) -> f64 {
        nearly_normal(CounterRng::nth(self.key, 4))
    }
}

/// Uniform in [0, 1), from a number of 32 bits.
#[inline(always)]
fn unit(bits: u64) -> f64 {
    bits as f64 * (1.0 / 4_294_967_296.0)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn draws_are_uniform_and_normal() {
        let n = 50_000;
        let draws: Vec<Draws> = (0..n as usize).map(|beam| Draws::new(77, beam)).collect();
        // None of a beam's five numbers is another beam's.
        let numbers = draws[..99].iter().flat_map(|draws| (0..5).map(|n| CounterRng::nth(draws.key, n)));
        assert_eq!(numbers.collect::<std::collections::BTreeSet<u64>>().len(), 99 * 5);
        for (pick, mean, var) in [
            ((|d: &Draws| d.pane_chance()) as fn(&Draws) -> f64, 0.5, 1.0 / 12.0),
            (|d| d.detection_chance(), 0.5, 1.0 / 12.0),
            (|d| d.saturation_chance(), 0.5, 1.0 / 12.0),
            (|d| (d.air_key() >> 32) as f64 / 4_294_967_296.0, 0.5, 1.0 / 12.0),
            (|d| (d.air_key() & 0xffff_ffff) as f64 / 4_294_967_296.0, 0.5, 1.0 / 12.0),
            (|d| d.range_deviate(), 0.0, 1.0),
            (|d| d.gain_deviate(), 0.0, 1.0),
        ] {
            let m = draws.iter().map(pick).sum::<f64>() / f64::from(n);
            let v = draws.iter().map(|d| (pick(d) - m) * (pick(d) - m)).sum::<f64>() / f64::from(n);
            assert!((m - mean).abs() < 0.02 && (v / var - 1.0).abs() < 0.03, "{m} {v}");
            // Neighboring beams, and those a column apart, know nothing of each other.
            for apart in [1, 2083] {
                let pairs = draws.iter().zip(&draws[apart..]).map(|(a, b)| (pick(a) - mean) * (pick(b) - mean));
                assert!((pairs.sum::<f64>() / f64::from(n) / var).abs() < 0.03);
            }
        }
    }
}
