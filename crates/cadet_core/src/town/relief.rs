//! The lie of the land under a generated suburb: a few long waves, so that heights, slopes and bends are closed forms.

use crate::math::{self, DVec2, TAU};
use crate::rng::Stream;

/// Streets bend over crests and dips with at least this radius, which bounds the sum of all waves' curvatures.
const MIN_VERTICAL_RADIUS_M: f64 = 420.0;

#[derive(Debug, Clone)]
struct Wave {
    k: DVec2,
    phase: f64,
    amplitude_m: f64,
}

/// Height above sea level as a smooth function of the plane.
#[derive(Debug, Clone)]
pub(super) struct Relief {
    waves: Vec<Wave>,
}

impl Relief {
    /// Draws a relief: gentle for most suburbs (slopes of about 1 %), hilly for some (up to `max_slope`).
    pub(super) fn new(stream: &mut Stream, hilly_share: f64, max_slope: f64) -> Self {
        let hilly = stream.chance(hilly_share);
        let slope = if hilly { stream.range(0.6, 1.0) * max_slope } else { stream.range(0.15, 0.5) * max_slope };
        let mut waves: Vec<Wave> = (0..4)
            .map(|i| {
                let length = stream.range(260.0, 420.0) + 70.0 * f64::from(i);
                let heading = stream.range(0.0, TAU);
                let k = DVec2::new(math::cos(heading), math::sin(heading)) * (TAU / length);
                let steepness = stream.range(0.5, 1.0);
                Wave { k, phase: stream.range(0.0, TAU), amplitude_m: steepness / k.length() }
            })
            .collect();
        // The bounds hold where all waves peak at once, which they seldom do: two thirds of the slope bound is seen.
        let steepest: f64 = waves.iter().map(|w| w.amplitude_m * w.k.length()).sum();
        let tightest: f64 = waves.iter().map(|w| w.amplitude_m * w.k.length_squared()).sum();
        let scale = (slope / steepest * 1.5).min(1.0 / (MIN_VERTICAL_RADIUS_M * tightest));
        let scale = scale.min(max_slope / steepest);
        for w in &mut waves {
            w.amplitude_m *= scale;
        }
        Self { waves }
    }

    /// Height at a place.
    pub(super) fn height(&self, p: DVec2) -> f64 {
        self.waves.iter().map(|w| w.amplitude_m * math::sin(w.k.dot(p) + w.phase)).sum()
    }

    /// Slope at a place: metres up per metre east and north.
    pub(super) fn gradient(&self, p: DVec2) -> DVec2 {
        self.waves.iter().fold(DVec2::ZERO, |g, w| g + w.k * (w.amplitude_m * math::cos(w.k.dot(p) + w.phase)))
    }
}
