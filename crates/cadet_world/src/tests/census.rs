//! Counts of who stands and for how long, and of who walks into what, over many worlds filled as the default policy
//! fills them.

use super::towns::suburb;
use super::*;

/// A person's body in the plane: a circle round the trunk. Arms and legs swing beyond it.
const BODY_M: f64 = 0.22;

/// Occupancy, cars, people, and cyclists: the middles of the default policy's districts.
const DISTRICTS: [(f64, usize, usize, usize); 5] =
    [(0.52, 13, 14, 3), (0.27, 12, 6, 1), (0.35, 28, 14, 4), (0.45, 12, 27, 6), (0.55, 18, 60, 8)];

fn policy_world(seed: u64) -> World {
    let (parking_occupancy, num_cars, num_pedestrians, num_cyclists) = DISTRICTS[seed as usize % DISTRICTS.len()];
    let counts = TrafficConfig { num_cars, num_pedestrians, num_cyclists, ..TrafficConfig::default() };
    filled_as(suburb(seed), seed, &TrafficConfig { parking_occupancy, ..counts })
}

#[test]
fn jams_dissolve_and_the_ego_seldom_stands_where_views_are_taken() {
    let (num_worlds, num_views) = (20, 30);
    let mut standing = 0;
    for seed in 0..num_worlds {
        let mut world = policy_world(seed);
        world.step(120);
        // What the ego brakes for at each view since it stands.
        let mut run = Vec::new();
        for view in 0..num_views {
            if view > 0 {
                world.drive(10.0, 2.0).unwrap();
            }
            if world.ego().velocity_world.length() < 0.1 {
                standing += 1;
                run.push(world.ego_brakes_for());
            } else {
                run.clear();
            }
            let name = format!("seed {seed}, view {view}");
            // Twenty seconds: who has to yield loses patience after 18.
            assert!(run.len() <= 10, "{name}: the ego stands for {} views in a row: {run:?}", run.len());
            nobody_stands(&world, 60.0, &name);
        }
    }
    let share = f64::from(standing) / (num_worlds as f64 * f64::from(num_views));
    assert!(share <= 0.15, "the ego stands at {share:.3} of the views");
}

/// Of KITTI's 4,487 labeled pedestrians 0.5 % are in pairs whose boxes reach more than 0.3 m into each other.
#[test]
fn people_walk_into_nobody_keep_a_stride_and_stay_in_groups() {
    let (mut num_people, mut num_pairs, mut groups) = (0, 0, Groups::default());
    for seed in 0..10 {
        let mut world = policy_world(seed);
        // The first look is at where people appear.
        for tick in 0..=240 {
            if tick > 0 {
                world.step(15);
            }
            nobody_walks_into_a_car_or_a_person(&world, &format!("seed {seed}, tick {tick}"));
            if tick % 8 == 0 {
                let trunks = boxes(&world, walkers(&world).into_iter().map(|(agent, _)| agent));
                let trunks = trunks.iter().map(|(_, own)| own.grown(-0.15)).filter(|own| own.half_length_m > 0.0);
                let trunks: Vec<Footprint> = trunks.collect();
                num_people += trunks.len();
                let before = |i: usize| trunks[..i].iter().filter(|other| other.overlaps(&trunks[i])).count();
                num_pairs += (0..trunks.len()).map(before).sum::<usize>();
            }
            if tick == 80 {
                groups.count(&world);
            }
        }
    }
    assert!(num_people > 1900, "{num_people} people");
    assert!(200 * num_pairs < num_people, "{num_pairs} pairs of {num_people} people");
    // People who stand stay; corners, crossings, and lights part those who walk.
    let Groups { num_walkers, in_company, behind, together } = groups;
    assert!(3 * in_company > num_walkers && 5 * behind > in_company, "{in_company} of {num_walkers}, {behind} behind");
    assert!(23 * together > 13 * in_company, "{together} of {in_company} together");
}

fn nobody_walks_into_a_car_or_a_person(world: &World, name: &str) {
    let driven = cars(world).into_iter().map(|(agent, _)| agent);
    let ridden = cyclists(world).into_iter().map(|(agent, _)| agent);
    let vehicles = boxes(world, driven.chain(ridden).chain(parked(world)));
    let walkers = walkers(world);
    for (i, (walker, pedestrian)) in walkers.iter().enumerate() {
        let p = place(world, walker);
        for (id, car) in &vehicles {
            assert!(car.distance_m(p) >= BODY_M, "{name}: {} ({:?}) in car {id}", walker.id, pedestrian.motion);
        }
        for (other, _) in &walkers[i + 1..] {
            let apart_m = (place(world, other) - p).length();
            assert!(apart_m >= 2.0 * BODY_M, "{name}: {} in {}", walker.id, other.id);
        }
    }
}

/// Counts of people: all, those who follow another, those of them behind, and those near to their place.
#[derive(Default)]
struct Groups {
    num_walkers: usize,
    in_company: usize,
    behind: usize,
    together: usize,
}

impl Groups {
    fn count(&mut self, world: &World) {
        self.num_walkers += walkers(world).len();
        for (walker, pedestrian) in walkers(world) {
            let Some(company) = pedestrian.company else { continue };
            let leader = &world.arena.agents[company.leader];
            assert!(leader.get::<Pedestrian>().unwrap().company.is_none(), "who leads follows nobody");
            self.in_company += 1;
            self.behind += usize::from(company.behind_m > 0.0);
            let place_m = math::hypot(company.behind_m, company.aside_m);
            let is_near = (place(world, walker) - place(world, leader)).length() < place_m + 1.5;
            self.together += usize::from(is_near);
        }
    }
}
