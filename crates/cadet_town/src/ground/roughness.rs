//! How uneven streets are over meters: long-wave roughness as a sum of sines, so that heights are a closed form.

use cadet_base::math::{self, DVec2, TAU};
use cadet_base::plane::unit;
use cadet_base::rng::Stream;

/// (shortest and longest wave, root mean square height) of the octaves: with them the road 4 to 20 m ahead is off its
/// plane by as much as KITTI's. Shorter waves than the ground's triangles can follow are left out, and the triangles,
/// 4 m wide, leave half of the shortest here.
const OCTAVES: [((f64, f64), f64); 3] = [((8.0, 11.0), 0.0180), ((11.0, 17.0), 0.0185), ((18.0, 30.0), 0.0110)];
const WAVES_PER_OCTAVE: usize = 3;
/// Streets differ: the height is scaled by a factor that goes from place to place over this wave length, between these.
const PATCH_M: (f64, f64) = (140.0, 220.0);
const PATCH_SCALE: (f64, f64) = (0.8, 1.25);
/// No bump is higher and no dip deeper.
const MOST_M: f64 = 0.045;

/// A sine along one direction of the plane.
#[derive(Debug, Clone, Copy)]
pub(super) struct Wave {
    k: DVec2,
    phase: f64,
    amplitude_m: f64,
}

impl Wave {
    pub fn new(stream: &mut Stream, lengths_m: (f64, f64), amplitude_m: f64) -> Self {
        let (length_m, heading) = (stream.within(lengths_m), stream.range(0.0, TAU));
        let k = unit(heading) * (TAU / length_m);
        Self { k, phase: stream.range(0.0, TAU), amplitude_m }
    }

    pub fn height_m(&self, p: DVec2) -> f64 {
        self.amplitude_m * math::sin(self.k.dot(p) + self.phase)
    }
}

/// Bumps and dips of a town's ground: a few millimeters to three centimeters.
#[derive(Debug, Clone)]
pub struct Roughness {
    waves: Vec<Wave>,
    /// Of amplitude 1.
    patches: [Wave; 2],
}

impl Roughness {
    /// Draws the roughness of a town.
    #[must_use]
    pub fn new(stream: &mut Stream) -> Self {
        let mut waves = Vec::with_capacity(OCTAVES.len() * WAVES_PER_OCTAVE);
        for (lengths_m, rms_m) in OCTAVES {
            let amplitude_m = rms_m * (2.0 / WAVES_PER_OCTAVE as f64).sqrt();
            waves.extend((0..WAVES_PER_OCTAVE).map(|_| Wave::new(stream, lengths_m, amplitude_m)));
        }
        let patches = std::array::from_fn(|_| Wave::new(stream, PATCH_M, 0.5));
        Self { waves, patches }
    }

    /// Scales all heights.
    #[must_use]
    pub fn scaled(mut self, factor: f64) -> Self {
        self.waves.iter_mut().for_each(|w| w.amplitude_m *= factor);
        self
    }

    /// Height over the smooth ground at a place.
    #[must_use]
    pub fn height_m(&self, p: DVec2) -> f64 {
        let level = 0.5 + 0.5 * self.patches.iter().map(|w| w.height_m(p)).sum::<f64>();
        let scale = math::lerp(PATCH_SCALE.0, PATCH_SCALE.1, level);
        let height_m = scale * self.waves.iter().map(|w| w.height_m(p)).sum::<f64>();
        // Where many waves meet, the height bends off smoothly.
        height_m / (1.0 + height_m * height_m / (MOST_M * MOST_M)).sqrt()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn bumps_are_of_a_centimeter_and_slopes_are_small() {
        for seed in 0..5 {
            let roughness = Roughness::new(&mut Stream::from_seed("roughness", seed));
            let mut stream = Stream::from_seed("places", seed);
            let (mut square, mut steepest, n) = (0.0, 0.0_f64, 5000);
            for _ in 0..n {
                let p = DVec2::new(stream.range(-300.0, 300.0), stream.range(-300.0, 300.0));
                let z = roughness.height_m(p);
                assert!(z.abs() < MOST_M);
                square += z * z;
                steepest = steepest.max((roughness.height_m(p + DVec2::X) - z).abs());
            }
            let rms_m = (square / f64::from(n)).sqrt();
            assert!((0.012..0.024).contains(&rms_m) && steepest < 0.037, "{rms_m} {steepest}");
        }
    }
}
