//! Generated scans in fog, rain and snow, beam by beam against the same scan in clear air.
#![allow(missing_docs)]

mod common;

use std::collections::BTreeMap;
use std::sync::Arc;

use common::{at, cuboid, place, posed};

use cadet_core::lidar::{LidarSpec, Receiver, Scan, scan, weather_recorded};
use cadet_core::math::{self, DPose3, Vec3};
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

/// Those beams, seen by optics that lose nothing of what is near.
fn near_sighted() -> LidarSpec {
    let mut spec = thin_beams();
    spec.laser_receivers.iter_mut().for_each(|laser| laser.focus_m = 0.0);
    spec
}

fn run(weather: &Weather, seed: u64) -> Scan {
    run_of(&thin_beams(), weather, seed)
}

fn run_of(spec: &LidarSpec, weather: &Weather, seed: u64) -> Scan {
    scan(&yard(), &DPose3::IDENTITY, spec, weather, &mut Stream::from_seed("scan", seed)).expect("valid")
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

#[test]
fn dense_fog_dims_what_is_near_and_takes_the_place_of_what_is_far() {
    let (clear, fog) = (beams(&run(&preset("clear_noon"), 3)), beams(&run(&preset("dense_fog"), 3)));
    let (mut near, mut kept_near, mut far, mut kept_far) = (0, 0, 0, 0);
    for (beam, (range_m, intensity, actor_id)) in &clear {
        let same = fog.get(beam).filter(|(same_m, ..)| (same_m - range_m).abs() < 0.1);
        if let Some((_, weaker, whose)) = same {
            assert!(*weaker <= intensity + 0.02 && whose == actor_id, "{weaker} {intensity}");
        }
        let is_kept = i32::from(same.is_some());
        // exp(-0.12 * 40) / 40^2 of a third of white is a fifteenth of what is detected.
        if *range_m < 8.0 {
            (near, kept_near) = (near + 1, kept_near + is_kept);
        } else if *range_m > 40.0 {
            (far, kept_far) = (far + 1, kept_far + is_kept);
        }
    }
    assert!(near > 10_000 && far > 500, "{near} {far}");
    assert!(kept_near * 100 > 98 * near && kept_far == 0, "{kept_near} of {near}, {kept_far} of {far}");
    // What fog returns lies before all else, about where the lower lasers are focused; beams to the sky return it too.
    let in_fog = fog.iter().filter(|(beam, (range_m, _, actor_id))| {
        *actor_id == 0 && clear.get(beam).is_none_or(|(clear_m, ..)| (clear_m - range_m).abs() > 0.3)
    });
    let ranges: Vec<f64> = in_fog.map(|(_, (range_m, ..))| *range_m).collect();
    assert!(ranges.len() > 200 && ranges.iter().all(|m| *m < 25.0), "{}", ranges.len());
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
    let clear = beams(&run_of(&near_sighted(), &preset("clear_noon"), 1));
    for (weather, furthest_m, at_least) in
        [(Weather { wetness: 0.0, ..preset("hard_rain_noon") }, 9.0, 200), (preset("snow"), 20.0, 1500)]
    {
        let mut returns = 0;
        for (beam, (range_m, _, actor_id)) in &beams(&run_of(&near_sighted(), &weather, 1)) {
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
    let farthest_m = |points: &[[f32; 4]]| {
        let ranges = points.iter().map(|p| p[..3].iter().map(|v| f64::from(*v) * f64::from(*v)).sum::<f64>().sqrt());
        let mut ranges: Vec<f64> = ranges.collect();
        ranges.sort_by(f64::total_cmp);
        ranges[ranges.len() * 999 / 1000]
    };
    let generated = farthest_m(&run(&preset("dense_fog"), 2).points_velo);
    let recorded = farthest_m(&weathered.points_velo);
    // What reads 0 is taken for as weak as can be detected.
    assert!((15.0..=generated).contains(&recorded) && generated < 32.0, "{generated} {recorded}");
}

#[test]
fn what_weather_returns_follows_from_the_sensors_receiver() {
    let usual = Receiver::default();
    let in_air = |weather: &Weather, spec: LidarSpec| {
        let got = scan(&yard(), &DPose3::IDENTITY, &spec, weather, &mut Stream::from_seed("scan", 1)).expect("valid");
        // The nearest ground is 4.09 m away.
        got.range_m.iter().zip(&got.actor_id).filter(|(r, a)| **a == 0 && **r < 3.9).count()
    };
    let with = |receiver| near_sighted().with_receiver(receiver).expect("valid");
    let rain = Weather { wetness: 0.0, ..preset("hard_rain_noon") };
    let (drops, flakes) = (in_air(&rain, with(usual)), in_air(&preset("snow"), with(usual)));
    assert!(drops > 300 && flakes > 1000, "{drops} {flakes}");
    // A beam of a quarter of the width has a sixteenth of the volume, and drops in it are 16 times as bright.
    let narrow = Receiver { divergence_rad: 0.5e-3, ..usual };
    let split = near_sighted().with_divergence(0.5e-3).expect("valid");
    assert!(in_air(&rain, with(narrow)) < drops / 2, "{} {drops}", in_air(&rain, with(narrow)));
    assert!(in_air(&rain, split) < drops / 2);
    let deaf = Receiver { detection_range_m: 0.25 * usual.detection_range_m, ..usual };
    let detected = [in_air(&rain, with(deaf)), in_air(&preset("snow"), with(deaf))];
    assert!(4 * detected[0] < 3 * drops && detected[1] < flakes, "{detected:?} of {drops} and {flakes}");
    // And recorded scans: less is lost by an ear that is as good as the scan's own.
    let clear = run(&preset("clear_noon"), 2);
    let left =
        |receiver| weather_recorded(&clear.points_velo, &rain, &receiver, 1.73, 0).expect("valid").points_velo.len();
    assert!(left(deaf) != left(usual) && left(narrow) != left(usual));
}
