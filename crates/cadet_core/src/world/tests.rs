//! The world as a whole: slopes, bends, queues, junctions, people, repeatability.

use std::sync::Arc;

use super::testing::{crossing, hilly_ring, slope};
use super::*;
use crate::math::{self, DVec2, DVec3};
use crate::world::spawn::TrafficConfig;

const SECOND: u32 = 60;

fn pitch_rad(world: &World) -> f64 {
    let x = world.ego().world_from_ego.rotation * DVec3::X;
    -math::asin(x.z)
}

#[test]
fn a_car_on_a_slope_settles_along_it_and_does_not_creep() {
    let mut world = World::new(slope(0.05), StreamKey::scene(1)).unwrap();
    for yaw in [0.0, 1.0, math::PI / 2.0, math::PI] {
        world.move_ego(3.0, 2.0, yaw).unwrap();
        world.step(2 * SECOND);
        let before = world.ego();
        let up = before.world_from_ego.rotation * DVec3::Z;
        let normal = DVec3::new(-0.05, 0.0, 1.0).normalize();
        let tilt_deg = math::acos(up.dot(normal).min(1.0)).to_degrees();
        assert!(tilt_deg < 0.3, "yaw {yaw}: {tilt_deg} degrees off the slope");
        let p = before.world_from_ego.translation;
        assert!((p.z - 0.05 * p.x).abs() < 0.01, "yaw {yaw}: the box's bottom is {} above the road", p.z - 0.05 * p.x);
        world.step(5 * SECOND);
        let crept = (world.ego().world_from_ego.translation - p).length();
        assert!(crept < 0.01, "yaw {yaw}: crept {crept} m");
        let moved = (p.truncate() - DVec2::new(3.0, 2.0)).length();
        assert!(moved < 0.05, "yaw {yaw}: settled {moved} m away");
    }
}

#[test]
fn a_car_follows_a_hilly_bend_at_its_speed_heading_forwards() {
    let town = hilly_ring();
    let mut world = World::new(Arc::clone(&town), StreamKey::scene(2)).unwrap();
    assert_eq!(world.drive(60.0, 5.0).unwrap().floor(), 60.0);
    let (mut worst_m, mut time_s) = (0.0_f64, 0);
    let mut gone_m = 0.0;
    while gone_m < 300.0 {
        gone_m += world.drive(5.0, 5.0).unwrap();
        time_s += 1;
        let ego = world.ego();
        let p = ego.world_from_ego.translation;
        let off_m = town.network.driving().map(|l| l.project(p).1).fold(f64::INFINITY, f64::min);
        worst_m = worst_m.max(off_m);
        let forward = ego.world_from_ego.rotation * DVec3::X;
        assert!(forward.dot(ego.velocity_world) > 0.95 * ego.velocity_world.length());
        let speed = ego.velocity_world.length();
        assert!((5.0..10.5).contains(&speed), "{speed} m/s where 8.3 are allowed");
        assert!((p.z - super::testing::hills(p.x, p.y)).abs() < 0.08, "{}", p.z - super::testing::hills(p.x, p.y));
        assert!(time_s < 100);
    }
    assert!(worst_m < 0.4, "{worst_m} m off the lane");
    assert!(pitch_rad(&world).abs() < 0.2);
}
