//! Trucks, buses and trailers among the traffic: where they fit, and that nobody touches them or waits for ever.

use super::towns::{main_roads, suburb};
use super::*;
use crate::streets::Needs;
use cadet_town::LaneId;

/// The trucks that drive.
fn trucks(world: &World) -> Vec<(&Agent, &Car)> {
    cars(world).into_iter().filter(|(agent, _)| agent.actor().look.class() == ObjectClass::Truck).collect()
}

#[test]
fn trucks_share_the_streets_without_touching_or_jamming() {
    let (mut num_trucks, mut gone_m, mut longest_m) = (0, 0.0, 0.0_f64);
    for seed in 0..10 {
        let (town, name) = match seed % 2 {
            0 => (main_roads(seed), format!("main roads with trucks {seed}")),
            _ => (suburb(seed), format!("suburb with trucks {seed}")),
        };
        let mut world = filled(town, seed, [40, 30, 0]);
        let before: Vec<(i32, DVec2)> = trucks(&world).iter().map(|(a, _)| (a.id, place(&world, a))).collect();
        num_trucks += before.len();
        watch(&mut world, 45, &name);
        for (agent, driver) in trucks(&world) {
            longest_m = longest_m.max(agent.actor().look.size_lwh().x);
            let (stood_s, cause) = (driver.standing_steps as f64 * DT_S, driver.cause());
            assert!(stood_s < 40.0, "{name}: truck {} stands for {stood_s} s, {cause:?}", agent.id);
            if let Some((_, from)) = before.iter().find(|(id, _)| *id == agent.id) {
                gone_m += (place(&world, agent) - *from).length();
            }
        }
    }
    assert!(num_trucks >= 10 && longest_m > 9.0, "{num_trucks} trucks, up to {longest_m} m long");
    // Of those that have not left before a corner.
    assert!(gone_m > 200.0, "{num_trucks} trucks went {gone_m} m in all");
}

#[test]
fn trucks_keep_to_lanes_that_have_room() {
    let mut num_trucks = 0;
    for seed in 0..8 {
        let world = filled(main_roads(seed), seed, [40, 24, 0]);
        let graph = &world.arena.streets.graph;
        for (agent, driver) in trucks(&world) {
            let lane = graph.lane(driver.route.as_ref().unwrap().lanes[0]);
            let width_m = agent.actor().look.size_lwh().y;
            assert!(lane.width_m.iter().all(|lane_m| *lane_m > width_m), "{width_m} m wide on {:?}", lane.width_m);
            let standing = world.arena.around.standing.iter();
            let apart = |p: DVec2| move |o: &Footprint| o.distance_m(p);
            let least = lane.center.iter().flat_map(|p| standing.clone().map(apart(p.truncate()))).fold(9.0, f64::min);
            assert!(least > width_m / 2.0 + 0.1, "something stands {least} m from the lane's middle");
            // Or what stands at the edge of that room would stop them.
            let off_m = driver.route.as_ref().unwrap().offset_m.abs();
            assert!(off_m < 0.131, "{off_m} m off the lane's middle");
            num_trucks += 1;
        }
    }
    assert!(num_trucks >= 4, "{num_trucks}");
}

#[test]
fn what_is_long_does_not_turn_in_tight_corners() {
    let town = crossing();
    let graph = LaneGraph::new(Arc::clone(&town));
    let turning = |lane: &&cadet_town::Lane| {
        lane.junction.is_some() && !graph.fits(lane.id, Needs::of_truck(DVec3::new(12.3, 2.6, 2.9)))
    };
    // Of twelve ways across, four lead straight on; right turns have a radius of 8.5 m, left turns of 11.5 m.
    assert_eq!(graph.lanes().iter().filter(turning).count(), 8);
    let wide = Needs::of_truck(DVec3::new(6.5, 2.9, 2.6));
    assert!(!graph.fits(LaneId(0), wide), "a lane of 3 m");
}

#[test]
fn a_long_van_does_not_turn_where_it_would_swing_into_the_oncoming_lane() {
    let (long, short) = (Needs::of_van(DVec3::new(6.7, 2.4, 2.6)), Needs::of_van(DVec3::new(5.0, 2.0, 2.0)));
    assert!(!short.is_some());
    let (mut num_tight, mut num_long, mut num_looks) = (0, 0, 0);
    for (seed, town) in trams::towns_with_tracks(4) {
        let mut world = trams::busy(seed, &town);
        let graph = &world.arena.streets.graph;
        num_tight += graph.lanes().iter().filter(|l| l.junction.is_some() && !graph.fits(l.id, long)).count();
        for _ in 0..60 {
            world.step(SECOND);
            let is_van = |(agent, _): &(&Agent, &Car)| agent.actor().look.class() == ObjectClass::Van;
            for (agent, driver) in cars(&world).into_iter().filter(is_van) {
                let (size_lwh, lane) = (agent.actor().look.size_lwh(), driver.route.as_ref().unwrap().lanes[0]);
                num_looks += 1;
                num_long += usize::from(size_lwh.x > 5.6);
                assert!(world.arena.streets.graph.fits(lane, Needs::of_van(size_lwh)), "{} on {lane:?}", agent.id);
            }
        }
    }
    // There are such bends, and such vans.
    assert!(num_tight > 20 && num_long > 100, "{num_tight} tight bends, {num_long} of {num_looks} vans are long");
}

#[test]
fn a_place_without_a_trailer_or_a_truck_holds_the_same_car() {
    let fill = |seed: u64, vehicle_shares: &[(ObjectClass, f64)]| {
        let vehicle_shares = vehicle_shares.to_vec();
        let config = TrafficConfig { num_cars: 0, num_pedestrians: 0, vehicle_shares, ..TrafficConfig::default() };
        let world = filled_as(suburb(seed), seed, &config);
        let key =
            |a: &&Agent| (a.actor().look.class(), place(&world, a).to_string(), a.actor().look.size_lwh().to_string());
        parked(&world).iter().map(key).collect::<Vec<_>>()
    };
    let is_rare = |v: &(ObjectClass, String, String)| !matches!(v.0, ObjectClass::Car | ObjectClass::Van);
    let mut num_rare = 0;
    for seed in 2..6 {
        let plain = fill(seed, &[(ObjectClass::Car, 0.9), (ObjectClass::Van, 0.1)]);
        assert!(!plain.iter().any(is_rare));
        let (rare, others): (Vec<_>, Vec<_>) = fill(seed, &[]).into_iter().partition(is_rare);
        num_rare += rare.len();
        // But the neighbors of what is large.
        let kept = others.iter().filter(|v| plain.contains(v)).count();
        assert!(20 * kept >= 19 * others.len(), "seed {seed}: {kept} of {} stand where they did", others.len());
    }
    assert!(num_rare >= 5, "{num_rare}");
}
