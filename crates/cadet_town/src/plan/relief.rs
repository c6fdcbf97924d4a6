//! The lie of the land under a generated suburb: a few long waves, so that heights, slopes and bends are closed forms.

use cadet_base::math::{self, DVec2, TAU};
use cadet_base::plane::unit;
use cadet_base::rng::Stream;

/// Streets bend over crests and dips with at least this radius, which bounds the sum of all waves' curvatures. With it
/// a plane fitted to 28 m of road stays within 5 cm of it.
const MIN_VERTICAL_RADIUS_M: f64 = 1000.0;
/// The slope limit is kept within this distance of the middle, which holds a suburb of default size.
const REACH_M: f64 = 400.0;

#[derive(Debug, Clone)]
struct ReliefWave {
    k: DVec2,
    phase: f64,
    amplitude_m: f64,
}

/// Height above sea level as a smooth function of the plane.
#[derive(Debug, Clone)]
pub(crate) struct Relief {
    waves: Vec<ReliefWave>,
}

impl Relief {
    /// Draws a relief: gentle for most suburbs (slopes of about 1 %), hilly for some (up to `max_slope`).
    pub(crate) fn new(stream: &mut Stream, hilly_share: f64, max_slope: f64) -> Self {
        let hilly = stream.chance(hilly_share);
        let sum_of_slopes = max_slope * if hilly { stream.range(1.2, 1.8) } else { stream.range(0.35, 0.9) };
        let mut waves: Vec<ReliefWave> = (0..4)
            .map(|i| {
                let length = stream.range(380.0, 620.0) + 90.0 * f64::from(i);
                let heading = stream.range(0.0, TAU);
                let k = unit(heading) * (TAU / length);
                let steepness = stream.range(0.5, 1.0);
                ReliefWave { k, phase: stream.range(0.0, TAU), amplitude_m: steepness / k.length() }
            })
            .collect();
        // Waves seldom all peak at once: the slope seen along streets has a standard deviation of a quarter of the sum.
        let steepest: f64 = waves.iter().map(|w| w.amplitude_m * w.k.length()).sum();
        let tightest: f64 = waves.iter().map(|w| w.amplitude_m * w.k.length_squared()).sum();
        let scale = (sum_of_slopes / steepest).min(1.0 / (MIN_VERTICAL_RADIUS_M * tightest));
        waves.iter_mut().for_each(|w| w.amplitude_m *= scale);
        let mut relief = Self { waves };
        let seen = relief.steepest_within(REACH_M);
        if seen > max_slope {
            relief.waves.iter_mut().for_each(|w| w.amplitude_m *= max_slope / seen);
        }
        relief
    }

    /// Flattens the land until nothing bends over crests and dips with a smaller radius than this.
    pub(crate) fn flattened(mut self, radius_m: f64) -> Self {
        let tightest: f64 = self.waves.iter().map(|w| w.amplitude_m * w.k.length_squared()).sum();
        let scale = (1.0 / (radius_m * tightest)).min(1.0);
        self.waves.iter_mut().for_each(|w| w.amplitude_m *= scale);
        self
    }

    fn steepest_within(&self, reach_m: f64) -> f64 {
        let steps = || (-20..=20).map(|i| f64::from(i) * reach_m / 20.0);
        let places = steps().flat_map(|x| steps().map(move |y| DVec2::new(x, y)));
        places.map(|p| self.gradient(p).length()).fold(0.0, f64::max)
    }

    /// Height at a place.
    pub(crate) fn height(&self, p: DVec2) -> f64 {
        self.waves.iter().map(|w| w.amplitude_m * math::sin(w.k.dot(p) + w.phase)).sum()
    }

    /// Slope at a place: meters up per meter east and north.
    pub(crate) fn gradient(&self, p: DVec2) -> DVec2 {
        self.waves.iter().fold(DVec2::ZERO, |g, w| g + w.k * (w.amplitude_m * math::cos(w.k.dot(p) + w.phase)))
    }
}
