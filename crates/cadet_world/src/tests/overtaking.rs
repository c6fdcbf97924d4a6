//! Cyclists are overtaken where there is room and time, and nowhere else.

use super::towns::{ground, lane, line, town};
use super::*;
use cadet_town::{RoadNetwork, Town};

const RIDER_MPS: f64 = 4.0;

/// A straight road along x of 500 m, one lane of 3 m a direction.
fn straight_road() -> Arc<Town> {
    let flat = |_: f64, _: f64| 0.0;
    let mut network = RoadNetwork::default();
    for (from_x, y) in [(-250.0, -1.5), (250.0, 1.5)] {
        lane(&mut network, &line(DVec2::new(from_x, y), DVec2::new(-from_x, y)), None, &flat);
    }
    town(network, ground(260.0, 10.0, &flat), Vec::new())
}

/// The ego, and a cyclist 25 m ahead of it who rides 1 m from the right border.
fn behind_a_cyclist() -> (World, i32) {
    let mut world = with_ego_at(straight_road(), 1, [-230.0, -1.5, 0.0]);
    let course = Course::Straight { x_m: -205.0, y_m: -2.0, yaw_rad: 0.0, speed_mps: RIDER_MPS };
    let id = put(&mut world, ObjectClass::Cyclist, 5, &course);
    world.drive(0.1, 5.0).unwrap();
    (world, id)
}

/// Ego and another agent, by what they cover.
fn pair(world: &World, id: i32) -> (Footprint, Footprint) {
    let other = world.arena.agents.iter().find(|a| a.id == id).expect("is there");
    (footprint(world, world.arena.ego()), footprint(world, other))
}

/// Drives for some seconds; returns when and at which x the ego was first wholly ahead of the cyclist, and the least
/// room beside it.
fn passes(world: &mut World, rider: i32, others: &[i32], seconds: u32) -> (Option<(f64, f64)>, f64) {
    let (mut passed, mut least_m) = (None, f64::INFINITY);
    for _ in 0..seconds * 10 {
        world.step(6);
        let (ego, cyclist) = pair(world, rider);
        for other in others {
            assert!(!ego.overlaps(&pair(world, *other).1), "at {}", ego.center);
        }
        let ahead_m = ego.center.x - cyclist.center.x;
        let lengths_m = ego.half_length_m + cyclist.half_length_m;
        if ahead_m.abs() < lengths_m {
            let beside_m = (ego.center.y - cyclist.center.y).abs() - ego.half_width_m - cyclist.half_width_m;
            least_m = least_m.min(beside_m);
        } else if ahead_m > lengths_m && passed.is_none() {
            passed = Some((world.time_s(), ego.center.x));
        }
    }
    (passed, least_m)
}

#[test]
fn a_cyclist_is_overtaken_with_room_and_the_lane_is_kept_before_and_after() {
    let (mut world, rider) = behind_a_cyclist();
    let own_y = pair(&world, rider).0.center.y;
    let (passed, least_m) = passes(&mut world, rider, &[], 45);
    let (time_s, _) = passed.expect("overtakes");
    assert!(time_s < 30.0, "{time_s} s");
    assert!((1.4..2.2).contains(&least_m), "{least_m} m beside");
    let (ego, cyclist) = pair(&world, rider);
    assert!((ego.center.y - own_y).abs() < 0.6, "{} after {own_y}", ego.center.y);
    assert!(ego.center.x > cyclist.center.x + 10.0);
}

#[test]
fn nobody_overtakes_into_who_comes_the_other_way() {
    for from_x in [-100.0, -40.0, 20.0, 80.0, 140.0] {
        let (mut world, rider) = behind_a_cyclist();
        let course = Course::Straight { x_m: from_x, y_m: 1.5, yaw_rad: math::PI, speed_mps: 8.0 };
        let oncoming = put(&mut world, ObjectClass::Car, 3, &course);
        let (passed, least_m) = passes(&mut world, rider, &[oncoming, rider], 45);
        assert!(passed.is_some(), "overtakes afterwards, oncoming from {from_x}");
        assert!(least_m > 1.3, "{least_m} m beside, oncoming from {from_x}");
    }
}

#[test]
fn a_car_that_stands_on_the_other_side_is_passed_first() {
    let (mut world, rider) = behind_a_cyclist();
    let parked = add(&mut world, ObjectClass::Car, -165.0, 2.0, 0.0, 4).unwrap();
    let (passed, least_m) = passes(&mut world, rider, &[parked, rider], 60);
    let (_, x_m) = passed.expect("overtakes behind it");
    assert!(x_m > -163.0, "at {x_m}");
    assert!(least_m > 1.4, "{least_m} m beside");
}

#[test]
fn without_another_lane_a_cyclist_is_followed() {
    let mut world = with_ego_at(slope(0.0), 1, [-80.0, 0.0, 0.0]);
    let course = Course::Straight { x_m: -60.0, y_m: -0.6, yaw_rad: 0.0, speed_mps: RIDER_MPS };
    let rider = put(&mut world, ObjectClass::Cyclist, 5, &course);
    world.drive(0.1, 5.0).unwrap();
    assert!(passes(&mut world, rider, &[rider], 30).0.is_none());
}
