//! Roads that end with the map, and those on which traffic keeps left.

use std::collections::BTreeSet;

use super::towns::{ground, join, lane, line, town};
use super::*;
use crate::streets::Route;
use cadet_base::rng::Stream;
use cadet_town::{LaneId, RoadNetwork};

const HALF_M: f64 = 150.0;
/// Snapshots hold all who are as near to the ego.
const SHOWN_WITHIN_M: f64 = 240.0;

/// A level road of two lanes that nothing leads to or on from.
fn two_dead_ends(keeps_left: bool, seed: u64) -> World {
    let flat = |_: f64, _: f64| 0.0;
    let mut network = RoadNetwork::default();
    let (west, east) = (DVec2::new(-HALF_M, 0.0), DVec2::new(HALF_M, 0.0));
    let left_m = if keeps_left { 1.5 } else { -1.5 };
    for (from, to, y_m) in [(west, east, left_m), (east, west, -left_m)] {
        let id = lane(&mut network, &line(from + DVec2::Y * y_m, to + DVec2::Y * y_m), None, &flat);
        network.lanes[id.0].keeps_left = keeps_left;
    }
    let town = town(network, ground(HALF_M + 50.0, 5.0, &flat), Vec::new());
    filled(town, seed, [8, 0, 3])
}

/// All who drive or ride but the ego.
fn traffic(world: &World) -> Vec<&Agent> {
    let drivers = cars(world).into_iter().skip(1).map(|(agent, _)| agent);
    drivers.chain(cyclists(world).into_iter().map(|(agent, _)| agent)).collect()
}

/// Six minutes of traffic: everybody stays on the road and off each other, many come and go, and cyclists are overtaken.
fn flow(keeps_left: bool, seed: u64) {
    let mut world = two_dead_ends(keeps_left, seed);
    let mut overtakers = BTreeSet::new();
    let mut ids = BTreeSet::new();
    for minute in 0..6 {
        let mut moving_s = 0;
        for second in 0..60 {
            world.step(SECOND);
            let traffic = traffic(&world);
            let boxes: Vec<Footprint> = traffic.iter().map(|a| footprint(&world, a).grown(-0.05)).collect();
            for (i, agent) in traffic.iter().enumerate() {
                let at = place(&world, agent);
                assert!(at.x.abs() < HALF_M + 0.5 && at.y.abs() < 3.0, "{minute}:{second}: {} at {at}", agent.id);
                let met = boxes[..i].iter().position(|other| other.overlaps(&boxes[i]));
                assert_eq!(met.map(|k| traffic[k].id), None, "{minute}:{second}: {} at {at}", agent.id);
            }
            let overtaking = cars(&world).into_iter().filter(|(_, driver)| driver.overtaking.is_some());
            overtakers.extend(overtaking.map(|(agent, _)| agent.id));
            moving_s += boxes.iter().filter(|f| f.velocity.length() > 1.0).count();
            ids.extend(traffic.iter().map(|a| a.id));
            let shown: BTreeSet<i32> = world.snapshot().actors.iter().map(|a| a.id).collect();
            let from = world.ego().world_from_ego.translation.truncate();
            let (near, far): (Vec<&Agent>, Vec<&Agent>) =
                traffic.iter().partition(|a| (place(&world, a) - from).length() < SHOWN_WITHIN_M);
            assert!(near.iter().all(|a| shown.contains(&a.id)), "{minute}:{second}: {shown:?}");
            let far_shown = far.iter().filter(|a| shown.contains(&a.id)).count();
            assert_eq!(shown.len() - near.len(), far_shown, "{minute}:{second}");
        }
        assert!(moving_s > 60, "minute {minute}: {moving_s} s of driving in all");
    }
    assert!(ids.len() > 40, "{} in six minutes", ids.len());
    assert!(!overtakers.is_empty(), "nobody overtakes a cyclist");
}

#[test]
fn who_comes_to_where_the_map_ends_leaves_and_others_come_for_as_long_as_one_looks() {
    (1..4).for_each(|seed| flow(false, seed));
}

#[test]
fn on_the_left_side_of_the_road_too() {
    flow(true, 1);
}

#[test]
fn an_ego_at_its_roads_end_is_said_to_be_there_and_drives_no_farther() {
    let mut world = two_dead_ends(false, 1);
    let gone_m = world.drive(1000.0, 30.0).unwrap();
    assert!(world.ego_is_at_road_end() && gone_m < 2.0 * HALF_M);
    let x_m = world.ego().world_from_ego.translation.x.abs();
    assert!((HALF_M - 8.0..HALF_M - 2.0).contains(&x_m), "{x_m} m");
    assert!(world.drive(10.0, 30.0).unwrap() < 0.5);
}

#[test]
fn an_ego_comes_in_elsewhere_where_it_may() {
    let mut world = two_dead_ends(false, 1);
    let (mut moved_s, mut jumps, mut before) = (0, 0, world.ego().world_from_ego.translation);
    for _ in 0..300 {
        world.step_on(SECOND);
        let (here, velocity) = (world.ego().world_from_ego.translation, world.ego().velocity_world);
        jumps += usize::from((here - before).length() > 20.0);
        moved_s += usize::from(velocity.length() > 1.0);
        before = here;
    }
    assert!(jumps >= 3 && moved_s > 150, "{jumps} returns, {moved_s} s on the way");
}

#[test]
fn cyclists_ride_beside_the_curb_whichever_side_traffic_keeps_to() {
    for keeps_left in [false, true] {
        let mut world = two_dead_ends(keeps_left, 1);
        let mut seen = 0;
        for _ in 0..60 {
            world.step(SECOND / 2);
            for (agent, _) in cyclists(&world) {
                let f = footprint(&world, agent);
                let left_m = f.heading.perp().dot(f.center);
                let to_curb_m = if keeps_left { left_m } else { -left_m };
                assert!((1.5..2.4).contains(&to_curb_m), "left {keeps_left}: {to_curb_m} m off the road's middle");
                seen += 1;
            }
        }
        assert!(seen > 60, "{seen}");
    }
}

#[test]
fn the_inner_lane_is_the_one_at_the_middle_of_the_road() {
    for keeps_left in [false, true] {
        let flat = |_: f64, _: f64| 0.0;
        let mut network = RoadNetwork::default();
        for y_m in [1.5, 4.5] {
            let id = lane(&mut network, &line(DVec2::new(0.0, y_m), DVec2::new(90.0, y_m)), None, &flat);
            (network.lanes[id.0].keeps_left, network.lanes[id.0].road) = (keeps_left, 7);
        }
        let graph = LaneGraph::new(town(network, ground(100.0, 5.0, &flat), Vec::new()));
        let [right, left] = [LaneId(0), LaneId(1)];
        let (inner, outer) = if keeps_left { (right, left) } else { (left, right) };
        assert_eq!((graph.inner_of(outer), graph.inner_of(inner)), (Some(inner), None));
        assert_eq!((graph.outer_of(inner), graph.outer_of(outer)), (Some(outer), None));
    }
}

#[test]
fn a_road_in_short_pieces_is_as_long_as_in_one() {
    let mut network = RoadNetwork::default();
    let at = |k: u32| DVec2::new(0.5 * f64::from(k) - 200.0, 0.0);
    let pieces: Vec<LaneId> = (0..800).map(|k| lane(&mut network, &[at(k), at(k + 1)], None, &|_, _| 0.0)).collect();
    pieces.windows(2).for_each(|pair| join(&mut network, pair[0], pair[1]));
    let graph = LaneGraph::new(town(network, ground(250.0, 10.0, &|_, _| 0.0), Vec::new()));
    assert!((graph.reach_m(pieces[0]) - 400.0).abs() < 1e-6, "{} m", graph.reach_m(pieces[0]));
    let begin = LanePosition { lane: pieces[0], s_m: 0.0, left_m: 0.0 };
    let route = Route::new(begin, 1.0, Stream::from_seed("way", 1), &graph);
    assert!(route.remaining_m(&graph) > 100.0, "{} m of 400 are known", route.remaining_m(&graph));
}
