//! What fog itself sends back (Hahner et al., ICCV 2021).

use super::super::receiver::LIGHT_M_PER_S;
use super::crossover::{CLOSED_M, crossover};
use cadet_base::math::{self, PI};

/// Differential reflectance of a hard target, gamma / pi: fits the paper's units to real scans. There gamma = 1e-6 goes
/// with a pulse of 20 ns; with the sensor's 5 ns this one lets dense fog (0.06 per meter) take over at the same range.
const BETA_0: f64 = 0.596e-6 / PI;
/// Step of the integral's variable: 0.9 m and 1.0 m, where the crossover bends, are nodes of it.
const STEP_M: f64 = 0.01;
/// Intervals from 0.9 m to 1.0 m.
const OPENING: usize = 10;

/// The strongest response of one fog in front of a hard target, over the target's range.
///
/// I(R) depends on the fog's alpha and R alone, and its maximum over R < R0 on alpha and R0: this is the row of the table
/// at one alpha, without a need to interpolate between rows.
#[derive(Debug, Clone)]
pub(super) struct Fog {
    /// beta / beta0 * I at `CLOSED_M + 2 * k * STEP_M`, never falling, up to the peak.
    gain: Vec<f64>,
    /// Where I is largest.
    peak_m: f64,
}

/// What fog sends back where a target at R0 would return 1: the paper's `i_soft / i` and the range of its maximum.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Soft {
    pub gain: f64,
    pub range_m: f64,
}

impl Fog {
    /// The response of fog of `alpha_per_m` (above 0) to a pulse of that half-power width.
    pub(super) fn new(alpha_per_m: f64, pulse_s: f64) -> Self {
        // beta = 0.046 / MOR with MOR = ln 20 / alpha.
        let scale = 0.046 * alpha_per_m / math::ln(20.0) / BETA_0;
        let pulse_m = LIGHT_M_PER_S * pulse_s;
        // From 0.9 m to a pulse's length behind it, an even number and the crossover at least: beyond, the response only
        // falls.
        let intervals = ((0.5 * pulse_m / STEP_M) as usize * 2).max(OPENING);
        let echo: Vec<f64> = (0..=intervals)
            .map(|k| {
                let r = CLOSED_M + k as f64 * STEP_M;
                math::exp(-2.0 * alpha_per_m * r) * crossover(r) / (r * r)
            })
            .collect();
        let pulse: Vec<f64> = (0..=intervals)
            .map(|k| {
                let s = math::sin(PI * k as f64 * STEP_M / pulse_m);
                s * s
            })
            .collect();
        let mut gain = vec![0.0];
        let mut peak_m = CLOSED_M;
        for end in (2..=intervals).step_by(2) {
            // Simpson's rule, with the bend at 1 m between two of its parabolas. dt is 2 / c dr.
            let sum: f64 = (0..end)
                .step_by(2)
                .map(|k| {
                    let at = |j: usize| pulse[end - j] * echo[j];
                    at(k) + 4.0 * at(k + 1) + at(k + 2)
                })
                .sum();
            let response = scale * sum * STEP_M / 3.0 * 2.0 / LIGHT_M_PER_S;
            if end > OPENING && response < gain[gain.len() - 1] {
                break;
            }
            gain.push(response);
            peak_m = CLOSED_M + end as f64 * STEP_M;
        }
        Self { gain, peak_m }
    }

    /// The strongest response in front of a target at `range_m`.
    pub(super) fn before(&self, range_m: f64) -> Soft {
        let place = ((range_m - CLOSED_M) / (2.0 * STEP_M)).max(0.0);
        let last = self.gain.len() - 1;
        let below = (place as usize).min(last);
        let above = (below + 1).min(last);
        let best = math::lerp(self.gain[below], self.gain[above], place - below as f64);
        let best = if below == last { self.gain[last] } else { best };
        Soft { gain: best * range_m * range_m, range_m: range_m.min(self.peak_m) }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// I(R) of the specification, by the midpoint rule in time with 200,000 steps.
    fn direct(alpha: f64, tau: f64, range_m: f64) -> f64 {
        let (c, n) = (299_792_458.0, 200_000);
        let dt = 2.0 * tau / f64::from(n);
        (0..n)
            .map(|i| {
                let t = (f64::from(i) + 0.5) * dt;
                let r = range_m - c * t / 2.0;
                let xi = if r < 0.9 { 0.0 } else { ((r - 0.9) / 0.1).min(1.0) };
                if xi == 0.0 {
                    return 0.0;
                }
                let s = math::sin(PI * t / (2.0 * tau));
                s * s * math::exp(-2.0 * alpha * r) * xi / (r * r) * dt
            })
            .sum()
    }

    #[test]
    fn the_table_is_the_direct_integral() {
        for (alpha, tau) in [(0.005, 5e-9), (0.06, 5e-9), (0.2, 5e-9), (0.06, 20e-9)] {
            let fog = Fog::new(alpha, tau);
            let scale = 0.046 / (math::ln(20.0) / alpha) / (0.596e-6 / PI);
            let peak = fog.gain[fog.gain.len() - 1];
            // Between two entries the table is a line: what a line misses of sin^2 grows with the square of step / pulse.
            let step_of_pulse = 2.0 * STEP_M / (LIGHT_M_PER_S * tau / 2.0);
            let tolerance = 2e-5 + 0.45 * step_of_pulse * step_of_pulse;
            for r0 in [0.95, 1.0, 1.21, 1.51, 1.777, 1.95] {
                let soft = fog.before(r0);
                let (got, expected) = (soft.gain / (r0 * r0), scale * direct(alpha, tau, r0));
                assert!((got - expected).abs() < tolerance * peak, "{alpha} {r0}: {got} {expected} of {peak}");
                assert_eq!(soft.range_m, r0, "the response still rises at {r0}");
            }
            // Behind the peak the maximum stays: found here by a search over all ranges.
            let (best, at) = (0..350)
                .map(|k| 0.9 + 0.02 * f64::from(k))
                .map(|r| (direct_coarse(alpha, tau, r), r))
                .fold((0.0, 0.0), |a, b| if b.0 > a.0 { b } else { a });
            for r0 in [8.0, 30.0, 79.0] {
                let soft = fog.before(r0);
                let expected = scale * r0 * r0 * best;
                assert!((soft.gain / expected - 1.0).abs() < 1e-3, "{alpha} {r0}");
                assert!((soft.range_m - at).abs() < 0.05, "{} {at}", soft.range_m);
            }
        }
    }

    /// As [`direct`], in range instead of time and with fewer steps.
    fn direct_coarse(alpha: f64, tau: f64, range_m: f64) -> f64 {
        let (c, n) = (299_792_458.0_f64, 4000);
        let from = (range_m - c * tau).max(0.9);
        let dr = (range_m - from) / f64::from(n);
        (0..n)
            .map(|i| {
                let r = from + (f64::from(i) + 0.5) * dr;
                let s = math::sin(PI * (range_m - r) / (c * tau));
                s * s * math::exp(-2.0 * alpha * r) * ((r - 0.9) / 0.1).min(1.0) / (r * r) * dr * 2.0 / c
            })
            .sum()
    }

    #[test]
    fn dense_fog_takes_over_where_the_papers_does() {
        // With the paper's own pulse and gamma, and with the sensor's and ours: where the strongest echo of fog is as
        // strong as a hard target's.
        let peak = |tau| (0..400).map(|k| direct_coarse(0.06, tau, 0.9 + 0.02 * f64::from(k))).fold(0.0, f64::max);
        let (papers, ours) = (peak(20e-9) / (1e-6 / PI), peak(5e-9) / BETA_0);
        assert!((ours / papers - 1.0).abs() < 2e-3, "{ours} {papers}");
    }

    #[test]
    fn nothing_comes_from_where_the_receiver_is_blind() {
        let fog = Fog::new(0.06, 5e-9);
        assert_eq!(fog.before(0.5).gain, 0.0);
        assert_eq!(fog.before(0.9).gain, 0.0);
        assert!(fog.before(1.2).gain > 0.0);
    }
}
