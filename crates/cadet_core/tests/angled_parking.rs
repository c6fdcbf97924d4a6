//! Bays in which cars stand at an angle to the curb: in the map, on the ground, and the places to park in them.

#![allow(clippy::unwrap_used)]

use std::collections::BTreeMap;

use cadet_core::math::{DVec2, DVec3, atan2, wrap_angle};
use cadet_core::rng::StreamKey;
use cadet_core::town::{
    Ground, GroundKind, Lane, LaneKind, ParkingSpot, RoadNetwork, SpotKind, SuburbConfig, generate_suburb, load_map,
    parking_spots,
};

/// Wider than bays for cars along the curb.
const DEEP_M: f64 = 4.0;
/// A car of usual size.
const CAR_M: (f64, f64) = (4.2, 1.75);

fn town(seed: u64) -> (RoadNetwork, Ground, Vec<ParkingSpot>) {
    let config = SuburbConfig { angled_share: 1.0, parking_share: 0.8, ..SuburbConfig::default() };
    let key = StreamKey::scene(seed);
    let network = generate_suburb(&key, &config).unwrap().network;
    let ground = Ground::new(&network).unwrap();
    let mut spots = parking_spots(&network, &ground, &key);
    spots.retain(|s| s.kind == SpotKind::Angled);
    assert!(spots.len() > 40, "seed {seed}: {} spots", spots.len());
    (network, ground, spots)
}

fn parking(network: &RoadNetwork) -> impl Iterator<Item = &Lane> {
    network.lanes.iter().filter(|l| l.kind == LaneKind::Parking)
}

fn widest_m(lane: &Lane) -> f64 {
    lane.width_m.iter().copied().fold(0.0, f64::max)
}

fn at(spot: &ParkingSpot, x: f64, y: f64) -> DVec3 {
    spot.world_from_spot.transform_point(DVec3::new(x, y, 0.0))
}

fn corners(spot: &ParkingSpot) -> [DVec2; 4] {
    let (x, y) = (CAR_M.0 / 2.0, CAR_M.1 / 2.0);
    [(x, y), (-x, y), (-x, -y), (x, -y)].map(|(x, y)| at(spot, x, y).truncate())
}

#[test]
fn cars_at_an_angle_stand_in_the_bay_and_clear_of_the_lanes() {
    for seed in 0..4 {
        let (network, ground, spots) = town(seed);
        let driving: Vec<&Lane> = network.driving().collect();
        for spot in &spots {
            for (x, y) in [(1.3, 0.72), (1.3, -0.72), (-1.3, 0.72), (-1.3, -0.72), (0.0, 0.0)] {
                let wheel = at(spot, x, y);
                assert_eq!(ground.kind_at(wheel.x, wheel.y), Some(GroundKind::Road), "seed {seed}: {wheel}");
                let z = ground.height_at(wheel.x, wheel.y).unwrap();
                assert!((wheel.z - z).abs() < 0.04, "seed {seed}: {wheel} over {z}");
            }
            for corner in corners(spot) {
                let nearest = driving.iter().map(|l| l.project(corner.extend(spot.world_from_spot.translation.z)).1);
                let nearest = nearest.fold(f64::INFINITY, f64::min);
                assert!(nearest >= 1.25, "seed {seed}: {corner} is {nearest} m from the middle of a lane");
            }
        }
    }
}

#[test]
fn rows_stand_at_45_60_or_90_degrees_to_the_right_of_their_lane() {
    let mut rows: BTreeMap<i64, usize> = BTreeMap::new();
    for seed in 0..4 {
        let (network, _, spots) = town(seed);
        for spot in &spots {
            let place = spot.world_from_spot.translation;
            let nearest = |a: &&Lane, b: &&Lane| a.project(place).1.total_cmp(&b.project(place).1);
            let lane = parking(&network).filter(|l| widest_m(l) > DEEP_M).min_by(nearest).unwrap();
            let heading = |forward: DVec3| atan2(forward.y, forward.x);
            let along = heading(lane.pose_at(lane.project(place).0).rotation * DVec3::X);
            let to_the_right = -wrap_angle(heading(spot.world_from_spot.rotation * DVec3::X) - along).to_degrees();
            let drawn = [45.0, 60.0, 90.0].into_iter().find(|angle: &f64| (angle - to_the_right).abs() < 5.0);
            let drawn = drawn.unwrap_or_else(|| panic!("seed {seed}: {to_the_right} degrees at {place}"));
            *rows.entry(drawn as i64).or_default() += 1;
        }
    }
    assert_eq!(rows.len(), 3, "{rows:?}");
}

/// Whether two convex outlines overlap (separating axes).
fn overlap(a: &[DVec2; 4], b: &[DVec2; 4]) -> bool {
    let reach = |of: &[DVec2; 4], axis: DVec2| {
        let along = of.map(|p| p.dot(axis));
        (along.into_iter().fold(f64::INFINITY, f64::min), along.into_iter().fold(f64::NEG_INFINITY, f64::max))
    };
    ![a[1] - a[0], a[2] - a[1], b[1] - b[0], b[2] - b[1]].into_iter().any(|axis| {
        let ((a0, a1), (b0, b1)) = (reach(a, axis), reach(b, axis));
        a1 < b0 || b1 < a0
    })
}

#[test]
fn neighbors_do_not_overlap() {
    for seed in 0..6 {
        let (_, _, spots) = town(seed);
        let cars: Vec<[DVec2; 4]> = spots.iter().map(corners).collect();
        for (i, a) in cars.iter().enumerate() {
            for b in cars[..i].iter().filter(|b| (b[0] - a[0]).length() < 12.0) {
                assert!(!overlap(a, b), "seed {seed}: {a:?} {b:?}");
            }
        }
    }
}

/// Streets with bays, and those of them with deep ones.
fn streets(network: &RoadNetwork) -> (usize, usize) {
    let mut widest: BTreeMap<u32, f64> = BTreeMap::new();
    for lane in parking(network) {
        let widest = widest.entry(lane.road).or_default();
        *widest = widest.max(widest_m(lane));
    }
    (widest.len(), widest.values().filter(|w| **w > DEEP_M).count())
}

#[test]
fn the_share_of_streets_with_deep_bays_is_what_was_asked_for() {
    for (angled_share, tolerance) in [(0.0, 0.0), (0.3, 0.1), (1.0, 0.0)] {
        let (mut all, mut deep, mut suburbs) = (0, 0, 0);
        for seed in 0..20 {
            let config = SuburbConfig { angled_share, ..SuburbConfig::default() };
            let (a, d) = streets(&generate_suburb(&StreamKey::scene(seed), &config).unwrap().network);
            (all, deep, suburbs) = (all + a, deep + d, suburbs + usize::from(d > 0));
        }
        let share = f64::from(deep as u32) / f64::from(all as u32);
        assert!(all > 150 && (share - angled_share).abs() <= tolerance, "{deep} of {all} for {angled_share}");
        assert!(angled_share == 0.0 || suburbs > 15, "{suburbs} suburbs of 20 have some");
    }
    let error = generate_suburb(&StreamKey::scene(0), &SuburbConfig { angled_share: 1.5, ..SuburbConfig::default() });
    assert!(error.unwrap_err().to_string().contains("angled_share"));
}

#[test]
fn deep_bays_survive_opendrive() {
    let config = SuburbConfig { angled_share: 1.0, ..SuburbConfig::default() };
    let suburb = generate_suburb(&StreamKey::scene(1), &config).unwrap();
    let again = load_map("again", &suburb.xodr).unwrap();
    assert_eq!(again.lanes.len(), suburb.network.lanes.len());
    let mut deep = 0;
    for (a, b) in again.lanes.iter().zip(&suburb.network.lanes) {
        assert_eq!((a.kind, &a.width_m, &a.center), (b.kind, &b.width_m, &b.center));
        if a.kind == LaneKind::Parking && widest_m(a) > DEEP_M {
            // 5.5 m between the tapers, from the document's text.
            assert!((widest_m(a) - 5.5).abs() < 1e-6, "{}", widest_m(a));
            deep += 1;
        }
    }
    assert!(deep > 5, "{deep}");
}
