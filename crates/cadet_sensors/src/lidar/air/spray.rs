//! What spray behind vehicles does to a beam: it dims what is behind it, and returns some of the light itself, as fog does
//! ([`super::aerosol`]).

use super::aerosol::{clump, reflectance_m};
use super::air_echo::{AirEcho, FAINTEST_SHARE};
use crate::lidar::Receiver;
use crate::lidar::detection::focused;
use crate::spray::{Plume, Spray};
use cadet_base::math::{self, DVec3};
use cadet_base::rng::CounterRng;

/// Steps along a beam's way through a plume: their length, and how many at least and at most.
const STEP_M: f64 = 1.0;
const MIN_STEPS: f64 = 2.0;
const MAX_STEPS: f64 = 10.0;
/// Spray as thin as this returns nothing, 1/m.
const THIN_PER_M: f64 = 0.003;
/// Plumes that are farther from the sensor are left out: they return nothing, and hardly anything that they hide returns.
const REACH_M: f64 = 70.0;
/// Makes a key of a beam's own.
const SALT: u64 = 0x5f3a_91c4_d20b_7e65;

/// The plumes about a sensor, near ones first.
#[derive(Debug, Clone)]
pub(crate) struct Plumes<'a> {
    plumes: Vec<NearPlume<'a>>,
    /// Reflectance of a diffuse surface that returns as much as spray of an extinction of 1/m.
    reflectance_m: f64,
    /// Echoes weaker than this are not detected.
    least_power: f64,
}

/// A plume and a ball about it.
#[derive(Debug, Clone)]
struct NearPlume<'a> {
    plume: &'a Plume,
    center_world: DVec3,
    radius_m: f64,
}

/// What becomes of a beam in spray.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Sprayed {
    /// Power that is left of an echo from behind.
    pub transmittance: f64,
    /// The spray's own echo.
    pub echo: Option<AirEcho>,
}

impl Sprayed {
    /// A beam that meets none.
    pub(crate) const NOT: Self = Self { transmittance: 1.0, echo: None };
}

impl<'a> Plumes<'a> {
    pub(crate) fn about(spray: &'a Spray, sensor_world: DVec3, receiver: &Receiver) -> Self {
        let ball = |plume: &'a Plume| {
            let [low, high] = plume.bounds();
            let center_world = *plume.world_from_plume() * (0.5 * (low + high)).as_dvec3();
            NearPlume { plume, center_world, radius_m: f64::from(0.5 * (high - low).length()) }
        };
        let distance_m = |near: &NearPlume<'_>| (near.center_world - sensor_world).length();
        let mut plumes: Vec<_> = spray.plumes().iter().map(ball).filter(|p| distance_m(p) < REACH_M).collect();
        plumes.sort_by(|a, b| distance_m(a).total_cmp(&distance_m(b)));
        Self { plumes, reflectance_m: reflectance_m(receiver), least_power: FAINTEST_SHARE * receiver.threshold() }
    }

    #[inline]
    pub(crate) fn is_empty(&self) -> bool {
        self.plumes.is_empty()
    }

    /// What becomes of a beam of a laser of that focus up to its target, which may be infinitely far; `key` names the beam.
    pub(crate) fn meet(
        &self,
        origin_world: DVec3,
        direction_world: DVec3,
        range_m: f64,
        focus_m: f64,
        key: u64,
    ) -> Sprayed {
        let mut met = Sprayed::NOT;
        let mut depth = 0.0;
        for NearPlume { plume, center_world, radius_m } in &self.plumes {
            let to_center = *center_world - origin_world;
            let along = to_center.dot(direction_world);
            let aside2 = to_center.dot(to_center) - along * along;
            if aside2 > radius_m * radius_m || along < -radius_m || along - radius_m > range_m {
                continue;
            }
            let from = (*plume.plume_from_world() * origin_world).as_vec3();
            let direction = (plume.plume_from_world().rotation * direction_world).as_vec3();
            let Some([enters, leaves]) = plume.crossing(from, direction, range_m as f32) else { continue };
            let way_m = f64::from(leaves - enters);
            let steps = (way_m / STEP_M).ceil().clamp(MIN_STEPS, MAX_STEPS);
            let step_m = way_m / steps;
            let mut rng = CounterRng::new(key ^ SALT);
            for k in 0..steps as usize {
                let at_m = f64::from(enters) + (k as f64 + rng.unit()) * step_m;
                let extinction = f64::from(plume.extinction_per_m(from + direction * at_m as f32));
                if extinction > THIN_PER_M {
                    let mean = self.reflectance_m * extinction / (at_m * at_m);
                    let open = mean * clump(&mut rng) * focused(focus_m, at_m);
                    if open > met.echo.map_or(self.least_power, |strongest| strongest.power) {
                        let power = open * math::exp(-2.0 * depth - extinction * step_m);
                        if met.echo.is_none_or(|strongest| power > strongest.power) {
                            met.echo = Some(AirEcho { range_m: at_m, power });
                        }
                    }
                }
                depth += extinction * step_m;
            }
        }
        if depth > 0.0 {
            met.transmittance = math::exp(-2.0 * depth);
        }
        met
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::spray::tests::{CAR_M, depth, smooth};
    use cadet_base::actor::ObjectClass;
    use cadet_base::math::{PI, Vec3};

    #[test]
    fn a_target_is_dimmed_by_twice_the_depth_before_it() {
        let spray = smooth(ObjectClass::Car, CAR_M, 25.0);
        let sensor = DVec3::new(-25.0, 0.2, 1.73);
        let plumes = Plumes::about(&spray, sensor, &Receiver::default());
        for (at, range_m) in [(DVec3::new(0.0, 0.1, 0.5), 60.0), (DVec3::new(-8.0, 0.0, 0.2), f64::INFINITY)] {
            let direction = (at - sensor).normalize();
            let (from, end) = (sensor.as_vec3(), range_m as f32);
            let expected = math::exp(-2.0 * depth(&spray.plumes()[0], from, direction.as_vec3(), end.min(1e3)));
            let mean = (0..400).map(|key| plumes.meet(sensor, direction, range_m, 6.0, key).transmittance).sum::<f64>()
                / 400.0;
            assert!((mean - expected).abs() < 0.01 && expected < 0.85, "{mean} {expected}");
        }
        // Before the plume, beside it, and behind the sensor there is nothing.
        let ahead = plumes.meet(sensor, DVec3::X, 9.0, 6.0, 1);
        let aside = plumes.meet(sensor, DVec3::Y, f64::INFINITY, 6.0, 1);
        assert_eq!([ahead, aside, plumes.meet(sensor, DVec3::NEG_X, 90.0, 6.0, 1)], [Sprayed::NOT; 3]);
    }

    #[test]
    fn spray_returns_within_ten_meters_behind_the_car_as_strongly_as_its_drops_scatter() {
        let spray = smooth(ObjectClass::Car, CAR_M, 25.0);
        let receiver = Receiver::default();
        let sensor = DVec3::new(-16.0, 0.0, 1.0);
        let plumes = Plumes::about(&spray, sensor, &receiver);
        let direction = (DVec3::new(-1.5, 0.0, 0.4) - sensor).normalize();
        let (mut near, mut far, mut most) = (0, 0, 0.0_f64);
        for key in 0..2000 {
            let echo = plumes.meet(sensor, direction, f64::INFINITY, 6.0, key).echo;
            let Some(AirEcho { range_m: at_m, power }) = echo else { continue };
            let behind_m = -(sensor + direction * at_m).x;
            if receiver.detects(power, 0.5) {
                near += usize::from(behind_m < 10.0);
                far += usize::from(behind_m >= 10.0);
            }
            let extinction = spray.plumes()[0].extinction_per_m((sensor + direction * at_m).as_vec3());
            most = most.max(power * at_m * at_m / f64::from(extinction));
        }
        assert!(near > 200 && near > 4 * far, "{near} {far}");
        // pi * 0.749 m / 18 sr times the largest of some 10,000 exponential numbers.
        let mean = PI * 0.7495 / 18.0;
        assert!((4.0 * mean..12.0 * mean).contains(&most), "{most}");
        assert_eq!(spray.plumes()[0].extinction_per_m(Vec3::new(1.0, 0.0, 0.1)), 0.0);
    }
}
