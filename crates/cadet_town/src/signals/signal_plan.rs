//! When the lights of a junction are green: a plan that repeats, a pure function of time.

use cadet_base::rng::Stream;

/// How long yellow lasts at 50 km/h, and how long all are red before the next stage (RiLSA, the German guideline).
const YELLOW_S: f64 = 3.0;
const ALL_RED_S: f64 = 2.0;
/// Red and yellow are lit together for the last second before green.
const RED_YELLOW_S: f64 = 1.0;
/// Shortest and longest green, of streets and of main roads.
const GREEN_S: (f64, f64) = (15.0, 24.0);
const MAIN_GREEN_S: (f64, f64) = (22.0, 40.0);
/// People get their green this much after the vehicles that turn across their way.
const WALK_LATER_S: f64 = 0.5;
/// How fast slow walkers cross: nobody is on the ford any more when the next vehicles start.
const SLOW_WALK_MPS: f64 = 1.2;
/// People get no green that is shorter.
const LEAST_WALK_S: f64 = 3.0;

/// What a light for vehicles shows.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Aspect {
    /// Stop.
    Red,
    /// Stop, and get ready.
    RedYellow,
    /// Go.
    Green,
    /// Stop if you still can.
    Yellow,
}

/// The plan of one junction: stages follow each other, each with its green, yellow, and a time in which all are red.
#[derive(Debug, Clone, PartialEq)]
pub struct SignalPlan {
    offset_s: f64,
    /// When the green of each stage begins in the cycle, and how long it lasts.
    greens_s: Vec<(f64, f64)>,
    cycle_s: f64,
}

impl SignalPlan {
    /// Draws the plan of a junction; `is_main` says for each stage whether a main road arrives in it.
    pub(super) fn draw(is_main: &[bool], stream: &mut Stream) -> Self {
        let mut greens_s = Vec::with_capacity(is_main.len());
        let mut at_s = 0.0;
        for is_main in is_main {
            let (least, most) = if *is_main { MAIN_GREEN_S } else { GREEN_S };
            let green_s = stream.range(least, most).round();
            greens_s.push((at_s, green_s));
            at_s += green_s + YELLOW_S + ALL_RED_S;
        }
        let cycle_s = at_s.max(1.0);
        Self { offset_s: stream.range(0.0, cycle_s), greens_s, cycle_s }
    }

    /// How long it takes until all repeats.
    #[must_use]
    pub fn cycle_s(&self) -> f64 {
        self.cycle_s
    }

    /// The longest that a stage is not green.
    #[must_use]
    pub fn longest_red_s(&self) -> f64 {
        self.greens_s.iter().map(|(_, green_s)| self.cycle_s - green_s).fold(0.0, f64::max)
    }

    fn in_cycle_s(&self, time_s: f64) -> f64 {
        (time_s + self.offset_s).rem_euclid(self.cycle_s)
    }

    /// What the lights of a stage show.
    #[must_use]
    pub fn aspect(&self, stage: usize, time_s: f64) -> Aspect {
        let Some((start_s, green_s)) = self.greens_s.get(stage) else { return Aspect::Red };
        let since_s = (self.in_cycle_s(time_s) - start_s).rem_euclid(self.cycle_s);
        if since_s < *green_s {
            Aspect::Green
        } else if since_s < green_s + YELLOW_S {
            Aspect::Yellow
        } else if since_s >= self.cycle_s - RED_YELLOW_S {
            Aspect::RedYellow
        } else {
            Aspect::Red
        }
    }

    /// When in the cycle people may start over the ford in front of a stage's vehicles: from, until. `None` where the time
    /// is too short for its length.
    pub(super) fn walk_s(&self, stage: usize, length_m: f64) -> Option<(f64, f64)> {
        let next = (stage + 1) % self.greens_s.len();
        let ((own_s, _), (next_s, green_s)) = (*self.greens_s.get(stage)?, *self.greens_s.get(next)?);
        let from_s = next_s + WALK_LATER_S;
        let until_own_s = (own_s - next_s).rem_euclid(self.cycle_s);
        let until_s = next_s + green_s.min(until_own_s - length_m / SLOW_WALK_MPS);
        (next != stage && until_s - from_s >= LEAST_WALK_S).then_some((from_s, until_s))
    }

    /// Whether a time is between two of the cycle.
    pub(super) fn is_within(&self, (from_s, until_s): (f64, f64), time_s: f64) -> bool {
        (self.in_cycle_s(time_s) - from_s).rem_euclid(self.cycle_s) < until_s - from_s
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn plan(stages: usize, seed: u64) -> SignalPlan {
        let is_main: Vec<bool> = (0..stages).map(|s| (s as u64 + seed).is_multiple_of(2)).collect();
        SignalPlan::draw(&is_main, &mut Stream::from_seed("plan", seed))
    }

    #[test]
    fn one_stage_at_a_time_goes_for_as_long_as_drivers_expect() {
        for (stages, seed) in [(2, 0), (2, 1), (3, 2), (4, 3)] {
            let plan = plan(stages, seed);
            let step_s = 0.05;
            let aspects_at =
                |k: usize| -> Vec<Aspect> { (0..stages).map(|s| plan.aspect(s, k as f64 * step_s)).collect() };
            let steps = (2.0 * plan.cycle_s() / step_s) as usize;
            let (mut run_s, mut last) = (vec![0.0; stages], aspects_at(0));
            let mut first = vec![true; stages];
            for k in 0..steps {
                let now = aspects_at(k);
                let going = now.iter().filter(|a| matches!(a, Aspect::Green | Aspect::Yellow)).count();
                assert!(going <= 1, "{now:?}");
                for s in 0..stages {
                    if now[s] == last[s] {
                        run_s[s] += step_s;
                        continue;
                    }
                    let order = matches!(
                        (last[s], now[s]),
                        (Aspect::Green, Aspect::Yellow)
                            | (Aspect::Yellow, Aspect::Red)
                            | (Aspect::Red, Aspect::RedYellow)
                            | (Aspect::RedYellow, Aspect::Green)
                    );
                    assert!(order, "{:?} after {:?}", now[s], last[s]);
                    let expected = match last[s] {
                        Aspect::Green => 14.9..=40.1,
                        Aspect::Yellow => 2.9..=3.1,
                        Aspect::RedYellow => 0.9..=1.1,
                        Aspect::Red => 10.0..=200.0,
                    };
                    assert!(first[s] || expected.contains(&run_s[s]), "{:?} for {} s", last[s], run_s[s]);
                    (run_s[s], first[s]) = (step_s, false);
                }
                last = now;
            }
        }
    }

    #[test]
    fn the_plan_repeats_and_differs_from_seed_to_seed() {
        let (a, b) = (plan(2, 4), plan(2, 6));
        assert_eq!(a, plan(2, 4));
        let shows = |p: &SignalPlan, t: f64| p.aspect(0, t);
        let times = (0..4000).map(|k| f64::from(k) * 0.1);
        assert!(times.clone().all(|t| shows(&a, t) == shows(&a, t + 3.0 * a.cycle_s()) || {
            // On the very edge of a change the last bit may decide.
            shows(&a, t + 1e-6) != shows(&a, t - 1e-6)
        }));
        assert!(times.filter(|t| shows(&a, *t) != shows(&b, *t)).count() > 400);
    }

    #[test]
    fn who_starts_at_the_end_of_the_walkers_green_is_over_before_the_vehicles_start() {
        for seed in 0..20 {
            let plan = plan(2 + seed as usize % 2, seed);
            for stage in 0..plan.greens_s.len() {
                let length_m = 6.0 + seed as f64 * 0.5;
                let Some(window) = plan.walk_s(stage, length_m) else { continue };
                for k in 0..(plan.cycle_s() / 0.1) as usize {
                    let time_s = k as f64 * 0.1;
                    if plan.is_within(window, time_s) {
                        let over_s = length_m / SLOW_WALK_MPS - 0.2;
                        for t in 0..(over_s / 0.1) as usize {
                            let aspect = plan.aspect(stage, time_s + t as f64 * 0.1);
                            assert!(matches!(aspect, Aspect::Red | Aspect::RedYellow), "{aspect:?} after {t}");
                        }
                    }
                }
            }
        }
    }
}
