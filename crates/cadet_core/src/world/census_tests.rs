//! Who stands and for how long, and who walks into what, over many worlds filled as the default policy fills them.

use super::driver::Obstacle;
use super::testing::suburb;
use super::*;
use crate::world::spawn::TrafficConfig;

/// A person's body in the plane: a circle round the trunk. Arms and legs swing beyond it.
const BODY_M: f64 = 0.22;

/// Occupancy, cars and people: the middles of the default policy's districts.
const DISTRICTS: [(f64, usize, usize); 5] =
    [(0.52, 13, 14), (0.27, 12, 6), (0.35, 28, 14), (0.45, 12, 27), (0.55, 18, 60)];

fn policy_world(seed: u64) -> World {
    let mut world = World::new(suburb(seed), StreamKey::scene(seed)).unwrap();
    let (parking_occupancy, num_cars, num_pedestrians) = DISTRICTS[seed as usize % DISTRICTS.len()];
    world
        .spawn_traffic(&TrafficConfig { num_cars, num_pedestrians, parking_occupancy, ..TrafficConfig::default() })
        .unwrap();
    world
}

/// The cars that have stood for `seconds`, what they brake for, and for whom those brake in turn.
fn stuck(world: &World, seconds: f64) -> Vec<String> {
    let stands = |c: &&Car| c.standing_steps as f64 * DT_S > seconds;
    world.cars.iter().filter(stands).map(|c| format!("{} stands, {:?}", c.id, c.cause())).collect()
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
            longest_s = world.cars.iter().map(|c| c.standing_steps as f64 * DT_S).fold(longest_s, f64::max);
            let stuck = stuck(&world, 60.0);
            assert!(stuck.is_empty(), "seed {seed}, view {view}: {stuck:?}");
        }
    }
    let share = f64::from(standing) / (num_worlds as f64 * f64::from(num_views));
    assert!(share <= 0.1, "the ego stands at {share:.3} of the views; somebody stood for {longest_s:.0} s");
}

#[test]
fn nobody_walks_into_a_car_or_a_person() {
    for seed in 0..10 {
        let mut world = policy_world(seed);
        for tick in 0..240 {
            world.step(15);
            let cars: Vec<(i32, Obstacle)> = world
                .cars
                .iter()
                .map(|c| (c.id, c.footprint(&world.physics)))
                .chain(world.parked.iter().map(|p| (p.id, p.footprint)))
                .collect();
            for (i, walker) in world.walkers.iter().enumerate() {
                let p = walker.position.truncate();
                for (id, car) in &cars {
                    let apart_m = (car.closest_point(p) - p).length();
                    let motion = walker.motion;
                    assert!(apart_m >= BODY_M, "seed {seed}, tick {tick}: {} ({motion:?}) in car {id}", walker.id);
                }
                for other in &world.walkers[i + 1..] {
                    let apart_m = (other.position.truncate() - p).length();
                    assert!(apart_m >= 2.0 * BODY_M, "seed {seed}, tick {tick}: {} in {}", walker.id, other.id);
                }
            }
        }
    }
}

#[test]
fn people_walk_in_groups_and_stay_together() {
    let (mut walkers, mut in_company, mut behind, mut together, mut parted) = (0, 0, 0, 0, 0);
    for seed in 0..10 {
        let mut world = policy_world(seed);
        world.step(60 * 20);
        walkers += world.walkers.len();
        for walker in &world.walkers {
            let Some(company) = walker.company else { continue };
            let leader = &world.walkers[company.leader];
            assert!(leader.company.is_none(), "who leads follows nobody");
            in_company += 1;
            behind += usize::from(company.behind_m > 0.0);
            let place_m = crate::math::hypot(company.behind_m, company.aside_m);
            if (walker.at() - leader.at()).length() < place_m + 1.5 {
                together += 1;
            } else {
                parted += 1;
            }
        }
    }
    // Who stands stays, and corners and crossings part those who walk.
    assert!(3 * in_company > walkers && 5 * behind > in_company, "{in_company} of {walkers}, {behind} behind");
    assert!(together > 2 * parted, "{together} together, {parted} parted");
}
