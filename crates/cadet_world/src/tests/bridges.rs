//! Traffic on two levels: over a bridge and below it.

use super::towns::town;
use super::*;
use cadet_town::{Ground, RoadNetwork, walkways};

/// Half the length of each road.
const HALF_M: f64 = 150.0;
const BRIDGE_M: f64 = 6.0;

/// A level road along x, and one along y that leads over it.
fn crossing() -> Arc<Town> {
    let mut network = RoadNetwork::straight(2.0 * HALF_M, 3.5);
    for mut lane in RoadNetwork::straight(2.0 * HALF_M, 3.5).lanes {
        lane.id.0 += 2;
        lane.road = 1;
        lane.center.iter_mut().for_each(|p| *p = DVec3::new(-p.y, p.x, BRIDGE_M));
        network.lanes.push(lane);
    }
    let ground = Ground::new(&network).unwrap();
    let walkways = walkways(&ground);
    town(network, ground, walkways)
}

#[test]
fn agents_stay_on_the_surface_of_their_road() {
    for seed in 0..2 {
        let mut world = filled(crossing(), seed, [14, 10, 4]);
        let mut crossed = [0, 0];
        for _ in 0..60 {
            world.step(SECOND);
            for actor in &world.snapshot().actors {
                let p = actor.world_from_box.translation;
                let z_m = if p.y.abs() > p.x.abs() { BRIDGE_M } else { 0.0 };
                let is_on_one_road = p.truncate().abs().max_element() > 8.0;
                assert!(!is_on_one_road || (p.z - z_m).abs() < 0.5, "{}: {p}", actor.id);
                let is_at_crossing = p.truncate().length() < 3.0;
                let level = usize::from(p.z > BRIDGE_M / 2.0);
                assert!(!is_at_crossing || (p.z - [0.0, BRIDGE_M][level]).abs() < 0.5, "{}: {p}", actor.id);
                crossed[level] += usize::from(is_at_crossing);
            }
        }
        assert!(crossed.iter().all(|n| *n > 3), "{seed}: {crossed:?} at the crossing");
    }
}

#[test]
fn nobody_brakes_for_what_stands_on_the_other_level() {
    let mut world = World::new(crossing(), StreamKey::scene(1)).unwrap();
    // On the bridge, over the lane below.
    let placed = add(&mut world, ObjectClass::Car, 1.75, -1.75, 1.57, 4).unwrap();
    let placed = actor(&world, placed).world_from_box.translation;
    assert!((placed.z - BRIDGE_M).abs() < 0.3, "{placed}");
    world.move_ego(-60.0, -1.75, 0.0, Overlap::Refuse).unwrap();
    world.set_ego_driving(true);
    let mut slowest_mps = f64::INFINITY;
    for second in 0..20 {
        world.step(SECOND);
        let ego = world.snapshot().ego;
        assert!(ego.world_from_ego.translation.z.abs() < 0.5);
        let x = ego.world_from_ego.translation.x;
        if second > 6 && x < 60.0 {
            slowest_mps = slowest_mps.min(ego.velocity_world.length());
        }
    }
    assert!(world.snapshot().ego.world_from_ego.translation.x > 60.0 && slowest_mps > 8.0, "{slowest_mps} m/s");
    // On the bridge itself it stands in the way.
    world.move_ego(1.75, -60.0, math::PI / 2.0, Overlap::Refuse).unwrap();
    world.set_ego_driving(true);
    world.step(25 * SECOND);
    let ego = world.snapshot().ego;
    let (at, speed_mps) = (ego.world_from_ego.translation, ego.velocity_world.length());
    assert!((at.z - BRIDGE_M).abs() < 0.5 && at.y < -4.0 && speed_mps < 0.3, "{at} {speed_mps} m/s");
}
