//! Cyclists in traffic, and led by scripts.

use super::towns::{hilly_ring, slope, suburb};
use super::*;
use crate::look::{CyclistLook, Ride};

fn ride(agent: &Agent) -> (Ride, f64, f64) {
    let CyclistLook { model, ride } = &agent.get::<Cyclist>().unwrap().own.look;
    (*ride, model.wheel_radius_m, model.wheelbase_m)
}

fn full_of_cyclists(seed: u64) -> World {
    filled(suburb(seed), seed, [16, 24, 8])
}

#[test]
fn cyclists_touch_nobody_and_keep_to_the_right_for_minutes() {
    for seed in 0..5 {
        let mut world = full_of_cyclists(seed);
        let num_cyclists = cyclists(&world).len();
        assert!(num_cyclists >= 6, "seed {seed}: {num_cyclists}");
        let (mut gone_m, mut from_border, mut stood) = (0.0, Vec::new(), 0);
        for tick in 0..480 {
            world.step(15);
            let riders: Vec<&Agent> = cyclists(&world).into_iter().map(|(agent, _)| agent).collect();
            let driven = cars(&world).into_iter().map(|(agent, _)| agent);
            let boxes = boxes(&world, riders.iter().copied().chain(driven).chain(parked(&world)));
            for (i, (id, a)) in boxes.iter().enumerate().take(riders.len()) {
                for (other, b) in &boxes[i + 1..] {
                    assert!(!a.overlaps(b), "seed {seed}, tick {tick}: cyclist {id} in {other} at {}", a.center);
                }
                for (walker, _) in walkers(&world) {
                    let apart_m = a.distance_m(place(&world, walker));
                    assert!(apart_m > 0.15, "seed {seed}, tick {tick}: cyclist {id} in walker {}", walker.id);
                }
                gone_m += a.velocity.length() / 4.0;
                let (ride, _, wheelbase_m) = ride(riders[i]);
                assert!(ride.lean_rad.abs() <= 0.30 + 1e-9);
                stood += usize::from(ride.stands);
                let pose = riders[i].actor().body.world_from_box(&world.arena.physics);
                for x in [-wheelbase_m / 2.0, wheelbase_m / 2.0] {
                    let foot = pose.transform_point(DVec3::X * x);
                    let above_m = foot.z - world.ground_height(foot.x, foot.y).expect("on the ground");
                    assert!(above_m.abs() < 0.03, "seed {seed}, tick {tick}: {id}'s wheel is {above_m} m above ground");
                }
            }
            for (agent, cyclist) in cyclists(&world) {
                let stands_s = cyclist.standing_steps as f64 * DT_S;
                assert!(stands_s < 60.0, "seed {seed}: {} stands for {stands_s} s: {:?}", agent.id, cyclist.cause());
                let lane = world.arena.streets.graph.lane(cyclist.route.lanes[0]);
                let (s_m, lateral_m) = lane.project(position(&world, agent));
                if lane.junction.is_none() && (12.0..lane.length_m() - 12.0).contains(&s_m) {
                    from_border.push(lane.width_at(s_m) / 2.0 - lateral_m);
                }
            }
        }
        from_border.sort_by(f64::total_cmp);
        let (low, middle) = (from_border[from_border.len() / 20], from_border[from_border.len() / 2]);
        assert!(low > 0.7 && (0.8..1.3).contains(&middle), "seed {seed}: {low} and {middle} m from the border");
        let mean_mps = gone_m / (120.0 * num_cyclists as f64);
        assert!(mean_mps > 2.0, "seed {seed}: {mean_mps} m/s");
        assert!(stood > 0, "seed {seed}: somebody waits with a foot down");
    }
}

#[test]
fn nobody_stands_for_a_minute_behind_cyclists() {
    for seed in 10..18 {
        let mut world = full_of_cyclists(seed);
        for tick in 0..180 {
            world.step(SECOND);
            nobody_stands(&world, 60.0, &format!("seed {seed}, {tick} s"));
        }
    }
}

#[test]
fn wheels_turn_by_the_way_over_their_radius_and_lean_goes_into_the_bend() {
    let mut world = filled(hilly_ring(), 3, [0, 0, 3]);
    let state = |world: &World| {
        let (agent, _) = cyclists(world)[0];
        let (ride, radius_m, _) = ride(agent);
        (ride, radius_m, place(world, agent), agent.actor().body.angular_velocity_world(&world.arena.physics).z)
    };
    let (mut turned_rad, mut gone_m) = (0.0, 0.0);
    let (mut before, _, mut from, _) = state(&world);
    for _ in 0..1200 {
        world.step(1);
        let (now, _, to, turn_radps) = state(&world);
        turned_rad += math::wrap_angle(now.roll_rad - before.roll_rad);
        gone_m += (to - from).length();
        if now.lean_rad.abs() > 0.05 && turn_radps.abs() > 0.1 {
            assert_eq!(now.lean_rad > 0.0, turn_radps > 0.0, "leans into the bend");
        }
        (before, from) = (now, to);
    }
    let radius_m = state(&world).1;
    assert!(gone_m > 30.0, "{gone_m} m");
    assert!((turned_rad * radius_m / gone_m - 1.0).abs() < 0.005, "{turned_rad} rad for {gone_m} m");
    // To lean to the left is to have the head on the left.
    let left = Ride { lean_rad: 0.2, ..before }.box_from_leaning().rotation * DVec3::Z;
    assert!(left.y > 0.19);
}

#[test]
fn a_car_follows_a_cyclist_at_a_distance_and_a_scripted_one_goes_where_it_is_told() {
    let mut world = with_ego_at(slope(0.02), 1, [-60.0, 0.0, 0.0]);
    let course = Course::Straight { x_m: -40.0, y_m: -0.4, yaw_rad: 0.0, speed_mps: 4.0 };
    let id = put(&mut world, ObjectClass::Cyclist, 5, &course);
    let mut nearest_m = f64::INFINITY;
    for _ in 0..15 {
        world.drive(4.0, 5.0).unwrap();
        let actor = actor(&world, id);
        assert_eq!(actor.class, ObjectClass::Cyclist);
        let expected_m = -40.0 + 4.0 * world.time_s();
        let at = actor.world_from_box.translation;
        assert!((at.x - expected_m).abs() < 1e-6 && (at.y + 0.4).abs() < 1e-9, "{at} in place of {expected_m}");
        nearest_m = nearest_m.min(at.x - world.ego().world_from_ego.translation.x);
    }
    assert!(nearest_m > 4.0, "{nearest_m} m from middle to middle");
    add(&mut world, ObjectClass::Cyclist, 0.0, 9.0, 1.0, 6).unwrap();
    let Some(Fixture::Cyclist(cyclist)) = world.arena.agents.last().unwrap().get() else { unreachable!() };
    assert!(cyclist.look.ride.stands);
    let again = add(&mut world, ObjectClass::Cyclist, 0.0, 9.0, 1.0, 7);
    assert!(matches!(again, Err(Error::Scene { .. })), "two at one place");
}
