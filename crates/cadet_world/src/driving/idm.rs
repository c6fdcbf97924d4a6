//! Following: the intelligent driver model (Treiber, Hennecke, Helbing 2000).

use crate::footprint::Footprint;
use crate::params::Following;
use crate::streets::Ahead;
use cadet_base::rng::Stream;

/// The most that a driver slows down by on a free road on which it is too fast.
const SLOWS_MPS2: f64 = 3.0;

/// One driver's parameters of the model.
#[derive(Debug, Clone, Copy)]
pub(crate) struct IdmParameters {
    /// Desired speed as a fraction of what limit and bends allow.
    pub desired_speed_factor: f64,
    /// Time gap to the car ahead.
    pub time_gap_s: f64,
    /// Bumper to bumper at a standstill.
    pub minimum_gap_m: f64,
    /// Strongest acceleration, the deceleration that is comfortable, and what the brakes can do.
    pub accel_mps2: f64,
    pub comfortable_mps2: f64,
    pub hardest_mps2: f64,
    /// Faster than this the vehicle does not go.
    pub top_speed_mps: f64,
}

impl IdmParameters {
    /// One driver's habits.
    pub fn draw(of: &Following, stream: &mut Stream) -> Self {
        let (factor, gap_s) = (of.desired_speed_factor, of.time_gap_s);
        Self {
            desired_speed_factor: stream.clipped_normal(factor.0, factor.1),
            time_gap_s: stream.clipped_normal(gap_s.0, gap_s.1),
            minimum_gap_m: of.minimum_gap_m,
            accel_mps2: of.accel_mps2,
            comfortable_mps2: of.comfortable_mps2,
            hardest_mps2: of.hardest_mps2,
            top_speed_mps: f64::INFINITY,
        }
    }

    /// Acceleration on a free road.
    pub fn free_road(&self, speed_mps: f64, desired_mps: f64) -> f64 {
        let ratio = (speed_mps.max(0.0) / desired_mps.max(0.5)).min(2.0);
        (self.accel_mps2 * (1.0 - ratio * ratio * ratio * ratio)).max(-SLOWS_MPS2)
    }

    /// What a gap to something ahead takes off the free road's acceleration.
    pub fn interaction_accel(&self, speed_mps: f64, gap_m: f64, leader_mps: f64) -> f64 {
        let ratio = self.wanted_gap_m(speed_mps, leader_mps) / gap_m.max(0.2);
        -self.accel_mps2 * ratio * ratio
    }

    fn wanted_gap_m(&self, speed_mps: f64, leader_mps: f64) -> f64 {
        let v = speed_mps.max(0.0);
        let closing = v * (v - leader_mps) / (2.0 * (self.accel_mps2 * self.comfortable_mps2).sqrt());
        self.minimum_gap_m + (v * self.time_gap_s + closing).max(0.0)
    }

    /// How far before a line it takes a comfortable deceleration to stop there.
    pub fn comfortable_stop_m(&self, speed_mps: f64) -> f64 {
        let gap_m = self.wanted_gap_m(speed_mps, 0.0) * (self.accel_mps2 / self.comfortable_mps2).sqrt();
        (gap_m - self.minimum_gap_m).max(0.0)
    }

    /// How long it takes to go a distance from a speed on, no faster than `most_mps`.
    pub fn time_to_go(&self, distance_m: f64, speed_mps: f64, most_mps: f64) -> f64 {
        let most_mps = most_mps.min(self.top_speed_mps).max(speed_mps).max(0.5);
        let reached_m = (most_mps * most_mps - speed_mps * speed_mps) / (2.0 * self.accel_mps2);
        let accelerates_m = distance_m.clamp(0.0, reached_m);
        let then_mps = (speed_mps * speed_mps + 2.0 * self.accel_mps2 * accelerates_m).sqrt();
        (then_mps - speed_mps) / self.accel_mps2 + (distance_m - accelerates_m).max(0.0) / most_mps
    }

    /// What the pedals give: free road and the worst of the gaps, within what brakes can do.
    pub fn pedals(&self, free_mps2: f64, worst_interaction_mps2: f64) -> f64 {
        (free_mps2 + worst_interaction_mps2).clamp(-self.hardest_mps2, self.accel_mps2 * 1.2)
    }
}

/// The gap from the front bumper to the first contact with an obstacle along the route, and the obstacle's speed along
/// the route there. `corridor_m` is half the width that the car needs.
pub(crate) fn gap_along(
    ahead: &[Ahead],
    spacing_m: f64,
    half_length_m: f64,
    corridor_m: f64,
    obstacle: &Footprint,
) -> Option<(f64, f64)> {
    ahead.iter().find_map(|sample| {
        let to = obstacle.closest_point(sample.at) - sample.at;
        let along = to.dot(sample.tangent);
        let across = sample.tangent.perp_dot(to).abs();
        let gap_m = sample.distance_m + along - half_length_m;
        // What the front has passed is beside us and no longer ours to avoid.
        let is_ahead = along.abs() <= spacing_m && across < corridor_m && gap_m > -1.0;
        (is_ahead && obstacle.is_level_with(sample.at, sample.z_m))
            .then(|| (gap_m, obstacle.velocity.dot(sample.tangent).max(0.0)))
    })
}
