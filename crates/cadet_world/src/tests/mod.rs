//! The world as a whole: slopes, bends, queues, junctions, people, repeatability.

mod belongings;
mod bridges;
mod census;
mod country_roads;
mod cycle_lanes;
mod cyclists;
mod figures;
mod flow;
mod lamps;
mod main_roads;
mod motorway;
mod openings;
mod overtaking;
mod placed;
mod places;
mod right_of_way;
mod road_ends;
mod roundabouts;
mod scripted;
mod seated;
mod signals;
mod standing;
pub(super) mod towns;
mod trams;
mod trucks;
mod turn_signals;
mod watching;

use std::sync::Arc;

use super::body::Fixed;
use super::footprint::Footprint;
use super::junctions::{Junctions, Refusal, Request};
use super::{Course, ModelChoice, Overlap, Shortfall, TrafficConfig, Waypoint, World};
use crate::DT_S;
use crate::agents::{Actor, Agent, Behavior, Car, Cyclist, Fixture, OfKind, Pedestrian};
use crate::look::VehicleLook;
use crate::streets::{LaneGraph, LanePosition};
use crate::walking::Motion;
use cadet_base::actor::{ActorState, BrakesFor, ObjectClass};
use cadet_base::error::{Error, Result};
use cadet_base::math::{self, DVec2, DVec3};
use cadet_base::rng::StreamKey;
use cadet_town::Town;
use towns::{crossing, hills, hilly_ring, map, slope, suburb};
use watching::{flows, nobody_stands, watch};

const SECOND: u32 = 60;

/// Adds an agent that stands.
fn add(world: &mut World, class: ObjectClass, x_m: f64, y_m: f64, yaw_rad: f64, seed: u64) -> Result<i32> {
    world.add(class, ModelChoice::Seed(seed), &Course::Stand { x_m, y_m, yaw_rad }, Overlap::Refuse)
}

/// Somebody on a course, by the model of a seed.
fn put(world: &mut World, class: ObjectClass, seed: u64, course: &Course) -> i32 {
    world.add(class, ModelChoice::Seed(seed), course, Overlap::Refuse).unwrap()
}

/// A town with so many cars, people, and cyclists.
pub(super) fn filled(town: Arc<Town>, seed: u64, [num_cars, num_pedestrians, num_cyclists]: [usize; 3]) -> World {
    let config = TrafficConfig { num_cars, num_pedestrians, num_cyclists, ..TrafficConfig::default() };
    filled_as(town, seed, &config)
}

fn filled_as(town: Arc<Town>, seed: u64, config: &TrafficConfig) -> World {
    let mut world = World::new(town, StreamKey::scene(seed)).unwrap();
    world.spawn_traffic(config).unwrap();
    world
}

/// A town without traffic, and the ego at a place with a yaw.
fn with_ego_at(town: Arc<Town>, seed: u64, [x_m, y_m, yaw_rad]: [f64; 3]) -> World {
    let mut world = World::new(town, StreamKey::scene(seed)).unwrap();
    world.move_ego(x_m, y_m, yaw_rad, Overlap::Refuse).unwrap();
    world
}

/// All of a kind who may move, by slot: of the cars the ego is the first.
fn all<K: OfKind>(world: &World) -> Vec<(&Agent, &K)> {
    world.arena.each::<K>().map(|(_, agent, own)| (agent, own)).collect()
}

fn cars(world: &World) -> Vec<(&Agent, &Car)> {
    all(world)
}

fn walkers(world: &World) -> Vec<(&Agent, &Pedestrian)> {
    all(world)
}

fn cyclists(world: &World) -> Vec<(&Agent, &Cyclist)> {
    all(world)
}

/// An actor but the ego, as snapshots show it.
fn actor(world: &World, id: i32) -> ActorState {
    world.snapshot().actors.into_iter().find(|a| a.id == id).unwrap()
}

/// What some agents cover, by their ids.
fn boxes<'a>(world: &World, agents: impl IntoIterator<Item = &'a Agent>) -> Vec<(i32, Footprint)> {
    agents.into_iter().map(|a| (a.id, footprint(world, a))).collect()
}

fn parked(world: &World) -> Vec<&Agent> {
    world.arena.agents.iter().filter(|a| parked_car(a).is_some()).collect()
}

fn parked_car(agent: &Agent) -> Option<&Actor<Fixed, VehicleLook>> {
    if let Some(Fixture::Vehicle(car)) = agent.get() { Some(car) } else { None }
}

fn footprint(world: &World, agent: &Agent) -> Footprint {
    agent.actor().footprint(&world.arena.physics)
}

fn position(world: &World, agent: &Agent) -> DVec3 {
    agent.actor().body.world_from_box(&world.arena.physics).translation
}

fn place(world: &World, agent: &Agent) -> DVec2 {
    position(world, agent).truncate()
}

fn pitch_rad(world: &World) -> f64 {
    let x = world.ego().world_from_ego.rotation * DVec3::X;
    -math::asin(x.z)
}

#[test]
fn a_car_follows_a_hilly_bend_at_its_speed_heading_forwards() {
    let town = hilly_ring();
    let mut world = World::new(Arc::clone(&town), StreamKey::scene(2)).unwrap();
    assert_eq!(world.drive(60.0, 5.0).unwrap().floor(), 60.0);
    let (mut worst_m, mut time_s) = (0.0_f64, 0);
    let mut gone_m = 0.0;
    while gone_m < 300.0 {
        gone_m += world.drive(5.0, 5.0).unwrap();
        time_s += 1;
        let ego = world.ego();
        let p = ego.world_from_ego.translation;
        let off_m = town.network.driving().map(|l| l.project(p).1).fold(f64::INFINITY, f64::min);
        worst_m = worst_m.max(off_m);
        let forward = ego.world_from_ego.rotation * DVec3::X;
        assert!(forward.dot(ego.velocity_world) > 0.95 * ego.velocity_world.length());
        let speed = ego.velocity_world.length();
        assert!((5.0..10.5).contains(&speed), "{speed} m/s where 8.3 are allowed");
        assert!((p.z - hills(p.x, p.y)).abs() < 0.08, "{}", p.z - hills(p.x, p.y));
        assert!(time_s < 100);
    }
    assert!(worst_m < 0.4, "{worst_m} m off the lane");
    assert!(pitch_rad(&world).abs() < 0.2);
}

#[test]
fn snow_lies_on_what_is_parked_and_on_nothing_that_drives() {
    let world = filled(suburb(3), 3, [10, 24, 4]);
    let parked: Vec<i32> = parked(&world).iter().map(|agent| agent.id).collect();
    let driven: Vec<i32> = cars(&world).iter().map(|(agent, _)| agent.id).collect();
    let (mut covered, mut bare) = (0, 0);
    for instance in world.snapshot().instances {
        if parked.contains(&instance.actor_id) {
            assert!(!instance.sheds_snow, "{}", instance.actor_id);
            covered += 1;
        } else if driven.contains(&instance.actor_id) {
            assert!(instance.sheds_snow, "{}", instance.actor_id);
            bare += 1;
        }
    }
    assert!(covered > 20 && bare > 10, "{covered} {bare}");
}

#[test]
fn cars_share_a_crossing_for_minutes_without_touching() {
    for seed in 0..5 {
        let mut world = filled(crossing(), seed, [14, 20, 0]);
        let num_cars = cars(&world).len();
        assert!(num_cars >= 8, "{num_cars}");
        flows(&mut world, 60, (1.5, 60.0), &format!("crossing {seed}"));
    }
}

#[test]
fn cars_share_a_hilly_ring() {
    for seed in 0..5 {
        let mut world = filled(hilly_ring(), seed, [16, 20, 0]);
        watch(&mut world, 60, &format!("ring {seed}"));
    }
}

#[test]
fn traffic_lives_in_suburbs_and_shared_maps() {
    let maps = ["Town01.xodr", "Town02.xodr"].into_iter().filter_map(map);
    for (i, town) in (0..5).map(suburb).chain(maps).enumerate() {
        let name = format!("{} {i}", town.name);
        let mut world = filled(town, i as u64, [40, 40, 0]);
        watch(&mut world, 60, &name);
    }
}

#[test]
fn a_car_keeps_its_distance_to_one_that_stands_in_its_lane() {
    for seed in 0..4 {
        let mut world = with_ego_at(slope(0.03), seed, [-60.0, 0.0, 0.0]);
        add(&mut world, ObjectClass::Car, 20.0, 0.1, 0.02, seed).unwrap();
        let gone_m = world.drive(200.0, 3.0).unwrap();
        let half_m =
            [parked(&world)[0], world.arena.ego()].map(|a| footprint(&world, a).half_length_m).iter().sum::<f64>();
        let gap_m = 80.0 - gone_m - half_m;
        assert!((3.9..6.0).contains(&gap_m), "stopped {gap_m} m behind");
        assert_eq!(world.ego_brakes_for(), Some(BrakesFor::Obstacle));
    }
}

#[test]
fn parked_wheels_touch_sloping_and_bent_ground() {
    let mut world = World::new(hilly_ring(), StreamKey::scene(0)).unwrap();
    for k in 0..40 {
        let a = f64::from(k) * 0.4;
        let (x, y) = ((20.0 + f64::from(k)) * math::cos(a), (20.0 + f64::from(k)) * math::sin(a));
        let course = Course::Stand { x_m: x, y_m: y, yaw_rad: f64::from(k) };
        world.add(ObjectClass::Car, ModelChoice::Seed(k as u64), &course, Overlap::Allow).unwrap();
        let parked = parked(&world).pop().unwrap();
        let pose = parked.actor().body.world_from_box(&world.arena.physics);
        let model = &parked_car(parked).unwrap().look.model;
        assert!((pose.translation.truncate() - DVec2::new(x, y)).length() < 1e-9);
        for wheel in parked.actor().body.box_from_wheels().unwrap() {
            let up = pose.rotation * DVec3::Z;
            let foot = pose.transform_point(wheel.translation) - up * model.wheel_radius_m;
            let ground = world.ground_height(foot.x, foot.y).unwrap();
            assert!((foot.z - ground).abs() < 0.01, "a wheel is {} m above the ground", foot.z - ground);
        }
    }
}

#[test]
fn what_finds_no_room_is_told() {
    let mut world = World::new(crossing(), StreamKey::scene(2)).unwrap();
    let config = TrafficConfig { num_cars: 400, num_pedestrians: 3, num_trams: 1, ..TrafficConfig::default() };
    let told = world.spawn_traffic(&config).unwrap();
    let placed = cars(&world).len() - 1;
    let cars = Shortfall { setting: "num_cars", asked: 400, placed };
    assert_eq!(told, [cars, Shortfall { setting: "num_trams", asked: 1, placed: 0 }]);
}

#[test]
fn the_same_calls_give_the_same_bits() {
    let run = |seed: u64| {
        let mut world = filled(crossing(), seed, [8, 8, 0]);
        world.drive(30.0, 2.0).unwrap();
        world.step(200);
        let s = world.snapshot();
        let bits = |p: &math::DPose3| {
            let (t, r) = (p.translation, p.rotation);
            [t.x, t.y, t.z, r.x, r.y, r.z, r.w].map(f64::to_bits)
        };
        let instances: Vec<_> = s.instances.iter().map(|i| (i.actor_id, bits(&i.world_from_local))).collect();
        let actors: Vec<_> = s.actors.iter().map(|a| (a.id, a.model.clone(), bits(&a.world_from_box))).collect();
        assert!(actors.windows(2).all(|w| w[0].0 < w[1].0) && actors.len() > 10);
        (instances, actors, bits(&s.ego.world_from_ego))
    };
    assert_eq!(run(3), run(3));
    assert_ne!(run(3).2, run(4).2);
}

#[test]
fn every_actor_has_one_body_and_scenery_has_none() {
    let mut world = filled(suburb(2), 2, [8, 8, 4]);
    world.step(SECOND);
    let s = world.snapshot();
    let bodies: Vec<i32> = s.instances.iter().filter(|i| i.is_body).map(|i| i.actor_id).collect();
    assert_eq!(bodies, s.actors.iter().map(|a| a.id).collect::<Vec<_>>());
    assert!(s.actors.iter().any(|a| a.class == ObjectClass::Cyclist));
}

#[test]
fn lanes_that_cross_or_merge_exclude_each_other_and_forks_do_not() {
    let town = crossing();
    let graph = LaneGraph::new(Arc::clone(&town));
    let junctions = Junctions::new(&graph);
    let connecting: Vec<_> = town.network.driving().filter(|l| l.junction.is_some()).collect();
    assert_eq!(connecting.len(), 12);
    for a in &connecting {
        for b in &connecting {
            let excluded = junctions.conflicts_of(a.id).contains(&b.id);
            assert_eq!(excluded, junctions.conflicts_of(b.id).contains(&a.id));
            if a.id != b.id && a.successors == b.successors {
                assert!(excluded, "merging lanes {:?} and {:?}", a.id, b.id);
            }
            if a.predecessors == b.predecessors {
                assert!(!excluded, "lanes {:?} and {:?} fork", a.id, b.id);
            }
        }
    }
    // Oncoming straight lanes pass each other; crossing straight lanes don't.
    let straight = |k: usize| connecting[3 * k].id;
    assert!(!junctions.conflicts_of(straight(0)).contains(&straight(2)));
    assert!(junctions.conflicts_of(straight(0)).contains(&straight(1)));
}

#[test]
fn what_makes_no_sense_is_refused() {
    let mut world = World::new(slope(0.0), StreamKey::scene(0)).unwrap();
    let is_scene = |r: Result<i32>| matches!(r, Err(Error::Scene { .. }));
    assert!(is_scene(add(&mut world, ObjectClass::Car, 1e4, 0.0, 0.0, 0)));
    assert!(is_scene(add(&mut world, ObjectClass::Pedestrian, 1e4, 0.0, 0.0, 0)));
    assert!(matches!(add(&mut world, ObjectClass::Car, f64::NAN, 0.0, 0.0, 0), Err(Error::NotFinite { .. })));
    assert!(world.move_ego(0.0, f64::INFINITY, 0.0, Overlap::Refuse).is_err());
    assert!(world.drive(-1.0, 2.0).is_err());
    assert!(world.spawn_traffic(&TrafficConfig { parking_occupancy: 1.5, ..TrafficConfig::default() }).is_err());
    assert_eq!(add(&mut world, ObjectClass::Van, 5.0, 4.0, 1.0, 0).unwrap(), 1);
    assert_eq!(add(&mut world, ObjectClass::Pedestrian, 5.0, 9.0, 1.0, 0).unwrap(), 2);
}

#[test]
fn shares_of_vehicle_classes_hold_and_what_is_left_out_neither_drives_nor_parks() {
    use ObjectClass::{Car, Truck, Van};
    let classes = |vehicle_shares: Vec<(ObjectClass, f64)>| {
        let config = TrafficConfig { num_cars: 60, num_pedestrians: 5, vehicle_shares, ..TrafficConfig::default() };
        let actors = filled_as(suburb(1), 1, &config).snapshot().actors;
        let count = |class: ObjectClass| actors.iter().filter(|a| a.class == class).count();
        (count(Car), count(Van), actors.len())
    };
    let (cars, vans, _) = classes(Vec::new());
    assert!(vans >= 3, "{vans} vans among {cars} cars");
    let (only_cars, no_vans, _) = classes(vec![(Car, 3.0)]);
    assert_eq!(no_vans, 0);
    assert!(only_cars as f64 > 0.9 * (cars + vans) as f64, "{only_cars} cars in place of {cars} and {vans} vans");
    let (some_cars, half_vans, _) = classes(vec![(Car, 1.0), (Van, 1.0)]);
    // Vans that do not fit into a parking place give it to a car.
    assert!(half_vans > some_cars / 3 && half_vans < some_cars, "{half_vans} vans, {some_cars} cars");
    let (no_cars, only_vans, num_all) = classes(vec![(Van, 0.1), (Car, 0.0)]);
    assert_eq!((no_cars, only_vans), (0, num_all - 5), "the others are people");
    let mut world = World::new(slope(0.0), StreamKey::scene(0)).unwrap();
    for shares in [vec![(Truck, 1.0)], vec![(Car, -1.0)], vec![(Car, 1.0), (ObjectClass::Tram, 1.0)]] {
        let none = TrafficConfig { vehicle_shares: shares, ..TrafficConfig::default() };
        assert!(world.spawn_traffic(&none).is_err());
    }
}
