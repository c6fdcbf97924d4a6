//! Traffic in car parks, commercial areas, and on campuses.

use super::towns::place as place_of;
use super::*;
use cadet_town::SpotKind;

fn flows_at(kind: usize, config: &TrafficConfig, least_mps: f64) {
    for seed in 0..10 {
        let mut world = filled_as(place_of(kind, seed), seed, config);
        flows(&mut world, 60, (least_mps, 45.0), &format!("place {kind}, seed {seed}"));
    }
}

#[test]
fn traffic_flows_through_the_aisles_of_car_parks() {
    let config = TrafficConfig { num_cars: 12, num_pedestrians: 24, parking_occupancy: 0.7, ..Default::default() };
    flows_at(0, &config, 1.2);
}

#[test]
fn traffic_flows_through_commercial_areas() {
    let config = TrafficConfig { num_cars: 18, num_pedestrians: 6, num_cyclists: 2, ..Default::default() };
    flows_at(1, &config, 2.0);
}

#[test]
fn traffic_flows_on_a_campus_among_people() {
    let config = TrafficConfig { num_cars: 6, num_pedestrians: 70, num_cyclists: 8, ..Default::default() };
    flows_at(2, &config, 0.8);
}

#[test]
fn bays_are_as_full_as_the_district_and_yards_have_trucks() {
    let mut trucks = 0;
    for seed in 0..4 {
        for (kind, spot_kind) in [(0, SpotKind::Lot), (1, SpotKind::Yard)] {
            let town = place_of(kind, seed);
            let config =
                TrafficConfig { num_cars: 1, num_pedestrians: 0, parking_occupancy: 0.6, ..Default::default() };
            let world = filled_as(Arc::clone(&town), seed, &config);
            let ego = world.ego().world_from_ego.translation;
            // What lies farther off is left empty.
            let is_near = |s: &&cadet_town::ParkingSpot| (s.world_from_spot.translation - ego).length() < 270.0;
            let spots: Vec<_> = town.parking.iter().filter(|s| s.kind == spot_kind).filter(is_near).collect();
            let holds = |s: &&&cadet_town::ParkingSpot| {
                let at = s.world_from_spot.translation.truncate();
                parked(&world).iter().any(|a| (place(&world, a) - at).length() < 1.2)
            };
            let share = spots.iter().filter(holds).count() as f64 / spots.len() as f64;
            if kind == 0 {
                assert!(spots.len() > 40 && (share - 0.57).abs() < 0.09, "seed {seed}: {share} of {}", spots.len());
            } else {
                trucks += parked(&world).iter().filter(|a| a.actor().look.class() == ObjectClass::Truck).count();
            }
        }
    }
    assert!(trucks >= 4, "{trucks}");
}

#[test]
fn nobody_on_foot_appears_in_a_bicycle_that_stands() {
    let mut world = World::new(suburb(0), StreamKey::scene(2)).unwrap();
    for walkway in &world.town().walkways.clone() {
        for p in walkway.center.iter().step_by(4) {
            let course = Course::Stand { x_m: p.x, y_m: p.y, yaw_rad: 0.5 };
            world.add(ObjectClass::Cyclist, ModelChoice::Seed(1), &course, Overlap::Allow).unwrap();
        }
    }
    let config = TrafficConfig { num_cars: 0, num_pedestrians: 60, ..TrafficConfig::default() };
    world.spawn_traffic(&config).unwrap();
    assert!(walkers(&world).len() > 15, "{} people", walkers(&world).len());
    for (agent, _) in walkers(&world) {
        let at = place(&world, agent);
        assert!(world.arena.vehicles().all(|(_, o)| o.distance_m(at) > 0.3), "{at}");
    }
}
