//! The ground beside country roads in section: a verge that falls off gently, a ditch, and the field behind it.

use crate::ground::roughness::Wave;
use cadet_base::math::{self, DVec2, PI};
use cadet_base::rng::Stream;

/// How steeply a verge falls away from the asphalt.
const VERGE_SLOPE: f64 = 0.05;
/// Width of a ditch and how deep it is where it is deepest, and the share of its width that its bottom takes.
const DITCH_M: (f64, f64) = (1.6, 2.4);
const DITCH_DEPTH_M: (f64, f64) = (0.3, 0.55);
const DITCH_BOTTOM: f64 = 0.24;
/// Fields lie so far below the road at most, or above it.
const FIELD_M: (f64, f64) = (-0.25, 0.45);
/// Ditches come and go over such lengths, and fields lie higher or lower.
const WAVE_M: (f64, f64) = (90.0, 210.0);
/// Embankments and cuttings beside motorways, as wide wherever they are, with a shallow gutter: their width, its depth,
/// how far fields lie below the road or above it, and the lengths over which they lie higher or lower.
const SLOPE_M: f64 = 9.0;
const GUTTER_DEPTH_M: f64 = 0.2;
const MOTORWAY_FIELD_M: (f64, f64) = (-4.0, 4.8);
const MOTORWAY_WAVE_M: (f64, f64) = (300.0, 700.0);
/// No distance from a road beyond this is told.
pub(crate) const FARTHEST_M: f64 = 12.0;

/// What the ground beside all roads of a network has in common.
#[derive(Debug, Clone)]
pub(crate) struct Roadside {
    /// Width of the verges.
    pub verge_m: f64,
    /// Width of the ditches.
    pub ditch_m: f64,
    depth_m: f64,
    field_m: (f64, f64),
    waves: [Wave; 4],
}

impl Roadside {
    /// Draws it for verges of a width.
    pub fn new(stream: &mut Stream, verge_m: f64) -> Self {
        let (ditch_m, depth_m) = (stream.within(DITCH_M), stream.within(DITCH_DEPTH_M));
        Self { verge_m, ditch_m, depth_m, field_m: FIELD_M, waves: draw_waves(stream, WAVE_M) }
    }

    /// Draws it for a motorway.
    pub fn beside_motorway(stream: &mut Stream, verge_m: f64) -> Self {
        let waves = draw_waves(stream, MOTORWAY_WAVE_M);
        Self { verge_m, ditch_m: SLOPE_M, depth_m: GUTTER_DEPTH_M, field_m: MOTORWAY_FIELD_M, waves }
    }

    /// Distances from the carriageway at which the section bends.
    pub fn bends_m(&self) -> [f64; 4] {
        let bottom = [0.5 - DITCH_BOTTOM / 2.0, 0.5 + DITCH_BOTTOM / 2.0];
        [self.verge_m, self.verge_m + bottom[0] * self.ditch_m, self.verge_m + bottom[1] * self.ditch_m, self.reach_m()]
    }

    /// Where fields may begin.
    pub fn reach_m(&self) -> f64 {
        self.verge_m + self.ditch_m
    }

    /// From 0 to 1 over the plane.
    fn wave(&self, p: DVec2, from: usize) -> f64 {
        let sum: f64 = self.waves[from..from + 2].iter().map(|w| w.height_m(p)).sum();
        0.5 + 0.25 * sum
    }

    /// How deep the ditch is at a place: nothing over long stretches.
    pub fn depth_m(&self, p: DVec2) -> f64 {
        let share = ((self.wave(p, 0) - 0.35) * 4.0).clamp(0.0, 1.0);
        self.depth_m * share * share * (3.0 - 2.0 * share)
    }

    /// How far a field lies over the road.
    pub fn field_m(&self, p: DVec2) -> f64 {
        math::lerp(self.field_m.0, self.field_m.1, self.wave(p, 2))
    }

    /// Height over the road at a place `from_road_m` away from the carriageway.
    pub fn height_m(&self, p: DVec2, from_road_m: f64) -> f64 {
        if from_road_m <= self.verge_m {
            return -VERGE_SLOPE * from_road_m.max(0.0);
        }
        let across = ((from_road_m - self.verge_m) / self.ditch_m).min(1.0);
        let bank_m = math::lerp(-VERGE_SLOPE * self.verge_m, self.field_m(p), across);
        let dip = math::sin(PI * across);
        bank_m - self.depth_m(p) * dip * dip
    }
}

fn draw_waves(stream: &mut Stream, length_m: (f64, f64)) -> [Wave; 4] {
    std::array::from_fn(|_| Wave::new(stream, length_m, 1.0))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_section_is_a_verge_a_ditch_and_a_field() {
        for seed in 0..20 {
            let roadside = Roadside::new(&mut Stream::from_seed("roadside", seed), 1.3);
            let mut places = Stream::from_seed("places", seed);
            let (mut with_ditch, mut without) = (0, 0);
            for _ in 0..400 {
                let p = DVec2::new(places.range(-400.0, 400.0), places.range(-400.0, 400.0));
                let z = |d: f64| roadside.height_m(p, d);
                assert!(z(0.0) == 0.0 && (z(1.3) + 0.065).abs() < 1e-9, "{seed}");
                // Continuous, and flat behind the ditch.
                assert!(
                    (z(1.3 + 1e-9) - z(1.3)).abs() < 1e-6 && (z(20.0) - z(roadside.reach_m())).abs() < 1e-9,
                    "{seed}"
                );
                assert!((-0.25..=0.45).contains(&z(20.0)), "{seed}: {}", z(20.0));
                // In its middle a ditch lies by its depth below the line from verge to field.
                let middle = z(1.3 + roadside.ditch_m / 2.0);
                let line = (z(1.3) + z(20.0)) / 2.0;
                assert!((line - middle - roadside.depth_m(p)).abs() < 1e-9, "{seed}");
                with_ditch += usize::from(roadside.depth_m(p) > 0.25);
                without += usize::from(roadside.depth_m(p) < 0.03);
            }
            assert!(with_ditch > 80 && without > 40, "{seed}: {with_ditch} {without}");
        }
    }
}
