//! Generated scans in fog, rain and snow, beam by beam against the same scan in clear air.
#![allow(missing_docs)]

mod common;

use std::collections::BTreeMap;
use std::sync::Arc;

use common::{at, cuboid, place, posed};

use cadet_core::lidar::{LidarSpec, Receiver, Scan, ideal_scan, scan, weather_recorded};
use cadet_core::math::{self, DPose3, PI, Vec3};
use cadet_core::rng::Stream;
use cadet_core::sense::PosedScene;
use cadet_core::weather::Weather;

/// Walls all around, one behind the other: ranges from 5 m to 75 m, and sky above.
fn yard() -> Arc<PosedScene> {
    let mut instances = vec![place(cuboid(Vec3::new(120.0, 120.0, 0.5)), at(0.0, 0.0, -2.23), 0)];
    for k in 0..15 {
        let distance = 6.0 + 4.7 * f64::from(k);
        let (x, y) = (distance * math::cos(f64::from(k) * 0.41), distance * math::sin(f64::from(k) * 0.41));
        let half_m = (0.18 * distance) as f32;
        instances.push(place(cuboid(Vec3::new(half_m, half_m, 1.0 + 0.02 * half_m)), at(x, y, -0.7), k + 1));
    }
    posed(&instances)
}

/// Beams that are lines, so that each meets one target or none.
fn thin_beams() -> LidarSpec {
    LidarSpec::hdl64e_uniform().with_divergence(0.0).expect("valid")
}

fn run(weather: &Weather, seed: u64) -> Scan {
    let spec = thin_beams();
    scan(&yard(), &DPose3::IDENTITY, &spec, weather, &mut Stream::from_seed("scan", seed)).expect("valid")
}

fn preset(name: &str) -> Weather {
    Weather::preset(name).expect("exists")
}

/// Range, intensity and actor of each beam that returned.
fn beams(scan: &Scan) -> BTreeMap<(i32, i32), (f64, f32, i32)> {
    (0..scan.ring.len())
        .map(|i| ((scan.ring[i], scan.column[i]), (scan.range_m[i], scan.points_velo[i][3], scan.actor_id[i])))
        .collect()
}

/// Where fog's own echo is as strong as a hard target's: exp(-2 alpha R) = R^2 beta / beta0 max I, by bisection, with
/// I(R) of Hahner et al. (2021) summed in time for a pulse of 5 ns.
fn crossing_m(alpha: f64) -> f64 {
    let (c, tau, n) = (299_792_458.0, 5e-9, 4000);
    let dt = 2.0 * tau / f64::from(n);
    let response = |range_m: f64| -> f64 {
        let slice = |i: i32| {
            let t = (f64::from(i) + 0.5) * dt;
            let r = range_m - c * t / 2.0;
            let s = math::sin(PI * t / (2.0 * tau));
            let xi = ((r - 0.9) / 0.1).clamp(0.0, 1.0);
            if r > 0.9 { s * s * math::exp(-2.0 * alpha * r) * xi / (r * r) * dt } else { 0.0 }
        };
        (0..n).map(slice).sum()
    };
    let best = (0..300).map(|k| response(0.9 + 0.02 * f64::from(k))).fold(0.0, f64::max);
    let scale = 0.046 * alpha / math::ln(20.0) / (0.596e-6 / PI) * best;
    let (mut lo, mut hi) = (5.0, 200.0);
    for _ in 0..60 {
        let middle = 0.5 * (lo + hi);
        if math::exp(-2.0 * alpha * middle) > scale * middle * middle { lo = middle } else { hi = middle }
    }
    lo
}

#[test]
fn dense_fog_shortens_a_scan_as_the_formula_says() {
    let crossing_m = crossing_m(0.06);
    assert!((30.0..40.0).contains(&crossing_m), "{crossing_m}");
    let (clear, fog) = (beams(&run(&preset("clear_noon"), 3)), beams(&run(&preset("dense_fog"), 3)));
    let (mut moved, mut kept_near, mut near, mut kept_middle, mut middle) = (0, 0, 0, 0, 0);
    for (beam, (range_m, intensity, actor_id)) in &clear {
        let after = fog.get(beam);
        if *range_m > crossing_m + 0.2 {
            let (to_m, _, whose) = *after.expect("fog returns where something was detected");
            assert!((2.0..10.0).contains(&to_m) && whose == 0, "{range_m} {to_m}");
            moved += 1;
        } else if *range_m < crossing_m - 0.2 {
            if let Some((same_m, weaker, whose)) = after {
                assert!((same_m - range_m).abs() < 0.1 && whose == actor_id, "{range_m} {same_m}");
                assert!(*weaker <= intensity + 0.02, "{weaker} {intensity}");
            }
            let is_kept = i32::from(after.is_some());
            if *range_m < 8.0 {
                (near, kept_near) = (near + 1, kept_near + is_kept);
            } else if *range_m > 25.0 {
                (middle, kept_middle) = (middle + 1, kept_middle + is_kept);
            }
        }
    }
    // Fog makes no sky return anything: what is new had its target beyond the longest range that is written.
    let ideal = ideal_scan(&yard(), &DPose3::IDENTITY, &thin_beams());
    let columns = thin_beams().azimuths_rad().len();
    for (ring, column) in fog.keys().filter(|beam| !clear.contains_key(*beam)) {
        let target_m = ideal.range_m[*ring as usize * columns + *column as usize];
        assert!((79.5..200.0).contains(&target_m), "{target_m}");
    }
    assert!(moved > 500 && near > 10_000 && middle > 1000, "{moved} {near} {middle}");
    assert!(f64::from(kept_near) > 0.98 * f64::from(near), "{kept_near} of {near}");
    assert!(f64::from(kept_middle) < 0.4 * f64::from(middle), "{kept_middle} of {middle}");
}

#[test]
fn a_weather_without_a_rate_is_clear() {
    let clear = run(&preset("clear_noon"), 5);
    for weather in [
        Weather::of_air(0.0, 0.0, 0.0, 0.0).expect("valid"),
        Weather { rain_mm_per_h: 0.0, wetness: 0.0, ..preset("hard_rain_noon") },
        Weather { fog_alpha_per_m: 0.0, ..preset("dense_fog") },
        Weather { snow_mm_per_h: 0.0, ..preset("snow") },
    ] {
        assert_eq!(run(&weather, 5), clear);
    }
}

#[test]
fn drops_and_flakes_answer_before_what_they_hide() {
    let clear = beams(&run(&preset("clear_noon"), 1));
    for (weather, furthest_m, at_least) in
        [(Weather { wetness: 0.0, ..preset("hard_rain_noon") }, 7.0, 200), (preset("snow"), 20.0, 1500)]
    {
        let mut returns = 0;
        for (beam, (range_m, _, actor_id)) in &beams(&run(&weather, 1)) {
            let before = clear.get(beam);
            if before.is_some_and(|(clear_m, _, _)| (range_m - clear_m).abs() < 0.3) {
                continue;
            }
            returns += 1;
            // Fallen snow shows ground that was too dark before; all else is in the air.
            let is_new_ground = before.is_none() && *range_m > furthest_m;
            let limit_m = before.map_or(furthest_m, |(clear_m, _, _)| clear_m.min(furthest_m));
            assert!(*actor_id == 0 && (*range_m < limit_m || is_new_ground), "{} {range_m} {before:?}", weather.name);
        }
        assert!(returns > at_least, "{}: {returns}", weather.name);
    }
}

#[test]
fn a_clear_scan_in_recorded_fog_is_as_short_as_a_generated_one() {
    let clear = run(&preset("clear_noon"), 2);
    let receiver = Receiver::default();
    let weathered = weather_recorded(&clear.points_velo, &preset("dense_fog"), &receiver, 1.73, 0).expect("valid");
    assert_eq!(weathered.points_velo.len(), clear.points_velo.len());
    let range_m = |p: &[f32; 4]| p[..3].iter().map(|v| f64::from(*v) * f64::from(*v)).sum::<f64>().sqrt();
    let crossing_m = crossing_m(0.06);
    for (before, after) in clear.points_velo.iter().zip(&weathered.points_velo) {
        let (before_m, after_m) = (range_m(before), range_m(after));
        if (before_m - crossing_m).abs() > 0.1 {
            assert_eq!(after_m < before_m - 1.0, before_m > crossing_m, "{before_m} {after_m}");
        }
    }
}

#[test]
fn what_weather_returns_follows_from_the_sensors_receiver() {
    let usual = Receiver::default();
    let in_air = |weather: &Weather, spec: LidarSpec| {
        let got = scan(&yard(), &DPose3::IDENTITY, &spec, weather, &mut Stream::from_seed("scan", 1)).expect("valid");
        // The nearest ground is 4.09 m away.
        got.range_m.iter().zip(&got.actor_id).filter(|(r, a)| **a == 0 && **r < 3.9).count()
    };
    let with = |receiver| thin_beams().with_receiver(receiver).expect("valid");
    let rain = Weather { wetness: 0.0, ..preset("hard_rain_noon") };
    let (drops, flakes) = (in_air(&rain, with(usual)), in_air(&preset("snow"), with(usual)));
    assert!(drops > 300 && flakes > 1000, "{drops} {flakes}");
    // A beam of a quarter of the width has a sixteenth of the volume, and drops in it are 16 times as bright.
    let narrow = Receiver { divergence_rad: 0.5e-3, ..usual };
    let split = thin_beams().with_divergence(0.5e-3).expect("valid");
    assert!(in_air(&rain, with(narrow)) < drops / 2, "{} {drops}", in_air(&rain, with(narrow)));
    assert!(in_air(&rain, split) < drops / 2);
    let deaf = Receiver { threshold: 16.0 * usual.threshold, ..usual };
    let detected = [in_air(&rain, with(deaf)), in_air(&preset("snow"), with(deaf))];
    assert!(4 * detected[0] < 3 * drops && detected[1] < flakes, "{detected:?} of {drops} and {flakes}");
    // And recorded scans: less is lost by an ear that is as good as the scan's own.
    let clear = run(&preset("clear_noon"), 2);
    let left =
        |receiver| weather_recorded(&clear.points_velo, &rain, &receiver, 1.73, 0).expect("valid").points_velo.len();
    assert!(left(deaf) != left(usual) && left(narrow) != left(usual));
}
