//! From the surfaces in a beam's way to what the sensor reports: what the air leaves of their echoes, and returns itself.

use super::returned_points::ReturnSurface;
use crate::lidar::air::{Air, AirEcho, Sprayed};
use crate::lidar::detection::{ReturnMode, RingReceiver, reading_noise};
use crate::lidar::echoes::{Draws, Echo};
use cadet_base::material::Semantic;

/// An echo that reaches the receiver: a surface's, or that of fog, a drop or a flake.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Arrival {
    pub range_m: f64,
    /// Reflectance / range^2.
    pub power: f64,
    /// True if it overflows the receiver.
    pub saturates: bool,
    /// Cosine of the incidence angle; None for fog, a drop or a flake, whose power is what falls on the detector.
    pub cos_incidence: Option<f64>,
    /// Standard deviation of its reading.
    pub reading_noise: f64,
    pub actor_id: i32,
    /// [`Semantic::Sky`] for fog, drops and flakes.
    pub semantic: Semantic,
    /// Its place among the echoes of its pulse that are detected, the nearest 1.
    pub number: u8,
    pub surface: ReturnSurface,
}

impl Arrival {
    /// The power by which it is detected: its peak, as far as it falls on the detector.
    fn detected_power(&self, receiver: &RingReceiver) -> f64 {
        self.power * self.cos_incidence.map_or(1.0, |cosine| receiver.detected_share(self.range_m, cosine))
    }
}

/// Standard deviation of the reading of a drop, a flake or fog.
const AIR_NOISE: f64 = 0.05;
/// The most echoes of a pulse: four quarters, a particle, fog, spray.
const MOST_ECHOES: usize = 7;

/// Calls `report` for what is reported of a pulse, by rising range. `echoes` are its surfaces', by rising range, None behind
/// the last; `spray` says what spray does to a beam up to a range. A lone echo may be too weak to be detected.
#[inline]
pub(crate) fn arrivals(
    echoes: &[Option<Echo>; 4],
    air: &Air,
    spray: impl Fn(f64) -> Sprayed,
    (mode, receiver, draws): (ReturnMode, &RingReceiver, &Draws),
    mut report: impl FnMut(&Arrival),
) {
    if air.is_clear() && echoes[1].is_none() {
        if let Some(echo) = &echoes[0] {
            report(&of_surface(echo, air, 1.0));
        }
        return;
    }
    let mut pulse = Pulse { arrivals: [None; MOST_ECHOES], n: 0 };
    for echo in echoes.iter().flatten() {
        let left = air.meet(echo.range_m, draws.air_key()).transmittance * spray(echo.range_m).transmittance;
        pulse.push(of_surface(echo, air, left));
    }
    let end_m = echoes.iter().flatten().last().map_or(f64::INFINITY, |e| e.range_m);
    let sprayed = spray(end_m).echo.map(|e| AirEcho { power: e.power * air.transmittance(e.range_m), ..e });
    for echo in air.meet(end_m, draws.air_key()).echoes.into_iter().chain([sprayed]).flatten() {
        pulse.push(of_air(&echo));
    }
    pulse.report(mode, receiver, draws.detection_chance(), report);
}

/// The echoes of one pulse.
struct Pulse {
    arrivals: [Option<Arrival>; MOST_ECHOES],
    n: usize,
}

impl Pulse {
    fn push(&mut self, arrival: Arrival) {
        self.arrivals[self.n] = Some(arrival);
        self.n += 1;
    }

    /// Calls `report` for those of the detected that the mode takes; of several within a pulse's length the strongest counts.
    fn report(self, mode: ReturnMode, receiver: &RingReceiver, chance: f64, mut report: impl FnMut(&Arrival)) {
        let is_detected = |a: &&Arrival| receiver.receiver.detects(a.detected_power(receiver), chance);
        let mut found = self.arrivals.iter().flatten().filter(is_detected);
        let Some(first) = found.next() else { return };
        let Some(second) = found.next() else { return report(first) };
        let mut sorted: Vec<Arrival> = [first, second].into_iter().chain(found).copied().collect();
        sorted.sort_by(|a, b| a.range_m.total_cmp(&b.range_m));
        let pulse_m = receiver.receiver.pulse_m();
        let mut detected: Vec<Arrival> = Vec::with_capacity(sorted.len());
        for arrival in sorted {
            match detected.last_mut().filter(|last| arrival.range_m - last.range_m < pulse_m) {
                Some(last) if last.detected_power(receiver) >= arrival.detected_power(receiver) => {}
                Some(last) => *last = arrival,
                None => detected.push(arrival),
            }
        }
        let powers: Vec<f64> = detected.iter().map(|arrival| arrival.detected_power(receiver)).collect();
        for k in (0..powers.len()).filter(|k| mode.reports(&powers, *k)) {
            report(&Arrival { number: k as u8 + 1, ..detected[k] });
        }
    }
}

/// The echo of a surface, of which the air leaves a share.
#[inline]
fn of_surface(echo: &Echo, air: &Air, left: f64) -> Arrival {
    let reflectance = if echo.semantic.is_ground() {
        air.ground(echo.semantic, echo.reflectance, echo.cos_incidence)
    } else {
        echo.reflectance
    };
    Arrival {
        range_m: echo.range_m,
        power: reflectance / (echo.range_m * echo.range_m) * left,
        saturates: echo.retro,
        cos_incidence: Some(echo.cos_incidence),
        reading_noise: reading_noise(echo.pattern),
        actor_id: echo.actor_id,
        semantic: echo.semantic,
        number: 1,
        surface: ReturnSurface {
            cos_incidence: echo.cos_incidence as f32,
            reflectance: reflectance as f32,
            normal_velo: echo.normal_velo,
            pattern: Some(echo.pattern),
        },
    }
}

/// An echo of the air.
fn of_air(echo: &AirEcho) -> Arrival {
    Arrival {
        range_m: echo.range_m,
        power: echo.power,
        saturates: false,
        cos_incidence: None,
        reading_noise: AIR_NOISE,
        actor_id: 0,
        semantic: Semantic::Sky,
        number: 1,
        surface: ReturnSurface::AIR,
    }
}

#[cfg(test)]
mod tests;
