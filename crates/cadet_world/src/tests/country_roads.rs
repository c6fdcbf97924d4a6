//! Traffic on country roads: fast, without sidewalks, through bends and junctions.

use super::towns::country_roads;
use super::*;
use crate::DT_S;
use cadet_town::GroundKind;

#[test]
fn traffic_flows_on_country_roads_without_touching_or_jamming() {
    for seed in 0..6 {
        let name = format!("country roads {seed}");
        let town = country_roads(seed);
        let mut world = World::new(Arc::clone(&town), StreamKey::scene(seed)).unwrap();
        let config = TrafficConfig { num_cars: 14, num_pedestrians: 10, num_cyclists: 1, ..TrafficConfig::default() };
        world.spawn_traffic(&config).unwrap();
        let gone_m = watch(&mut world, 60, &name);
        let num_cars = cars(&world).len() as f64;
        assert!(gone_m > 4.0 * 60.0 * num_cars, "{name}: {gone_m} m in all by {num_cars} cars");
        for (agent, driver) in cars(&world) {
            let stood_s = driver.standing_steps as f64 * DT_S;
            assert!(stood_s < 40.0, "{name}: {} stands for {stood_s} s, {:?}", agent.id, driver.cause());
            let at = place(&world, agent);
            assert_eq!(town.ground.kind_at(at.x, at.y), Some(GroundKind::Road), "{name}: {}", agent.id);
        }
        // Without sidewalks nobody is on foot.
        assert!(walkers(&world).is_empty(), "{name}");
    }
}
