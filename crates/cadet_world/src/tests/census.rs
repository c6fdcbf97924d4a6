//! Counts of who stands and for how long, and of who walks into what, over many worlds filled as the default policy
//! fills them.

use super::towns::suburb;
use super::*;
use crate::DT_S;

/// A person's body in the plane: a circle round the trunk. Arms and legs swing beyond it.
const BODY_M: f64 = 0.22;

/// Occupancy, cars, people, and cyclists: the middles of the default policy's districts.
const DISTRICTS: [(f64, usize, usize, usize); 5] =
    [(0.52, 13, 14, 3), (0.27, 12, 6, 1), (0.35, 28, 14, 4), (0.45, 12, 27, 6), (0.55, 18, 60, 8)];

fn policy_world(seed: u64) -> World {
    let mut world = World::new(suburb(seed), StreamKey::scene(seed)).unwrap();
    let (parking_occupancy, num_cars, num_pedestrians, num_cyclists) = DISTRICTS[seed as usize % DISTRICTS.len()];
    let counts = TrafficConfig { num_cars, num_pedestrians, num_cyclists, ..TrafficConfig::default() };
    world.spawn_traffic(&TrafficConfig { parking_occupancy, ..counts }).unwrap();
    world
}

/// The cars that have stood for `seconds`, what they brake for, and for whom those brake in turn.
fn stuck(world: &World, seconds: f64) -> Vec<String> {
    let stands = |(_, driver): &(&Agent, &Car)| driver.standing_steps as f64 * DT_S > seconds;
    cars(world).into_iter().filter(stands).map(|(a, driver)| format!("{} stands, {:?}", a.id, driver.cause())).collect()
}

#[test]
fn jams_dissolve() {
    let (num_worlds, num_views) = (20, 30);
    let (mut standing, mut longest_s) = (0, 0.0_f64);
    for seed in 0..num_worlds {
        let mut world = policy_world(seed);
        world.step(120);
        for view in 0..num_views {
            if view > 0 {
                world.drive(10.0, 2.0).unwrap();
            }
            standing += u32::from(world.ego().velocity_world.length() < 0.1);
            longest_s =
                cars(&world).iter().map(|(_, driver)| driver.standing_steps as f64 * DT_S).fold(longest_s, f64::max);
            let stuck = stuck(&world, 60.0);
            assert!(stuck.is_empty(), "seed {seed}, view {view}: {stuck:?}");
        }
    }
    let share = f64::from(standing) / (num_worlds as f64 * f64::from(num_views));
    assert!(share <= 0.15, "the ego stands at {share:.3} of the views; somebody stood for {longest_s:.0} s");
}

#[test]
fn nobody_walks_into_a_car_or_a_person() {
    for seed in 0..10 {
        let mut world = policy_world(seed);
        for tick in 0..240 {
            world.step(15);
            let driven = cars(&world).into_iter().map(|(agent, _)| agent);
            let ridden = world.arena.each::<Cyclist>().map(|(_, agent, _)| agent);
            let vehicles: Vec<(i32, Footprint)> =
                driven.chain(ridden).chain(parked(&world)).map(|a| (a.id, footprint(&world, a))).collect();
            let walkers = walkers(&world);
            for (i, (walker, pedestrian)) in walkers.iter().enumerate() {
                let p = place(&world, walker);
                for (id, car) in &vehicles {
                    let apart_m = (car.closest_point(p) - p).length();
                    let motion = pedestrian.motion;
                    assert!(apart_m >= BODY_M, "seed {seed}, tick {tick}: {} ({motion:?}) in car {id}", walker.id);
                }
                for (other, _) in &walkers[i + 1..] {
                    let apart_m = (place(&world, other) - p).length();
                    assert!(apart_m >= 2.0 * BODY_M, "seed {seed}, tick {tick}: {} in {}", walker.id, other.id);
                }
            }
        }
    }
}

/// Of KITTI's 4,487 labeled pedestrians 0.5 % are in pairs whose boxes reach more than 0.3 m into each other; of ours 1.1 %
/// in 6,000 frames.
#[test]
fn people_keep_a_stride_from_each_other() {
    let (mut num_people, mut num_pairs) = (0, 0);
    for seed in 0..8 {
        let mut world = policy_world(seed);
        for _ in 0..20 {
            let people: Vec<Footprint> = walkers(&world)
                .iter()
                .map(|(agent, _)| footprint(&world, agent).grown(-0.15))
                .filter(|box_in_plane| box_in_plane.half_length_m > 0.0)
                .collect();
            num_people += people.len();
            num_pairs += people
                .iter()
                .enumerate()
                .map(|(i, a)| people[..i].iter().filter(|b| a.overlaps(b)).count())
                .sum::<usize>();
            world.step(2 * 60);
        }
    }
    assert!(num_people > 1000, "{num_people} people");
    assert!(50 * num_pairs < num_people, "{num_pairs} pairs of {num_people} people");
}

#[test]
fn people_walk_in_groups_and_stay_together() {
    let (mut num_walkers, mut in_company, mut behind, mut together, mut parted) = (0, 0, 0, 0, 0);
    for seed in 0..10 {
        let mut world = policy_world(seed);
        world.step(60 * 20);
        num_walkers += walkers(&world).len();
        for (walker, pedestrian) in walkers(&world) {
            let Some(company) = pedestrian.company else { continue };
            let leader = &world.arena.agents[company.leader];
            assert!(leader.get::<Pedestrian>().unwrap().company.is_none(), "who leads follows nobody");
            in_company += 1;
            behind += usize::from(company.behind_m > 0.0);
            let place_m = math::hypot(company.behind_m, company.aside_m);
            if (place(&world, walker) - place(&world, leader)).length() < place_m + 1.5 {
                together += 1;
            } else {
                parted += 1;
            }
        }
    }
    // People who stand stay; corners, crossings, and lights part those who walk.
    assert!(3 * in_company > num_walkers && 5 * behind > in_company, "{in_company} of {num_walkers}, {behind} behind");
    assert!(10 * together > 13 * parted, "{together} together, {parted} parted");
}
