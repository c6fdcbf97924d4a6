//! Random streams, derived and never drawn in turn.
//!
//! A stream is named by (dataset seed, episode, sample, name): frame 812 can be made alone, and workers, order, kills
//! and resuming do not change a byte. The generator is ChaCha8, which is portable and has no bad seeds.

use rand_chacha::ChaCha8Rng;
use rand_chacha::rand_core::{Rng, SeedableRng};

use crate::math::{self, TAU};

/// Where in a dataset we are: what every random stream is derived from.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct StreamKey {
    /// The dataset's seed.
    pub seed: u64,
    /// The episode: one reset and its samples.
    pub episode: u64,
    /// Redraws of the world inside the episode after views without a labeled object.
    pub attempt: u64,
}

impl StreamKey {
    /// The key of a lone scene: episode 0, first attempt.
    #[must_use]
    pub fn scene(seed: u64) -> Self {
        Self { seed, episode: 0, attempt: 0 }
    }

    /// The stream `name` of the whole episode.
    #[must_use]
    pub fn stream(&self, name: &str) -> Stream {
        self.indexed(name, u64::MAX)
    }

    /// The stream `name` of one item of the episode: a sample, a house, a car.
    #[must_use]
    pub fn indexed(&self, name: &str, index: u64) -> Stream {
        let mut seed = [0_u8; 32];
        seed[..8].copy_from_slice(&self.seed.to_le_bytes());
        // Episode and attempt are 128 bits: the key holds the low ones of both, ChaCha's stream number the high ones.
        let (low_episode, high_episode) = (self.episode & EPISODE_MASK, self.episode >> EPISODE_BITS);
        let high_attempt = self.attempt >> ATTEMPT_BITS << ATTEMPT_BITS;
        seed[8..16].copy_from_slice(&(low_episode | (self.attempt << EPISODE_BITS)).to_le_bytes());
        seed[16..24].copy_from_slice(&index.to_le_bytes());
        seed[24..].copy_from_slice(&fnv1a(name.as_bytes()).to_le_bytes());
        let mut generator = ChaCha8Rng::from_seed(seed);
        generator.set_stream(high_episode | high_attempt);
        Stream(generator)
    }
}

/// Bits of an episode's and of an attempt's number that stand side by side in a stream's key.
const EPISODE_BITS: u32 = 40;
const ATTEMPT_BITS: u32 = u64::BITS - EPISODE_BITS;
const EPISODE_MASK: u64 = (1 << EPISODE_BITS) - 1;

fn fnv1a(bytes: &[u8]) -> u64 {
    bytes.iter().fold(0xcbf2_9ce4_8422_2325, |h, b| (h ^ u64::from(*b)).wrapping_mul(0x0100_0000_01b3))
}

/// One random stream, with the few distributions that we need, all portable.
#[derive(Debug, Clone)]
pub struct Stream(ChaCha8Rng);

impl Stream {
    /// A stream from a bare number: for a model's shape, named by its seed.
    #[must_use]
    pub fn from_seed(name: &str, seed: u64) -> Self {
        StreamKey { seed, episode: 0, attempt: 0 }.stream(name)
    }

    /// A random 64-bit number.
    #[inline]
    pub fn next_u64(&mut self) -> u64 {
        self.0.next_u64()
    }

    /// Uniform in [0, 1).
    #[inline]
    pub fn unit(&mut self) -> f64 {
        (self.0.next_u64() >> 11) as f64 * (1.0 / (1_u64 << 53) as f64)
    }

    /// Uniform between the least and the most.
    #[inline]
    pub fn within(&mut self, (least, most): (f64, f64)) -> f64 {
        self.range(least, most)
    }

    /// Uniform in [lo, hi).
    #[inline]
    pub fn range(&mut self, lo: f64, hi: f64) -> f64 {
        lo + (hi - lo) * self.unit()
    }

    /// Uniform in 0..n; 0 where n is 0.
    #[inline]
    pub fn below(&mut self, n: usize) -> usize {
        ((u128::from(self.0.next_u64()) * n as u128) >> 64) as usize
    }

    /// True with probability `p`.
    #[inline]
    pub fn chance(&mut self, p: f64) -> bool {
        self.unit() < p
    }

    /// Standard normal (Box-Muller; one of the pair is thrown away, so a draw costs the same whoever draws it).
    pub fn normal(&mut self) -> f64 {
        let u = 1.0 - self.unit();
        let v = self.unit();
        (-2.0 * math::ln(u)).sqrt() * math::cos(TAU * v)
    }

    /// Normal with mean and standard deviation, redrawn until it lies within 2.5 standard deviations.
    pub fn clipped_normal(&mut self, mean: f64, sd: f64) -> f64 {
        loop {
            let z = self.normal();
            if z.abs() <= 2.5 {
                return mean + sd * z;
            }
        }
    }

    /// Poisson with the given mean (Knuth's product; meant for means below 50).
    pub fn poisson(&mut self, mean: f64) -> usize {
        poisson_by(mean, || self.unit())
    }

    /// An index drawn with the given weights; 0 where they are empty or all 0.
    #[inline]
    pub fn weighted(&mut self, weights: &[f64]) -> usize {
        self.weighted_by(weights.iter().copied())
    }

    #[inline]
    fn weighted_by(&mut self, weights: impl Iterator<Item = f64> + Clone) -> usize {
        let total: f64 = weights.clone().sum();
        let mut left = self.unit() * total;
        for (i, w) in weights.enumerate() {
            left -= w;
            if left < 0.0 {
                return i;
            }
        }
        0
    }

    /// One of some choices, by their weights.
    ///
    /// # Panics
    /// If there is none.
    pub fn pick<T: Copy>(&mut self, choices: &[(T, f64)]) -> T {
        self.try_pick(choices).expect("there is a choice")
    }

    /// As [`Stream::pick`]; `None` where there is no choice.
    pub fn try_pick<T: Copy>(&mut self, choices: &[(T, f64)]) -> Option<T> {
        choices.get(self.weighted_by(choices.iter().map(|(_, weight)| *weight))).map(|(choice, _)| *choice)
    }

    /// Puts the items in a random order.
    pub fn shuffle<T>(&mut self, items: &mut [T]) {
        for i in (1..items.len()).rev() {
            items.swap(i, self.below(i + 1));
        }
    }
}

/// A counter-based generator (SplitMix64): a few random numbers of one item among many, such as a beam of a scan, from
/// a key of its own.
///
/// The key comes from a [`Stream`] or from [`CounterRng::key`], so that what one item draws moves no other.
#[derive(Debug, Clone)]
pub struct CounterRng(u64);

impl CounterRng {
    /// The numbers of a key.
    #[inline]
    #[must_use]
    pub fn new(key: u64) -> Self {
        Self(key)
    }

    /// A key out of a seed and what names the item.
    #[inline]
    #[must_use]
    pub fn key(seed: u64, names: [u64; 3]) -> u64 {
        names.iter().fold(scramble(seed ^ 0x6A09_E667_F3BC_C909), |key, name| scramble(key ^ name))
    }

    /// A random 64-bit number.
    #[inline]
    pub fn next_u64(&mut self) -> u64 {
        self.0 = Self::key_at(self.0, 1);
        scramble(self.0)
    }

    /// The key whose numbers are those of `key` from the `n`-th on, the first being the 0th.
    #[inline(always)]
    #[must_use]
    pub fn key_at(key: u64, n: u64) -> u64 {
        key.wrapping_add(n.wrapping_mul(0x9E37_79B9_7F4A_7C15))
    }

    /// The `n`-th number of a key, without those before it.
    #[inline(always)]
    #[must_use]
    pub fn nth(key: u64, n: u64) -> u64 {
        scramble(Self::key_at(key, n + 1))
    }

    /// Uniform in [0, 1).
    #[inline]
    pub fn unit(&mut self) -> f64 {
        (self.next_u64() >> 11) as f64 * (1.0 / (1_u64 << 53) as f64)
    }

    /// Poisson with the given mean; rounded from a nearly normal number above 30.
    pub fn poisson(&mut self, mean: f64) -> usize {
        if mean > 30.0 {
            return (mean + mean.sqrt() * nearly_normal(self.next_u64())).round().max(0.0) as usize;
        }
        poisson_by(mean, || self.unit())
    }
}

/// Knuth's product of uniform numbers.
fn poisson_by(mean: f64, mut unit: impl FnMut() -> f64) -> usize {
    let limit = math::exp(-mean);
    let (mut k, mut product) = (0, unit());
    while product > limit {
        k += 1;
        product *= unit();
    }
    k
}

#[inline(always)]
fn scramble(key: u64) -> u64 {
    let key = (key ^ (key >> 30)).wrapping_mul(0xBF58_476D_1CE4_E5B9);
    let key = (key ^ (key >> 27)).wrapping_mul(0x94D0_49BB_1331_11EB);
    key ^ (key >> 31)
}

/// A nearly normal number from 64 random bits: the sum of four uniform ones, without tails beyond 3.5 standard deviations.
#[inline(always)]
#[must_use]
pub fn nearly_normal(bits: u64) -> f64 {
    let sum = (bits & 0xffff) + (bits >> 16 & 0xffff) + (bits >> 32 & 0xffff) + (bits >> 48);
    (sum as f64 * (1.0 / 65_536.0) + 2.0 / 65_536.0 - 2.0) * 1.732_050_807_568_877_2
}

#[cfg(test)]
mod tests {
    use std::collections::BTreeSet;

    use super::*;

    #[test]
    fn streams_differ_by_every_part_of_their_name() {
        let key = StreamKey { seed: 1, episode: 2, attempt: 0 };
        let first = |mut s: Stream| s.next_u64();
        let base = first(key.indexed("lidar", 3));
        assert_eq!(base, first(key.indexed("lidar", 3)));
        let others = [
            first(key.indexed("lidar", 4)),
            first(key.indexed("camera", 3)),
            first(StreamKey { seed: 2, ..key }.indexed("lidar", 3)),
            first(StreamKey { episode: 3, ..key }.indexed("lidar", 3)),
            first(StreamKey { attempt: 1, ..key }.indexed("lidar", 3)),
        ];
        assert!(others.iter().all(|o| *o != base));
    }

    #[test]
    fn every_bit_of_seed_episode_and_attempt_counts() {
        let mut first = BTreeSet::new();
        let bits = (0..64).map(|bit| 1_u64 << bit);
        for value in bits.chain([0, u64::MAX, (1 << 53) + 1]) {
            let zero = StreamKey { seed: 0, episode: 0, attempt: 0 };
            for key in [
                StreamKey { seed: value, ..zero },
                StreamKey { episode: value, ..zero },
                StreamKey { attempt: value, ..zero },
            ] {
                first.insert(key.stream("bits").next_u64());
            }
        }
        // The three keys of zeros are one.
        assert_eq!(first.len(), 3 * 66 + 1);
    }

    #[test]
    fn a_golden_draw_keeps_old_datasets_reproducible() {
        assert_eq!(StreamKey::scene(7).stream("golden").next_u64(), 7_778_993_811_025_043_724);
    }

    #[test]
    fn counter_based_numbers_are_uniform_within_and_across_keys() {
        // SplitMix64's published first number for seed 0.
        assert_eq!(CounterRng::new(0).next_u64(), 0xE220_A839_7B1D_CDAF);
        let n = 20_000;
        let across: Vec<f64> = (0..n).map(|k| CounterRng::new(CounterRng::key(1, [2, 3, k])).unit()).collect();
        let mut rng = CounterRng::new(5);
        let within: Vec<f64> = (0..n).map(|_| rng.unit()).collect();
        let mut rng = CounterRng::new(5);
        assert!((0..9).all(|k| rng.next_u64() == CounterRng::nth(5, k)));
        assert_eq!(CounterRng::nth(CounterRng::key_at(5, 4), 3), CounterRng::nth(5, 7));
        for units in [across, within] {
            let mean = units.iter().sum::<f64>() / n as f64;
            let neighbors = units.windows(2).map(|w| (w[0] - 0.5) * (w[1] - 0.5)).sum::<f64>() / n as f64;
            let low = units.iter().filter(|u| **u < 0.01).count();
            assert!((mean - 0.5).abs() < 0.01 && neighbors.abs() < 0.003 && (150..250).contains(&low), "{mean}");
        }
        assert_ne!(CounterRng::key(1, [2, 3, 4]), CounterRng::key(1, [3, 2, 4]));
        assert_ne!(CounterRng::key(1, [2, 3, 4]), CounterRng::key(2, [2, 3, 4]));
    }

    #[test]
    fn normal_and_poisson_have_their_moments() {
        let mut s = Stream::from_seed("moments", 0);
        let n = 20_000;
        let z: Vec<f64> = (0..n).map(|_| s.normal()).collect();
        let mean = z.iter().sum::<f64>() / f64::from(n);
        let var = z.iter().map(|v| (v - mean) * (v - mean)).sum::<f64>() / f64::from(n);
        assert!(mean.abs() < 0.03 && (var - 1.0).abs() < 0.05, "{mean} {var}");
        let p = (0..n).map(|_| s.poisson(3.0) as f64).sum::<f64>() / f64::from(n);
        assert!((p - 3.0).abs() < 0.06, "{p}");
    }
}
