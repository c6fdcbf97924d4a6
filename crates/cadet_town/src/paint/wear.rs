//! How worn a town's lines and streets are.

use cadet_base::rng::{CounterRng, Stream, StreamKey};

/// Share of fresh paint that is left, from new lines to old ones; tires and snow plows take up to 60 %.
pub(crate) const LEFT: [f32; 5] = [0.97, 0.88, 0.74, 0.58, 0.42];
/// How many lines are as worn.
const SHARES: [f64; 5] = [0.25, 0.3, 0.22, 0.15, 0.08];

/// The wear of each line, by its number.
#[derive(Debug, Clone, Copy, Default)]
pub(crate) struct Wear {
    seed: Option<u64>,
}

impl Wear {
    pub fn new(stream: &mut Stream) -> Self {
        Self { seed: Some(stream.next_u64()) }
    }

    /// What else years leave is drawn from: a stream of a name and a number; none where nothing was drawn.
    pub fn stream(&self, name: &str, number: u64) -> Option<Stream> {
        self.seed.map(|seed| StreamKey::scene(seed).indexed(name, number))
    }

    /// An index of [`LEFT`]; all lines are new where nothing was drawn.
    pub fn level(&self, line: u32) -> usize {
        let Some(seed) = self.seed else { return 0 };
        let drawn = CounterRng::new(CounterRng::key(seed, [u64::from(line), 0, 0])).unit();
        let mut below = 0.0;
        let is_there = |share: &f64| {
            below += share;
            drawn < below
        };
        SHARES.iter().position(is_there).unwrap_or(LEFT.len() - 1)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn lines_are_worn_as_often_as_said_and_keep_their_wear() {
        let wear = Wear::new(&mut Stream::from_seed("wear", 1));
        let mut count = [0; LEFT.len()];
        (0..20_000).for_each(|line| count[wear.level(line)] += 1);
        for (n, share) in count.iter().zip(SHARES) {
            assert!((f64::from(*n) / 20_000.0 - share).abs() < 0.015, "{count:?}");
        }
        let other = Wear::new(&mut Stream::from_seed("wear", 2));
        assert!((0..200).all(|line| wear.level(line) == wear.level(line)));
        assert!((0..200).any(|line| wear.level(line) != other.level(line)));
        assert!((0..200).all(|line| Wear::default().level(line) == 0));
        assert!(LEFT.iter().all(|left| (0.4..=1.0).contains(left)));
    }
}
