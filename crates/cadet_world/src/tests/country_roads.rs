//! Traffic on country roads: fast, without sidewalks, through bends and junctions.

use super::towns::country_roads;
use super::*;
use cadet_town::GroundKind;

#[test]
fn traffic_flows_on_country_roads_without_touching_or_jamming() {
    for seed in 0..6 {
        let name = format!("country roads {seed}");
        let town = country_roads(seed);
        let mut world = filled(Arc::clone(&town), seed, [14, 10, 1]);
        flows(&mut world, 60, (4.0, 40.0), &name);
        for (agent, _) in cars(&world) {
            let at = place(&world, agent);
            assert_eq!(town.ground.kind_at(at.x, at.y), Some(GroundKind::Road), "{name}: {}", agent.id);
        }
        // Without sidewalks nobody is on foot.
        assert!(walkers(&world).is_empty(), "{name}");
    }
}
