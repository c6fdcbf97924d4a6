//! Thresholds, precision over recall, and their means.

/// The most thresholds, and the length of a curve: recall 0, 1/40, ..., 1.
pub const MAX_THRESHOLDS: usize = 41;

const STEPS: f64 = 40.0;

/// Precision at the recall positions 0, 1/40, ..., 1; 0 beyond the last threshold.
pub type PrecisionByRecall = [f64; MAX_THRESHOLDS];

/// Changes from each threshold to the next, summed over frames.
///
/// Whole numbers, similarities too (in units of 2^-60), so that sums do not depend on the order of the frames.
#[derive(Debug, Clone, Copy)]
pub(super) struct Tally {
    pub num_tp: [i64; MAX_THRESHOLDS],
    pub num_fp: [i64; MAX_THRESHOLDS],
    pub similarity: [i128; MAX_THRESHOLDS],
}

impl Default for Tally {
    fn default() -> Self {
        Self { num_tp: [0; MAX_THRESHOLDS], num_fp: [0; MAX_THRESHOLDS], similarity: [0; MAX_THRESHOLDS] }
    }
}

impl Tally {
    const UNIT: f64 = (1_u64 << 60) as f64;

    /// A similarity in 0..1 as a whole number.
    pub(super) fn fixed_point(similarity: f64) -> i128 {
        (similarity * Self::UNIT) as i128
    }

    pub(super) fn plus(mut self, other: &Self) -> Self {
        for i in 0..MAX_THRESHOLDS {
            self.num_tp[i] += other.num_tp[i];
            self.num_fp[i] += other.num_fp[i];
            self.similarity[i] += other.similarity[i];
        }
        self
    }

    /// Sums the changes up.
    pub(super) fn accumulate(mut self) -> Self {
        for i in 1..MAX_THRESHOLDS {
            self.num_tp[i] += self.num_tp[i - 1];
            self.num_fp[i] += self.num_fp[i - 1];
            self.similarity[i] += self.similarity[i - 1];
        }
        self
    }

    /// True positives over detections. KITTI's program divides 0 by 0 where every detection was taken by an object
    /// that does not count; that is 0 here.
    pub(super) fn precision(&self, num_thresholds: usize) -> PrecisionByRecall {
        self.envelope(num_thresholds, |i| self.num_tp[i] as f64)
    }

    /// Summed similarity over detections, 0 over 0 as above.
    pub(super) fn heading_similarity(&self, num_thresholds: usize) -> PrecisionByRecall {
        self.envelope(num_thresholds, |i| self.similarity[i] as f64 / Self::UNIT)
    }

    /// Each sample is the largest of its own and all later ones.
    fn envelope(&self, num_thresholds: usize, numerator: impl Fn(usize) -> f64) -> PrecisionByRecall {
        let mut samples = [0.0; MAX_THRESHOLDS];
        let mut most = 0.0_f64;
        for i in (0..num_thresholds).rev() {
            let detections = self.num_tp[i] + self.num_fp[i];
            if detections > 0 {
                most = most.max(numerator(i) / detections as f64);
            }
            samples[i] = most;
        }
        samples
    }
}

/// KITTI's choice of thresholds: the scores at which recall comes nearest to 0, 1/40, ..., 1. The last is always one.
///
/// `scores` are those of the true positives, falling; `num_valid` is how many objects there are to find.
#[must_use]
pub fn choose_thresholds(scores: &[f64], num_valid: u64) -> Vec<f64> {
    let mut thresholds = Vec::with_capacity(MAX_THRESHOLDS);
    let total = num_valid as f64;
    let mut recall = 0.0;
    for (i, &score) in scores.iter().enumerate() {
        let is_last = i + 1 == scores.len();
        let left = (i + 1) as f64 / total;
        let right = if is_last { left } else { (i + 2) as f64 / total };
        if !is_last && right - recall < recall - left {
            continue;
        }
        thresholds.push(score);
        recall += 1.0 / STEPS;
    }
    thresholds.truncate(MAX_THRESHOLDS);
    thresholds
}

/// The mean over the eleven recall positions 0, 0.1, ..., 1, in percent: KITTI's AP until October 2019.
#[must_use]
pub fn average_r11(samples: &PrecisionByRecall) -> f64 {
    samples.iter().step_by(4).sum::<f64>() / 11.0 * 100.0
}

/// The mean over the forty recall positions 1/40, 2/40, ..., 1, in percent: KITTI's AP since.
#[must_use]
pub fn average_r40(samples: &PrecisionByRecall) -> f64 {
    samples[1..].iter().sum::<f64>() / STEPS * 100.0
}

/// The curve of detections that are all right, which fewer than 41 objects keep short.
#[must_use]
pub fn perfect(num_valid: u64) -> PrecisionByRecall {
    let scores = vec![0.0; usize::try_from(num_valid).unwrap_or(usize::MAX).min(MAX_THRESHOLDS)];
    let num_thresholds = choose_thresholds(&scores, num_valid.min(MAX_THRESHOLDS as u64)).len();
    std::array::from_fn(|i| f64::from(u8::from(i < num_thresholds)))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_perfect_result_on_few_objects_stays_below_100() {
        // From KITTI's own program.
        assert!((average_r11(&perfect(10)) - 300.0 / 11.0).abs() < 1e-12);
        assert!((average_r40(&perfect(10)) - 22.5).abs() < 1e-12);
        assert!((average_r40(&perfect(40)) - 97.5).abs() < 1e-12);
        assert_eq!(average_r40(&perfect(41)), 100.0);
        assert_eq!(average_r40(&perfect(0)), 0.0);
        for num_valid in 41..3000 {
            let scores = vec![1.0; num_valid];
            assert_eq!(choose_thresholds(&scores, num_valid as u64).len(), 41, "{num_valid}");
        }
    }

    #[test]
    fn thresholds_keep_the_last_score_and_repeat_equal_ones() {
        assert_eq!(choose_thresholds(&[0.9, 0.9, 0.1], 3), [0.9, 0.9, 0.1]);
        let many: Vec<f64> = (0..1000).map(|i| 1.0 - f64::from(i) / 1000.0).collect();
        let thresholds = choose_thresholds(&many, 1000);
        assert_eq!(thresholds.len(), 41);
        assert_eq!(thresholds[40], many[999]);
        assert!(thresholds.windows(2).all(|pair| pair[0] > pair[1]));
        // Half of the objects found: recall ends half-way.
        assert_eq!(choose_thresholds(&many[..500], 1000).len(), 21);
    }

    #[test]
    fn nothing_over_nothing_is_zero() {
        let tally = Tally::default();
        assert_eq!(tally.precision(3), [0.0; MAX_THRESHOLDS]);
    }
}
