//! Beams that open, at edges whose place is known.
#![allow(missing_docs)]

mod common;

use std::sync::Arc;

use cadet_core::lidar::{LidarSpec, Receiver, ReturnMode, Scan, scan};
use cadet_core::math::{self, DPose3, TAU, Vec3};
use cadet_core::rng::Stream;
use cadet_core::sense::{LaserRing, PosedScene};
use cadet_core::weather::Weather;
use common::{at, cuboid, place, posed, sphere};

const DIVERGENCE_RAD: f64 = 3e-3;

fn turn(scene: &PosedScene, spec: &LidarSpec) -> Scan {
    let weather = Weather::preset("clear_noon").expect("exists");
    scan(scene, &DPose3::IDENTITY, spec, &weather, &mut Stream::from_seed("scan", 0)).expect("valid")
}

/// Beams 0.02 mrad apart that sweep over what lies ahead, and one that looks behind.
fn fine_sweep() -> LidarSpec {
    let ring = LaserRing::on_axis(0.0, 0.0);
    let azimuths = (0..400).map(|i| 1e-3 + 2e-5 * f64::from(i)).chain([3.0]).collect();
    let spec = LidarSpec::new("sweep", vec![ring], azimuths).expect("valid");
    let silent = Receiver { range_noise_m: 0.0, ..*spec.receiver() };
    spec.with_receiver(silent).and_then(|s| s.with_divergence(DIVERGENCE_RAD)).expect("valid")
}

/// Two walls; the near one ends at the azimuth 5 mrad and has the actor id 1, the far one 2.
fn two_walls(near_m: f64, far_m: f64) -> Arc<PosedScene> {
    let (thick, end) = (0.05_f32, 5e-3 * near_m);
    let half = Vec3::new(thick, 4.0, 4.0);
    let wall = |x: f64, y: f64, id| place(cuboid(half), at(x + f64::from(thick), y, 0.0), id);
    posed(&[wall(near_m, end - 4.0, 1), wall(far_m, 3.0, 2)])
}

#[test]
fn a_half_covered_beam_reports_what_its_shares_say() {
    let scene = two_walls(10.0, 20.0);
    let mut spec = fine_sweep();
    let azimuths = spec.azimuths_rad().to_vec();
    let mut check = |mode: ReturnMode| {
        spec.returns = mode;
        let got = turn(&scene, &spec);
        assert!(got.ring.len() >= 395, "{}", got.ring.len());
        for i in 0..got.ring.len() {
            // From the edge, in radii of the spot; the sub-beams stand at half of it.
            let u = (azimuths[got.column[i] as usize] - 5e-3) / (DIVERGENCE_RAD / 2.0);
            // Half of the near wall's echo is four times half of the far one's.
            let id = match mode {
                ReturnMode::Strongest => 1 + i32::from(u > 0.5),
                _ => 1 + i32::from(u > -0.5),
            };
            if (u.abs() - 0.5).abs() > 0.02 {
                assert_eq!(got.actor_id[i], id, "{u} {mode:?}");
            }
            let expected_m = if got.actor_id[i] == 1 { 10.0 } else { 20.0 };
            assert!((got.range_m[i] - expected_m).abs() < 2e-3, "{u} {}", got.range_m[i]);
        }
    };
    check(ReturnMode::Strongest);
    check(ReturnMode::Last);
}

#[test]
fn walls_within_a_pulse_of_each_other_mix() {
    let (near_m, far_m) = (10.0, 10.5);
    let spec = fine_sweep();
    let got = turn(&two_walls(near_m, far_m), &spec);
    let powers = [near_m, far_m].map(|r| 1.0 / (r * r));
    let mixed_m = (powers[0] * near_m + powers[1] * far_m) / (powers[0] + powers[1]);
    let mut mixed = 0;
    for i in 0..got.ring.len() {
        let u = (spec.azimuths_rad()[got.column[i] as usize] - 5e-3) / (DIVERGENCE_RAD / 2.0);
        let expected_m = match u {
            u if u < -0.52 => near_m,
            u if u > 0.52 => far_m,
            u if u.abs() < 0.48 => mixed_m,
            _ => continue,
        };
        mixed += usize::from(expected_m == mixed_m);
        // The two faces are seen straight on: their echoes differ by range alone.
        assert!((got.range_m[i] - expected_m).abs() < 2e-3, "{u}: {} {expected_m}", got.range_m[i]);
    }
    assert!(mixed > 60, "{mixed}");
}

#[test]
fn away_from_edges_nothing_changes() {
    // Inside of a globe there are no edges.
    let globe = posed(&[place(sphere(30.0, 60), at(1.0, 2.0, 0.5), 1)]);
    let wide = LidarSpec::hdl64e_kitti().with_divergence(DIVERGENCE_RAD).expect("valid");
    // As wide for the receiver, but split nowhere.
    let narrow = wide.clone().with_divergence(0.0).expect("valid");
    let scanned = turn(&globe, &narrow);
    assert!(scanned.ring.len() > 100_000);
    assert_eq!(scanned, turn(&globe, &wide));
    // Posts in it have edges: points beside them move from one side to the other, the others stay.
    let post = |k: u32| {
        let azimuth = f64::from(k) * TAU / 40.0;
        let place_m = at(15.0 * math::cos(azimuth), 15.0 * math::sin(azimuth), 0.0);
        place(cuboid(Vec3::new(0.05, 0.05, 3.0)), place_m, 2)
    };
    let mut instances: Vec<_> = (0..40).map(post).collect();
    instances.push(place(sphere(30.0, 60), at(0.0, 0.0, 0.0), 1));
    let scene = posed(&instances);
    let (lines, cones) = (turn(&scene, &narrow), turn(&scene, &wide));
    let by_beam = |s: &Scan| -> std::collections::BTreeMap<(i32, i32), f64> {
        (0..s.ring.len()).map(|i| ((s.ring[i], s.column[i]), s.range_m[i])).collect()
    };
    let (lines, cones) = (by_beam(&lines), by_beam(&cones));
    let moved = cones.iter().filter(|(beam, r)| lines.get(beam).is_none_or(|q| (*q - **r).abs() > 0.05)).count();
    let share = moved as f64 / cones.len() as f64;
    assert!((1e-3..0.05).contains(&share), "{share}");
}

#[test]
fn impossible_divergences_are_refused() {
    let text = |d: f64| LidarSpec::cadet().with_divergence(d).expect_err("bad").to_string();
    assert!(text(-1e-3).contains("divergence is -0.001"), "{}", text(-1e-3));
    assert!(text(0.5).contains("divergence is 0.5") && text(f64::NAN).contains("divergence"));
    assert!(ReturnMode::from_name("loudest").expect_err("unknown").to_string().contains("strongest, last"));
    let spec = LidarSpec::hdl64e_kitti().with_divergence(2e-3).expect("valid").single_origin();
    assert!((spec.receiver().divergence_rad - 2e-3).abs() < 1e-15);
}
