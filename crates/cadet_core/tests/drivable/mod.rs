//! Whether one can drive on a network's lanes.
#![allow(missing_docs)]

use cadet_core::math::{DVec3, atan2, wrap_angle};
use cadet_core::town::{Lane, RoadNetwork};

/// Share of driving lanes from which some way leads on for `distance_m`.
fn share_that_goes_on(network: &RoadNetwork, distance_m: f64) -> f64 {
    // The longest way that starts on each lane, grown until it exceeds the distance or stops growing.
    let length: Vec<f64> = network.lanes.iter().map(Lane::length_m).collect();
    let mut reach = length.clone();
    for _ in 0..2000 {
        let next: Vec<f64> = network
            .lanes
            .iter()
            .map(|l| length[l.id.0] + l.successors.iter().map(|n| reach[n.0]).fold(0.0, f64::max).min(distance_m))
            .collect();
        if next == reach {
            break;
        }
        reach = next;
    }
    let driving: Vec<f64> = network.driving().map(|l| reach[l.id.0]).collect();
    driving.iter().filter(|r| **r >= distance_m).count() as f64 / driving.len() as f64
}

/// The widest gap in meters and the sharpest kink in degrees between driving lanes that follow each other.
fn worst_joint(network: &RoadNetwork) -> (f64, f64) {
    let heading = |a: DVec3, b: DVec3| atan2(b.y - a.y, b.x - a.x);
    let mut worst = (0.0_f64, 0.0_f64);
    for lane in network.driving() {
        let n = lane.center.len();
        let end = heading(lane.center[n - 2], lane.center[n - 1]);
        let next = lane.successors.iter().map(|n| network.lane(*n));
        for next in next.filter(|n| n.kind == lane.kind) {
            let start = heading(next.center[0], next.center[1]);
            worst.0 = worst.0.max((lane.center[n - 1] - next.center[0]).length());
            worst.1 = worst.1.max(wrap_angle(end - start).abs().to_degrees());
        }
    }
    worst
}

/// Checks that lanes are smooth, joined both ways without gap or kink, and lead on.
pub fn assert_drivable(name: &str, network: &RoadNetwork) {
    for lane in &network.lanes {
        assert!(lane.center.len() >= 2, "{name}: lane {:?}", lane.id);
        for (i, pair) in lane.center.windows(2).enumerate() {
            let step = (pair[1] - pair[0]).length();
            assert!(step > 1e-4 && step <= 2.01, "{name}: lane {:?} has a step of {step} m", lane.id);
            assert!((lane.s_m[i + 1] - lane.s_m[i] - step).abs() < 1e-9);
        }
        for next in &lane.successors {
            assert!(network.lane(*next).predecessors.contains(&lane.id), "{name}: one-way link from {:?}", lane.id);
        }
        assert!(lane.speed_limit_mps > 1.0 && lane.speed_limit_mps < 60.0);
    }
    let (gap, kink) = worst_joint(network);
    assert!(gap < 0.05, "{name}: lanes meet {gap} m apart");
    assert!(kink < 5.0, "{name}: lanes meet at {kink} degrees");
    let share = share_that_goes_on(network, 1000.0);
    assert!(share >= 0.95, "{name}: only {share} of the lanes lead on for 1 km");
}
