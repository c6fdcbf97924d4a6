//! Agents that follow a user's script, and how others take them.

use super::towns::{hilly_ring, slope};
use super::*;
use crate::agents::{Led, Scripted};
use crate::look::PersonLook;
use cadet_base::frames::yaw_of;
use cadet_base::math::wrap_angle;
use cadet_base::plane::unit;

pub(super) fn path(points: &[(f64, f64, f64)]) -> Course {
    Course::Path(points.iter().map(|(t_s, x_m, y_m)| Waypoint { t_s: *t_s, x_m: *x_m, y_m: *y_m }).collect())
}

fn scripted(world: &World, slot: usize) -> &Scripted {
    world.arena.agents[slot].get::<Scripted>().expect("it has a script")
}

/// The angle between a wheel's spoke and the box's vertical, as it is seen: its roll.
fn roll_rad(world: &World, slot: usize) -> f64 {
    let wheel = world.arena.agents[slot].actor().body.box_from_wheels().unwrap()[2];
    let spoke = wheel.rotation * DVec3::Z;
    math::atan2(spoke.x, spoke.z)
}

#[test]
fn a_scripted_car_is_where_its_path_is_and_rolls_along_it() {
    // 7 m/s uphill, a stop of a second, then 5 m/s to the left.
    let mut world = with_ego_at(slope(0.05), 0, [-50.0, 0.0, 0.0]);
    let course = path(&[(0.5, 0.0, 5.0), (4.5, 28.0, 5.0), (5.5, 28.0, 5.0), (9.5, 28.0, 25.0)]);
    let id = put(&mut world, ObjectClass::Car, 4, &course);
    let slot = world.arena.agents.len() - 1;
    let Led::Vehicle(car) = &scripted(&world, slot).led else { unreachable!("it is a car") };
    assert!(car.look.is_driven);
    let radius_m = car.look.model.wheel_radius_m;
    let (first, roll_at_start) = (actor(&world, id), roll_rad(&world, slot));
    assert_eq!((first.velocity_world, first.angular_velocity_world), (DVec3::ZERO, DVec3::ZERO));
    let mut gone_m = 0.0;
    for tick in 1..=70 {
        world.step(9);
        let t = f64::from(tick) * 0.15;
        let (x, y, velocity) = match t {
            t if t < 0.5 => (0.0, 5.0, DVec2::ZERO),
            t if t < 4.5 => (7.0 * (t - 0.5), 5.0, DVec2::new(7.0, 0.0)),
            t if t < 5.5 => (28.0, 5.0, DVec2::ZERO),
            t if t < 9.5 => (28.0, 5.0 + 5.0 * (t - 5.5), DVec2::new(0.0, 5.0)),
            _ => (28.0, 25.0, DVec2::ZERO),
        };
        let now = actor(&world, id);
        let p = now.world_from_box.translation;
        assert!((p.truncate() - DVec2::new(x, y)).length() < 1e-9, "at {p} after {t} s");
        assert!((p.z - 0.05 * x).abs() < 0.01, "{} above the slope", p.z - 0.05 * x);
        assert!((now.velocity_world.truncate() - velocity).length() < 1e-9, "{} at {t} s", now.velocity_world);
        assert!((now.velocity_world.z - 0.05 * velocity.x).abs() < 1e-4, "{} at {t} s", now.velocity_world);
        gone_m = if t < 5.5 { x } else { 28.0 + y - 5.0 };
        let turned = wrap_angle(roll_rad(&world, slot) - roll_at_start - gone_m / radius_m);
        assert!(turned.abs() < 1e-6, "the wheels are {turned} rad off after {gone_m} m");
        let yaw_rad = yaw_of(&now.world_from_box);
        if (0.5..4.2).contains(&t) {
            assert!(yaw_rad.abs() < 1e-6, "heading {yaw_rad} along x at {t} s");
        } else if t > 7.5 {
            assert!((yaw_rad - math::PI / 2.0).abs() < 1e-6, "heading {yaw_rad} along y at {t} s");
        }
    }
    assert!((gone_m - 48.0).abs() < 1e-9);
}

#[test]
fn a_scripted_car_turns_no_faster_than_a_car_can() {
    let mut world = with_ego_at(slope(0.0), 0, [-50.0, 0.0, 0.0]);
    let id = put(&mut world, ObjectClass::Car, 4, &path(&[(0.0, 0.0, 5.0), (2.0, 20.0, 5.0), (4.0, 20.0, 25.0)]));
    let (mut before, mut turned) = (0.0, 0.0);
    for step in 1..=240 {
        world.step(1);
        let now = actor(&world, id);
        let yaw_rad = yaw_of(&now.world_from_box);
        let rate = wrap_angle(yaw_rad - before) * 60.0;
        assert!(rate.abs() < 1.2 + 1e-6, "{rate} rad/s in step {step}");
        assert!((now.angular_velocity_world.z - rate).abs() < 1e-6);
        (before, turned) = (yaw_rad, yaw_rad);
    }
    assert!((turned - math::PI / 2.0).abs() < 1e-6);
}

#[test]
fn a_scripted_person_walks_with_the_gait_of_the_way_gone() {
    let mut world = with_ego_at(hilly_ring(), 0, [48.0, 0.0, 1.57]);
    for seed in 0..6 {
        let y = 2.0 * seed as f64;
        let id = put(&mut world, ObjectClass::Pedestrian, seed, &path(&[(0.0, 0.0, y), (10.0, 13.0, y)]));
        let slot = world.arena.agents.len() - 1;
        let phase = |world: &World| {
            let Led::Person(person) = &scripted(world, slot).led else { unreachable!("it is a person") };
            let PersonLook { model, phase } = &person.look;
            (*phase, model.cycle_length_m, model.walking_speed_mps)
        };
        let (at_start, cycle_m, walking_mps) = phase(&world);
        assert!(walking_mps > 0.0, "who moves walks");
        assert_eq!(actor(&world, id).velocity_world.truncate(), DVec2::new(1.3, 0.0));
        world.step(5 * SECOND);
        let now = actor(&world, id);
        let p = now.world_from_box.translation;
        assert!((p.truncate() - DVec2::new(6.5, y)).length() < 1e-9, "{p}");
        assert!((p.z - hills(p.x, p.y)).abs() < 0.02);
        assert!((now.velocity_world.truncate() - DVec2::new(1.3, 0.0)).length() < 1e-9);
        assert!(yaw_of(&now.world_from_box).abs() < 1e-9);
        let cycles = phase(&world).0 - at_start - 6.5 / cycle_m;
        assert!((cycles - cycles.round()).abs() < 1e-6, "{cycles} cycles off");
    }
}

#[test]
fn who_goes_straight_on_keeps_the_speed_and_stops_where_the_ground_ends() {
    let mut world = with_ego_at(slope(0.0), 0, [-50.0, 0.0, 0.0]);
    let straight = |x_m, y_m, yaw_rad, speed_mps| Course::Straight { x_m, y_m, yaw_rad, speed_mps };
    let id = put(&mut world, ObjectClass::Van, 1, &straight(70.0, 8.0, 0.3, 9.0));
    let heading = unit(0.3);
    assert!((actor(&world, id).velocity_world.truncate() - heading * 9.0).length() < 1e-9, "at once");
    world.step(2 * SECOND);
    let now = actor(&world, id);
    assert!((now.world_from_box.translation.truncate() - DVec2::new(70.0, 8.0) - heading * 18.0).length() < 1e-9);
    assert!((yaw_of(&now.world_from_box) - 0.3).abs() < 1e-6);
    world.step(10 * SECOND);
    let end = actor(&world, id);
    assert_eq!(end.velocity_world, DVec3::ZERO);
    assert!((94.0..100.0).contains(&end.world_from_box.translation.x), "{}", end.world_from_box.translation);
    let stands = put(&mut world, ObjectClass::Car, 1, &straight(0.0, 8.0, 0.3, 0.0));
    world.step(SECOND);
    assert_eq!(actor(&world, stands).world_from_box.translation.truncate(), DVec2::new(0.0, 8.0));
}

#[test]
fn traffic_brakes_for_a_scripted_car_and_for_a_scripted_person() {
    let run = |class: ObjectClass, points: &[(f64, f64, f64)]| {
        let mut world = with_ego_at(slope(0.0), 0, [-60.0, 0.0, 0.0]);
        put(&mut world, class, 2, &path(points));
        world.drive(300.0, 6.0).unwrap();
        world.ego().world_from_ego.translation.x
    };
    // A car ahead in the lane goes at walking pace and stops at x = 10.
    let behind = run(ObjectClass::Car, &[(0.0, -30.0, 0.0), (20.0, 10.0, 0.0)]);
    assert!((-2.0..2.5).contains(&behind), "the ego stopped at {behind}");
    let before_person = run(ObjectClass::Pedestrian, &[(0.0, 20.0, 6.0), (5.0, 20.0, 0.0)]);
    assert!((10.0..16.0).contains(&before_person), "the ego stopped at {before_person}");
    let free = run(ObjectClass::Car, &[(0.0, -30.0, 30.0), (20.0, 10.0, 30.0)]);
    assert!(free > 60.0, "the ego stopped at {free}");
}

#[test]
fn walkers_go_round_who_follows_a_script() {
    let mut num_met = 0;
    for seed in 0..4 {
        let mut world = filled(crossing(), seed, [0, 12, 0]);
        world.step(SECOND);
        // Somebody all but stands in the way of each who walks, on the line that the walker keeps.
        let in_the_way: Vec<DVec2> = walkers(&world)
            .into_iter()
            .filter(|(_, pedestrian)| matches!(pedestrian.motion, Motion::Walks { .. }))
            .map(|(agent, _)| {
                place(&world, agent) + agent.actor().body.velocity_world(&world.arena.physics).truncate() * 3.0
            })
            .collect();
        for p in &in_the_way {
            let course = path(&[(0.0, p.x, p.y), (100.0, p.x + 0.1, p.y)]);
            world.add(ObjectClass::Pedestrian, ModelChoice::Seed(1), &course, Overlap::Allow).unwrap();
        }
        let apart_m = |world: &World, p: DVec2| {
            walkers(world).iter().map(|(w, _)| (place(world, w) - p).length()).fold(f64::INFINITY, f64::min)
        };
        let met: Vec<DVec2> = in_the_way.into_iter().filter(|p| apart_m(&world, *p) > 0.6).collect();
        let mut nearest_m = vec![f64::INFINITY; met.len()];
        for _ in 0..60 {
            world.step(10);
            for (p, nearest_m) in met.iter().zip(&mut nearest_m) {
                *nearest_m = nearest_m.min(apart_m(&world, *p));
                assert!(*nearest_m > 0.4, "seed {seed}: a walker comes within {nearest_m} m of {p}");
            }
        }
        num_met += nearest_m.iter().filter(|m| **m < 1.5).count();
    }
    assert!(num_met > 5, "only {num_met} were met");
}

#[test]
fn the_same_script_gives_the_same_bits_and_moves_nobody_elses_draws() {
    let run = |with_script: bool| {
        let mut world = filled(crossing(), 5, [6, 6, 0]);
        if with_script {
            // Far from everybody.
            put(&mut world, ObjectClass::Car, 3, &path(&[(0.0, 90.0, 90.0), (9.0, 60.0, 100.0)]));
        }
        world.step(6 * SECOND);
        let actors = world.snapshot().actors;
        actors.iter().map(|a| (a.id, a.world_from_box.translation.to_array().map(f64::to_bits))).collect::<Vec<_>>()
    };
    let (once, again, without) = (run(true), run(true), run(false));
    assert_eq!(once, again);
    assert_eq!(once[..without.len()], without);
}

#[test]
fn paths_that_make_no_sense_are_refused() {
    let mut world = World::new(slope(0.0), StreamKey::scene(0)).unwrap();
    let mut refused = |class, course: &Course| {
        let reason = world.add(class, ModelChoice::Seed(1), course, Overlap::Allow).expect_err("refused").to_string();
        assert_eq!(world.arena.agents.len(), 1, "who is refused leaves nothing");
        reason
    };
    for (points, reason) in [
        (&[][..], "scene: path: expected at least 2 points, got 0"),
        (&[(0.0, 1.0, 1.0)], "scene: path: expected at least 2 points, got 1"),
        (&[(-1.0, 1.0, 1.0), (1.0, 2.0, 2.0)], "scene: path: expected times from 0 s on, got -1 s at point 0"),
        (
            &[(0.0, 1.0, 1.0), (2.0, 2.0, 2.0), (2.0, 3.0, 2.0)],
            "scene: path: expected rising times, got 2 s at point 2 after 2 s",
        ),
        (
            &[(0.0, 0.0, 0.0), (0.5, 60.0, 0.0)],
            "scene: path: expected at most 70 m/s, got 120.0 m/s on the way to point 1",
        ),
        (&[(0.0, f64::NAN, 0.0), (0.5, 60.0, 0.0)], "path x is not finite: NaN"),
        (&[(0.0, 0.0, 0.0), (100.0, 200.0, 0.0)], "scene: a vehicle at (99, 0) would stand beyond the ground's edge"),
    ] {
        assert_eq!(refused(ObjectClass::Car, &path(points)), reason);
    }
    let sprint = path(&[(0.0, 0.0, 0.0), (1.0, 14.0, 0.0)]);
    let reason = "scene: path: expected at most 12 m/s, got 14.0 m/s on the way to point 1";
    assert_eq!(refused(ObjectClass::Pedestrian, &sprint), reason);
    let off = path(&[(0.0, 90.0, 0.0), (20.0, 110.0, 0.0)]);
    let reason = "scene: a person at (101, 0) would walk beyond the ground's edge";
    assert_eq!(refused(ObjectClass::Pedestrian, &off), reason);
    let too_fast = Course::Straight { x_m: 0.0, y_m: 0.0, yaw_rad: 0.0, speed_mps: 80.0 };
    assert_eq!(refused(ObjectClass::Car, &too_fast), "speed is 80, expected 0 to 70 m/s");
}
