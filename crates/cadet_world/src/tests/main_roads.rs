//! Traffic on main roads: two lanes a direction, medians, large junctions.

use std::collections::BTreeSet;

use super::towns::{long_main_roads, main_roads};
use super::*;
use cadet_town::LaneKind;

#[test]
fn traffic_flows_on_main_roads_without_touching_or_jamming() {
    for seed in 0..6 {
        let mut world = filled(main_roads(seed), seed, [24, 24, 0]);
        flows(&mut world, 60, (2.0, 60.0), &format!("main roads {seed}"));
    }
}

#[test]
fn vans_that_turn_into_narrow_arms_touch_nobody_who_waits_there() {
    let mut world = filled(main_roads(3), 3, [36, 0, 0]);
    watch(&mut world, 90, "main roads 3, 36 cars");
}

#[test]
fn nobody_parks_beside_an_inner_lane_or_walks_along_a_median() {
    let (mut num_spots, mut num_walks) = (0, 0);
    for seed in 0..6 {
        let town = main_roads(seed);
        let medians: Vec<_> = town.network.lanes.iter().filter(|l| l.kind == LaneKind::Median).collect();
        let nearest_m =
            |p| medians.iter().map(|l| l.project(p).1 - l.width_at(0.0) / 2.0).fold(f64::INFINITY, f64::min);
        for spot in &town.parking {
            num_spots += 1;
            // Half a car's width and a lane lie between a median and whoever parks at the curb.
            let apart_m = nearest_m(spot.world_from_spot.translation);
            assert!(apart_m > 2.5, "seed {seed}: a place {apart_m} m from a median");
        }
        for walk in &town.walkways {
            num_walks += 1;
            let along = walk.center.iter().filter(|p| nearest_m(**p) < 0.0).count();
            assert!(2 * along < walk.center.len(), "seed {seed}: a way of {} points on a median", walk.center.len());
        }
    }
    assert!(num_spots > 100 && num_walks > 20, "{num_spots} {num_walks}");
}

#[test]
fn drivers_change_lanes_between_junctions_without_touching() {
    let (mut num_changes, mut num_lanes) = (0, BTreeSet::new());
    for seed in 11..16 {
        let name = format!("lane changes on main roads {seed}");
        let mut world = filled(long_main_roads(seed), seed, [36, 0, 0]);
        let mut changing = BTreeSet::new();
        for _ in 0..90 {
            watch(&mut world, 1, &name);
            for (agent, driver) in cars(&world) {
                let lane = driver.route.as_ref().unwrap().lanes[0];
                if driver.lanes.change.is_none() {
                    changing.remove(&agent.id);
                } else if changing.insert(agent.id) {
                    num_changes += 1;
                    num_lanes.insert((seed, lane));
                    let graph = &world.arena.streets.graph;
                    assert!(
                        graph.inner_of(lane).or(graph.outer_of(lane)).is_some(),
                        "{name}: {} to {lane:?}",
                        agent.id
                    );
                }
            }
        }
    }
    assert!(num_changes >= 20 && num_lanes.len() >= 4, "{num_changes} changes to {} lanes", num_lanes.len());
}
