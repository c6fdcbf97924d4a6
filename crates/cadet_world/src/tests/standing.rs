//! Cars that stand stay where they are: on slopes, and with their wheels turned.

use super::*;

#[test]
fn a_car_on_a_slope_settles_along_it_and_does_not_creep() {
    let mut world = World::new(slope(0.05), StreamKey::scene(1)).unwrap();
    for yaw in [0.0, 1.0, math::PI / 2.0, math::PI] {
        world.move_ego(3.0, 2.0, yaw, Overlap::Refuse).unwrap();
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
fn a_car_that_stands_with_turned_wheels_does_not_turn() {
    for (rise_per_m, steer_rad) in [(0.0, 0.5), (0.0, -0.5), (0.05, 0.5), (0.05, -0.3)] {
        for yaw in [0.0, 1.0, 2.5] {
            let mut world = with_ego_at(slope(rise_per_m), 1, [3.0, 2.0, yaw]);
            world.step(2 * SECOND);
            let heading = |world: &World| footprint(world, world.arena.ego()).heading;
            let (before, at) = (heading(&world), position(&world, world.arena.ego()));
            for _ in 0..60 * SECOND {
                let (ego, physics) = world.arena.ego_car_mut();
                ego.own.body.command(-1.0, steer_rad, true, physics);
                ego.own.body.apply(physics);
                physics.step();
            }
            let turned_deg = math::asin(before.perp_dot(heading(&world))).to_degrees();
            let gone_m = (position(&world, world.arena.ego()) - at).length();
            assert!(
                turned_deg.abs() < 0.05 && gone_m < 0.02,
                "{rise_per_m}, {steer_rad}, {yaw}: {turned_deg} degrees, {gone_m} m"
            );
        }
    }
}
