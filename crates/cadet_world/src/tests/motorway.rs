//! Traffic on motorways: at speed, on several lanes, for minutes.

use super::towns::{ground, lane, line, motorway, town};
use super::*;
use std::collections::BTreeMap;

use cadet_town::{GroundKind, LaneId, RoadNetwork, Town};

/// What a run of some minutes showed.
#[derive(Debug, Default)]
struct Seen {
    changes: f64,
    hardest_mps2: f64,
    /// The largest of the ego's pitch, of a car's slip sideways, and of its distance from its line where it keeps its lane.
    pitch_rad: f64,
    slip_mps: f64,
    off_line_m: f64,
    on_right: usize,
    car_mps: Vec<f64>,
    truck_mps: Vec<f64>,
}

/// Lane and place of everybody who drives, by id.
fn places(world: &World) -> Vec<(i32, LaneId, f64, f64)> {
    let all = cars(world).into_iter().filter_map(|(agent, driver)| {
        let LanePosition { lane, s_m, .. } = driver.on_lane(0)?;
        Some((agent.id, lane, s_m, agent.actor().body.forward_mps(&world.arena.physics)))
    });
    all.collect()
}

fn drive(world: &mut World, seconds: u32, name: &str) -> Seen {
    let mut seen = Seen::default();
    let mut before: Vec<(i32, LaneId, f64, f64)> = Vec::new();
    // When each last braked by more than engines do: who brakes may be passed by who can't as hard.
    let mut braked_s: BTreeMap<i32, f64> = BTreeMap::new();
    for _ in 0..seconds * 4 {
        watch_quietly(world, name);
        let now = places(world);
        for (agent, driver) in cars(world) {
            let velocity = agent.actor().body.velocity_world(&world.arena.physics);
            let pose = agent.actor().body.world_from_box(&world.arena.physics);
            let left = pose.rotation * DVec3::Y;
            seen.slip_mps = seen.slip_mps.max(velocity.dot(left).abs());
            let own = now.iter().find(|n| n.0 == agent.id);
            let Some((_, lane, _, speed_mps)) = own.copied() else { continue };
            if let Some((.., was_mps)) = before.iter().find(|b| b.0 == agent.id) {
                seen.hardest_mps2 = seen.hardest_mps2.max((was_mps - speed_mps) * 4.0);
                if (was_mps - speed_mps) * 4.0 > 1.0 {
                    braked_s.insert(agent.id, world.time_s());
                }
            }
            if driver.lanes.change.is_none() {
                seen.off_line_m = seen.off_line_m.max(world.town().network.lane(lane).project(pose.translation).1);
            }
            let kind = world.town().ground.kind_at(pose.translation.x, pose.translation.y);
            assert_eq!(kind, Some(GroundKind::Road), "{name}: {}", agent.id);
            if agent.id == 0 || (pose.translation - world.ego().world_from_ego.translation).length() > 240.0 {
                continue;
            }
            let is_truck = agent.actor().look.class() == ObjectClass::Truck;
            if is_truck { &mut seen.truck_mps } else { &mut seen.car_mps }.push(speed_mps);
        }
        // Vehicles that were behind another on the lane to the left, and are ahead now, both at speed.
        let graph = &world.arena.streets.graph;
        let changing = cars(world).into_iter().filter(|(_, driver)| driver.lanes.change.is_some());
        let changing: Vec<i32> = changing.map(|(agent, _)| agent.id).collect();
        for (id, lane, s_m, speed_mps) in &now {
            let Some((_, lane_before, s_before, _)) = before.iter().find(|b| b.0 == *id) else { continue };
            for (other, other_lane, other_s, other_mps) in now.iter().filter(|o| graph.inner_of(*lane) == Some(o.1)) {
                let Some((_, _, other_before, _)) = before.iter().find(|b| b.0 == *other && b.1 == *other_lane) else {
                    continue;
                };
                let passed = lane_before == lane && s_before < other_before && s_m > other_s;
                let fast = *other_mps > 22.0 && speed_mps - other_mps > 2.0;
                let brakes = braked_s.get(other).is_some_and(|t| world.time_s() - t < 4.0);
                let passed = passed && !brakes && !changing.contains(id) && !changing.contains(other);
                seen.on_right += usize::from(passed && fast);
            }
        }
        seen.pitch_rad = seen.pitch_rad.max(pitch_rad(world).abs());
        // Each change is seen at all quarters of a second that it takes.
        seen.changes += changing.len() as f64 / (4.0 * 4.6);
        before = now;
    }
    seen
}

/// A quarter of a second: nobody touches anybody, flies, or tips.
fn watch_quietly(world: &mut World, name: &str) {
    world.step(SECOND / 4);
    let driven: Vec<(&Agent, Footprint)> = cars(world).into_iter().map(|(a, _)| (a, footprint(world, a))).collect();
    for (i, (agent, a)) in driven.iter().enumerate() {
        let pose = agent.actor().body.world_from_box(&world.arena.physics);
        let ground = world.ground_height(pose.translation.x, pose.translation.y).expect("on the ground");
        let above_m = pose.translation.z - ground;
        assert!(above_m.abs() < 0.25, "{name}: {} is {above_m} m above the ground", agent.id);
        assert!((pose.rotation * DVec3::Z).z > 0.98, "{name}: {} tips", agent.id);
        for (other, b) in &driven[i + 1..] {
            let speeds = (a.velocity.length(), b.velocity.length());
            assert!(!a.overlaps(b), "{name}: {} and {} touch at {} s, {speeds:?}", agent.id, other.id, world.time_s());
        }
    }
}

fn mean(values: &[f64]) -> f64 {
    values.iter().sum::<f64>() / values.len().max(1) as f64
}

#[test]
fn traffic_flows_on_motorways_for_minutes() {
    let (mut changes, mut on_right) = (0.0, 0);
    for seed in 0..6 {
        let mut world = filled(motorway(seed), seed, [36, 4, 2]);
        let name = format!("motorway {seed}");
        let limit_mps = world.town().network.driving().next().unwrap().speed_limit_mps;
        let start_mps = world.ego().velocity_world.length();
        assert!(start_mps > 0.7 * limit_mps, "{name}: {start_mps} m/s at the start");
        let num = cars(&world).len();
        let seen = drive(&mut world, 120, &name);
        changes += seen.changes;
        assert!(walkers(&world).is_empty() && world.snapshot().actors.iter().all(|a| a.class != ObjectClass::Cyclist));
        assert!(num > 20, "{name}: {num} vehicles");
        assert!((75.0..95.0).contains(&(3.6 * mean(&seen.truck_mps))), "{name}: trucks");
        assert!(mean(&seen.car_mps) > 0.75 * limit_mps, "{name}: cars at {} m/s", mean(&seen.car_mps));
        assert!(seen.hardest_mps2 < 9.0, "{name}: {} m/s²", seen.hardest_mps2);
        assert!(seen.pitch_rad < 0.05 && seen.slip_mps < 2.0 && seen.off_line_m < 0.9, "{name}: {seen:?}");
        on_right += seen.on_right;
    }
    assert!(changes > 20.0, "{changes} changes");
    // In 440 minutes of driving.
    assert!(on_right <= 2, "{on_right} pass on the right");
}

/// Two eastbound lanes along x, 130 km/h: the left one at y = -1.875, the right one at y = -5.625.
fn two_lanes() -> Arc<Town> {
    let flat = |_: f64, _: f64| 0.0;
    let mut network = RoadNetwork::default();
    for y in [-1.875, -5.625] {
        lane(&mut network, &line(DVec2::new(-1200.0, y), DVec2::new(1200.0, y)), None, &flat);
    }
    for lane in &mut network.lanes {
        (lane.road, lane.speed_limit_mps) = (7, 130.0 / 3.6);
        lane.width_m.iter_mut().for_each(|w| *w = 3.75);
    }
    town(network, ground(1220.0, 61.0, &flat), Vec::new())
}

#[test]
fn a_slow_truck_is_passed_on_the_left_and_the_right_lane_taken_again() {
    let mut world = with_ego_at(two_lanes(), 1, [-1150.0, -5.625, 0.0]);
    let course = Course::Straight { x_m: -800.0, y_m: -5.625, yaw_rad: 0.0, speed_mps: 15.0 };
    let truck = put(&mut world, ObjectClass::Truck, 3, &course);
    world.drive(0.1, 5.0).unwrap();
    let (mut beside_m, mut ways, mut hardest_mps2) = (f64::INFINITY, Vec::new(), 0.0_f64);
    let mut before_mps = 0.0;
    for _ in 0..75 * 4 {
        world.step(SECOND / 4);
        let way = world.arena.ego_car().lanes.change.map(|change| change.is_inward);
        if ways.last() != Some(&way) {
            ways.push(way);
        }
        let ego = footprint(&world, world.arena.ego());
        let other = world.arena.agents.iter().find(|a| a.id == truck).map(|a| footprint(&world, a)).unwrap();
        assert!(!ego.overlaps(&other));
        if (ego.center.x - other.center.x).abs() < ego.half_length_m + other.half_length_m {
            beside_m = beside_m.min(ego.center.y - other.center.y - ego.half_width_m - other.half_width_m);
        }
        hardest_mps2 = hardest_mps2.max((before_mps - ego.velocity.x) * 4.0);
        before_mps = ego.velocity.x;
        if ego.center.x > other.center.x + 160.0 {
            break;
        }
    }
    assert_eq!(ways, [None, Some(true), None, Some(false), None], "left, then right");
    let ego = world.ego().world_from_ego.translation;
    assert!((ego.y + 5.625).abs() < 0.4 && beside_m > 0.8 && beside_m < 3.0, "at {ego}, {beside_m} m beside the truck");
    assert!(hardest_mps2 < 2.5, "{hardest_mps2}");
}

#[test]
fn nobody_changes_into_a_gap_that_another_claims() {
    // Two claims of the middle of three lanes can't be made at once: whoever looks second sees the first one's.
    let mut world = filled(motorway(3), 3, [60, 24, 0]);
    let mut claims = 0;
    for _ in 0..90 * 4 {
        world.step(SECOND / 4);
        let claimed: Vec<Footprint> = world.arena.around.claims().map(|(_, claim)| *claim).collect();
        claims += claimed.len();
        for (i, a) in claimed.iter().enumerate() {
            assert!(claimed[i + 1..].iter().all(|b| !a.overlaps(b)), "at {} s", world.time_s());
        }
    }
    assert!(claims > 100, "{claims}");
}
