//! What a cloud of droplets returns: fog, and the spray behind vehicles.
//!
//! A pulse in droplets that are much larger than a wavelength returns what is scattered straight back: extinction over the
//! lidar ratio of water droplets, 18 sr (Pinnick et al., JGR 1983), along half a pulse's length. That is as much as a diffuse
//! surface of `pi extinction pulse / 18` returns. Clouds are clumpy: echoes are spread exponentially about that mean, and the
//! strongest clump along the beam is the cloud's.

use super::air_echo::{AirEcho, FAINTEST_SHARE};
use super::particles::CLOSED_M;
use crate::lidar::Receiver;
use crate::lidar::detection::focused;
use cadet_base::math::{self, PI};
use cadet_base::rng::CounterRng;

/// Extinction over backscatter of water droplets, sr.
const LIDAR_RATIO_SR: f64 = 18.0;
/// Hardly a clump, 1 in 20,000, is brighter than this many times the mean.
const MOST_CLUMP: f64 = 10.0;
/// Step of the table over the range.
const STEP_M: f64 = 0.1;
/// Nothing farther is looked for.
const REACH_M: f64 = 100.0;

/// Reflectance of a diffuse surface that returns as much to a receiver as droplets of an extinction of 1/m.
pub(super) fn reflectance_m(receiver: &Receiver) -> f64 {
    PI * receiver.pulse_m() / LIDAR_RATIO_SR
}

/// How much brighter than the mean a clump is: exponential.
#[inline]
pub(super) fn clump(rng: &mut CounterRng) -> f64 {
    -math::quick_ln((1.0 - rng.unit()).max(1e-12))
}

/// The droplets of a weather that fill the air, as one laser sees them.
#[derive(Debug, Clone)]
pub(super) struct Fog {
    reflectance: f64,
    /// Two-way attenuation per meter, by all that is in the air.
    dimming_per_m: f64,
    focus_m: f64,
    /// Mean echo up to a range, summed over meters; a table by [`STEP_M`] from [`CLOSED_M`].
    echo_before: Vec<f64>,
    /// Clumps that are fainter than this many times the mean are not detected, wherever they are.
    least_clump: f64,
}

impl Fog {
    /// Fog of an extinction (1/m) in air that attenuates by `alpha_per_m` one way; None where no receiver of that focus
    /// detects echoes of it.
    pub(super) fn new(extinction_per_m: f64, alpha_per_m: f64, receiver: &Receiver, focus_m: f64) -> Option<Self> {
        let reflectance = reflectance_m(receiver) * extinction_per_m;
        let dimming_per_m = 2.0 * alpha_per_m;
        let mut fog = Self { reflectance, dimming_per_m, focus_m, echo_before: vec![0.0], least_clump: 0.0 };
        let mut strongest = 0.0_f64;
        for k in 0..((REACH_M - CLOSED_M) / STEP_M) as usize {
            let mean = fog.mean_power(CLOSED_M + (k as f64 + 0.5) * STEP_M);
            strongest = strongest.max(mean);
            fog.echo_before.push(fog.echo_before[k] + mean * STEP_M);
        }
        fog.least_clump = FAINTEST_SHARE * receiver.threshold() / strongest;
        (fog.least_clump < MOST_CLUMP).then_some(fog)
    }

    /// Mean echo of a pulse's length at a range, in units of reflectance / range^2.
    fn mean_power(&self, range_m: f64) -> f64 {
        let open = self.reflectance * focused(self.focus_m, range_m) / (range_m * range_m);
        open * math::exp(-self.dimming_per_m * range_m)
    }

    /// The strongest of four clumps before a range, which may be infinite: it lies wherever the mean echo comes from.
    pub(super) fn strongest_before(&self, range_m: f64, rng: &mut CounterRng) -> Option<AirEcho> {
        let brightness = -math::quick_ln((1.0 - rng.unit().sqrt().sqrt()).max(1e-12));
        if brightness < self.least_clump {
            return None;
        }
        let last = self.echo_before.len() - 1;
        let place = ((range_m - CLOSED_M) / STEP_M).clamp(0.0, last as f64);
        let below = (place as usize).min(last - 1);
        let total = math::lerp(self.echo_before[below], self.echo_before[below + 1], place - below as f64);
        if total <= 0.0 {
            return None;
        }
        let at_m = self.range_of(rng.unit() * total);
        Some(AirEcho { range_m: at_m, power: self.mean_power(at_m) * brightness })
    }

    /// Range up to which the mean echoes sum up to `sum`.
    fn range_of(&self, sum: f64) -> f64 {
        let above = self.echo_before.partition_point(|s| *s <= sum).clamp(1, self.echo_before.len() - 1);
        let (low, high) = (self.echo_before[above - 1], self.echo_before[above]);
        let inside = ((sum - low) / (high - low).max(1e-300)).clamp(0.0, 1.0);
        CLOSED_M + ((above - 1) as f64 + inside) * STEP_M
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn echoes(fog: &Fog, range_m: f64) -> Vec<AirEcho> {
        (0..4000).filter_map(|k| fog.strongest_before(range_m, &mut CounterRng::new(k))).collect()
    }

    #[test]
    fn fog_returns_what_the_lidar_equation_says() {
        // By hand for 0.06 1/m, 5 ns and a focus of 6 m: pi 0.06 0.749 / 18 at 6 m, dimmed by exp(-0.72).
        let fog = Fog::new(0.06, 0.06, &Receiver::default(), 6.0).expect("bright");
        let by_hand = PI * 0.06 * 0.749_481 / 18.0 / 36.0 * math::exp(-0.72);
        assert!((fog.mean_power(6.0) / by_hand - 1.0).abs() < 1e-5, "{} {by_hand}", fog.mean_power(6.0));
        // The sum of the table is the integral: below the focus of r exp(-2 alpha r) / f^3, by parts.
        let integral = |r: f64| -(r / 0.12 + 1.0 / (0.12 * 0.12)) * math::exp(-0.12 * r);
        let expected = PI * 0.06 * 0.749_481 / 18.0 / 216.0 * (integral(5.9) - integral(0.9));
        assert!((fog.echo_before[50] / expected - 1.0).abs() < 1e-3, "{} {expected}", fog.echo_before[50]);
    }

    #[test]
    fn echoes_lie_before_the_target_and_about_where_fog_is_brightest() {
        let fog = Fog::new(0.06, 0.06, &Receiver::default(), 6.0).expect("bright");
        let open = echoes(&fog, f64::INFINITY);
        let mean_m = open.iter().map(|e| e.range_m).sum::<f64>() / open.len() as f64;
        assert!((4.0..9.0).contains(&mean_m), "{mean_m}");
        for (range_m, all) in [(3.0, echoes(&fog, 3.0)), (20.0, echoes(&fog, 20.0))] {
            assert!(all.len() > 3900 && all.iter().all(|e| (0.9..=range_m).contains(&e.range_m)));
        }
        assert!(fog.strongest_before(0.5, &mut CounterRng::new(1)).is_none());
    }

    #[test]
    fn a_receiver_that_is_focused_far_away_sees_no_fog() {
        assert!(Fog::new(0.06, 0.06, &Receiver::default(), 60.0).is_none());
        assert!(Fog::new(1e-5, 1e-5, &Receiver::default(), 6.0).is_none());
    }
}
