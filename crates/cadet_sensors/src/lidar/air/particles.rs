//! Drops and flakes in a beam: how many are bright enough to be detected, where, and how much of the beam they cover.
//!
//! Rain as in LISA (2021): Marshall and Palmer's drops in the beam's cone, the strongest wins. Snow after Hahner et al.
//! (CVPR 2022): flakes are discs, each takes its share of the beam, the target what is left. The paper samples discs in
//! the plane that a laser sweeps and shares the beam's angle; here they stand in the cone and share its area, since a
//! flake of 2 mm covers 3 % of the beam's width at 20 m but 0.1 % of its area.
//!
//! Only particles whose echo the receiver may detect are drawn: where sizes are exponential, so is what is
//! above a limit, and the number of bright ones along the beam is Poisson. That is exact and costs one random number on
//! most beams. All others only dim what is behind them, by the mean.

use super::air_echo::{AirEcho, FAINTEST_SHARE};
use crate::lidar::Receiver;
use crate::lidar::detection::focused;
use crate::weather::SizeDistribution;
use cadet_base::math::{self, PI};
use cadet_base::rng::CounterRng;

/// Reflectance of a drop: ((n - 1) / (n + 1))^2 with n = 1.328, water at 905 nm.
const DROP_REFLECTANCE: f64 = 0.328 * 0.328 / (2.328 * 2.328);
/// Reflectance of a flake. A snow pack has 0.8, but a lone flake lets most of the light through.
const FLAKE_REFLECTANCE: f64 = 0.3;
/// Nothing nearer returns anything.
pub(super) const CLOSED_M: f64 = 0.9;
/// Step of the tables over the range.
const STEP_M: f64 = 0.05;

/// The drops or the flakes of one weather.
#[derive(Debug, Clone)]
pub(super) struct Particles {
    reflectance: f64,
    seen_by: SeenBy,
    /// Of the exponential distribution of diameters, 1/m.
    slope_per_m: f64,
    /// Expected number of bright ones in a beam, and the chance of none.
    mean_bright: f64,
    chance_of_none: f64,
    /// Expected number of bright ones up to a range; a table by [`STEP_M`] from [`CLOSED_M`].
    bright_before: Vec<f64>,
    /// Expected share that bright ones up to a range cover, as an optical depth; a table like it.
    bright_depth: Vec<f64>,
}

/// What a laser sees of particles.
#[derive(Debug, Clone, Copy)]
pub(super) struct SeenBy {
    /// Of the beam.
    divergence_rad: f64,
    /// Of the laser's optics.
    focus_m: f64,
    /// The weakest echo that is drawn, in units of reflectance / range^2.
    least_power: f64,
    /// Two-way attenuation of their echo, per meter.
    dimming_per_m: f64,
}

/// A particle in a beam.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Particle {
    /// Share of the beam's area that it covers.
    pub share: f64,
    pub echo: AirEcho,
}

impl SeenBy {
    /// Drops of these sizes.
    pub(super) fn drops(self, sizes: SizeDistribution) -> Particles {
        Particles::new(sizes, DROP_REFLECTANCE, self)
    }

    /// Flakes of these sizes.
    pub(super) fn flakes(self, sizes: SizeDistribution) -> Particles {
        Particles::new(sizes, FLAKE_REFLECTANCE, self)
    }
}

impl Particles {
    /// What a laser sees of particles in air that attenuates by `alpha_per_m` one way.
    pub(super) fn seen_by(receiver: &Receiver, focus_m: f64, alpha_per_m: f64) -> SeenBy {
        SeenBy {
            divergence_rad: receiver.divergence_rad,
            focus_m,
            least_power: FAINTEST_SHARE * receiver.threshold(),
            dimming_per_m: 2.0 * alpha_per_m,
        }
    }

    fn new(sizes: SizeDistribution, reflectance: f64, seen_by: SeenBy) -> Self {
        let mut particles = Self {
            reflectance,
            seen_by,
            slope_per_m: sizes.slope_per_m,
            mean_bright: 0.0,
            chance_of_none: 1.0,
            bright_before: vec![0.0],
            bright_depth: vec![0.0],
        };
        // Beyond, even a particle as wide as the beam is too weak.
        let reach_m = (reflectance / seen_by.least_power).sqrt();
        let steps = ((reach_m - CLOSED_M) / STEP_M) as usize;
        for k in 0..steps {
            let r = CLOSED_M + (k as f64 + 0.5) * STEP_M;
            let (count, share) = particles.bright_at(sizes.number_per_m3, r);
            particles.bright_before.push(particles.bright_before[k] + count * STEP_M);
            particles.bright_depth.push(particles.bright_depth[k] + count * share * STEP_M);
        }
        particles.mean_bright = particles.bright_before[steps];
        particles.chance_of_none = math::exp(-particles.mean_bright);
        particles
    }

    /// Share of the beam that a particle at a range must cover to be detected.
    fn least_share(&self, range_m: f64) -> f64 {
        let seen_by = &self.seen_by;
        let full = self.reflectance * math::exp(-seen_by.dimming_per_m * range_m) * focused(seen_by.focus_m, range_m);
        seen_by.least_power * range_m * range_m / full.max(1e-300)
    }

    /// Bright particles a meter of beam at a range, and the share that each covers on average.
    fn bright_at(&self, number_per_m3: f64, range_m: f64) -> (f64, f64) {
        let width_m = self.seen_by.divergence_rad * range_m;
        let least = self.least_share(range_m);
        if least > 1.0 {
            return (0.0, 0.0);
        }
        let least_m = width_m * least.sqrt();
        let slope = self.slope_per_m;
        let count = number_per_m3 * PI / 4.0 * width_m * width_m * math::exp(-slope * least_m);
        // The mean of min(D, width)^2 for D = least + exponential.
        let tail = |d: f64| 2.0 / slope * (d + 1.0 / slope);
        let square = least_m * least_m + tail(least_m) - math::exp(-slope * (width_m - least_m)) * tail(width_m);
        (count, square / (width_m * width_m))
    }

    /// Calls `found` for every bright particle of one beam that is nearer than `range_m`, in no order.
    pub(super) fn draw(&self, range_m: f64, rng: &mut CounterRng, mut found: impl FnMut(Particle)) {
        // Poisson by its cumulative sum: most beams leave here.
        let chance = rng.unit();
        let mut probability = self.chance_of_none;
        let mut below = probability;
        let mut count = 0.0;
        while chance >= below && count < 4.0 * self.mean_bright + 20.0 {
            count += 1.0;
            probability *= self.mean_bright / count;
            below += probability;
            let at_m = self.range_before(rng.unit() * self.mean_bright);
            let size = rng.unit();
            if let Some(particle) = self.particle(at_m, size).filter(|p| p.echo.range_m < range_m) {
                found(particle);
            }
        }
    }

    /// Range before which `count` bright ones are expected, for a count below the mean.
    fn range_before(&self, count: f64) -> f64 {
        let above = self.bright_before.partition_point(|b| *b <= count).clamp(1, self.bright_before.len() - 1);
        let (low, high) = (self.bright_before[above - 1], self.bright_before[above]);
        let inside = ((count - low) / (high - low).max(1e-300)).clamp(0.0, 1.0);
        CLOSED_M + ((above - 1) as f64 + inside) * STEP_M
    }

    /// A bright particle at a range, its size by quantile; None where none can be bright.
    fn particle(&self, range_m: f64, size: f64) -> Option<Particle> {
        let width_m = self.seen_by.divergence_rad * range_m;
        let least = self.least_share(range_m);
        if least > 1.0 {
            return None;
        }
        let diameter_m = width_m * least.sqrt() - math::ln(1.0 - size) / self.slope_per_m;
        let share = (diameter_m / width_m * (diameter_m / width_m)).min(1.0);
        let power = self.seen_by.least_power * (share / least);
        Some(Particle { share, echo: AirEcho { range_m, power } })
    }

    /// Optical depth of the share that bright particles before `range_m` cover on average.
    pub(super) fn bright_depth(&self, range_m: f64) -> f64 {
        let place = ((range_m - CLOSED_M) / STEP_M).max(0.0);
        let last = self.bright_depth.len() - 1;
        let below = (place as usize).min(last);
        let above = (below + 1).min(last);
        math::lerp(self.bright_depth[below], self.bright_depth[above], (place - below as f64).min(1.0))
    }
}
