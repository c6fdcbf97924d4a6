//! Trams on their tracks, among traffic and people.

use super::towns::{slope, tram_roads};
use super::*;
use crate::agents::Tram;
use crate::lane_use::LaneUse;
use cadet_town::{LaneId, LaneKind, Town};

/// The trams.
pub(super) fn trains(world: &World) -> Vec<(&Agent, &Tram)> {
    all(world)
}

/// What the cars of a train cover, the first ahead.
fn cars_of(world: &World, tram: &Tram) -> Vec<Footprint> {
    tram.cars.iter().map(|car| car.own.view().footprint(&world.arena.physics)).collect()
}

/// Towns with tracks: some have their faster streets at the border, where no tram runs.
pub(super) fn towns_with_tracks(count: usize) -> Vec<(u64, Arc<Town>)> {
    let towns = (0..40).map(|seed| (seed, tram_roads(seed)));
    let found: Vec<_> = towns.filter(|(_, town)| town.network.tracks().next().is_some()).take(count).collect();
    assert_eq!(found.len(), count);
    found
}

pub(super) fn busy(seed: u64, town: &Arc<Town>) -> World {
    let config =
        TrafficConfig { num_cars: 30, num_pedestrians: 20, num_cyclists: 6, num_trams: 4, ..TrafficConfig::default() };
    filled_as(Arc::clone(town), seed, &config)
}

#[test]
fn trams_keep_to_their_tracks_stay_coupled_and_touch_nobody_for_minutes() {
    let (mut num_trains, mut gone_m, mut longest_s, mut crossed) = (0, 0.0, 0.0_f64, 0);
    for (seed, town) in towns_with_tracks(6) {
        let mut world = busy(seed, &town);
        num_trains += trains(&world).len();
        for tick in 0..300 {
            world.step(15);
            let is_other = |a: &&Agent| a.get::<Tram>().is_none() && a.actor().body.person().is_none();
            let others = world.arena.active().map(|(_, agent)| agent).filter(is_other);
            let others = boxes(&world, others.chain(parked(&world)));
            let trains = trains(&world);
            for (k, (agent, driver)) in trains.iter().enumerate() {
                let own_cars = cars_of(&world, driver);
                for own in &own_cars {
                    let at = own.center;
                    for (id, other) in &others {
                        assert!(!own.overlaps(other), "seed {seed}, tick {tick}: tram {} in {id} at {at}", agent.id);
                    }
                    for other in trains[..k].iter().flat_map(|(_, other)| cars_of(&world, other)) {
                        assert!(!own.overlaps(&other), "seed {seed}, tick {tick}: two trams at {at}");
                    }
                    for (walker, _) in walkers(&world) {
                        let apart_m = own.distance_m(place(&world, walker));
                        assert!(apart_m > 0.15, "seed {seed}, tick {tick}: tram {} in {}", agent.id, walker.id);
                    }
                    // Both ends, and the middle, are over a track, but for the chord of 10.5 m in a bend of 20 m.
                    for t in [-1.0, 0.0, 1.0] {
                        let p = own.center + own.heading * (t * (own.half_length_m - 2.4).max(0.5));
                        let off_m = town.network.tracks().map(|l| l.project(p.extend(0.0)).1).fold(9.0, f64::min);
                        assert!(off_m < 0.7, "seed {seed}, tick {tick}: {} is {off_m} m off at {p}", agent.id);
                    }
                    gone_m += own.velocity.length() / 4.0;
                }
                let is_at_end = driver.train.is_at_end();
                let stood_s = driver.standing_steps as f64 * DT_S;
                longest_s = longest_s.max(if is_at_end { 0.0 } else { stood_s });
                assert!(is_at_end || stood_s < 60.0, "seed {seed}: {} stands, {:?}", agent.id, driver.cause());
                let lane = driver.train.track.position(driver.train.front_m).lane;
                crossed += usize::from(town.network.lane(lane).junction.is_some());
                for pair in own_cars.windows(2) {
                    let [a, b] = [0, 1].map(|i| &pair[i]);
                    let gap_m =
                        (a.center - a.heading * a.half_length_m - b.center - b.heading * b.half_length_m).length();
                    assert!(gap_m < 0.15, "seed {seed}, tick {tick}: {gap_m} m between two cars");
                }
            }
        }
        nobody_stands(&world, 60.0, &format!("seed {seed}"));
    }
    assert!(num_trains >= 5, "{num_trains} trams");
    assert!(gone_m > 1000.0 && crossed > 10, "{gone_m} m in all, {crossed} looks in junctions, {longest_s} s stood");
}

/// A track across a junction, and a way for cars that crosses it.
fn crossing_of_a_track(graph: &LaneGraph) -> (LaneId, LaneId) {
    let junctions = Junctions::new(graph);
    let track = graph.lanes().iter().find(|l| l.kind == LaneKind::Tram && l.junction.is_some()).expect("a crossing");
    let is_road = |l: &LaneId| graph.lane(*l).kind == LaneKind::Driving;
    (track.id, junctions.conflicts_of(track.id).into_iter().find(is_road).expect("a way across"))
}

#[test]
fn a_tram_goes_first_where_a_car_has_waited_longer() {
    let (_, town) = towns_with_tracks(1).remove(0);
    let graph = LaneGraph::new(Arc::clone(&town));
    let (track, crossing) = crossing_of_a_track(&graph);
    let mut junctions = Junctions::new(&graph);
    let (first, car, tram) = (1, 2, 3);
    let waits = Request::of_car(car, &[crossing]);
    let comes = |slot| Request { is_tram: true, ..Request::of_car(slot, &[track]) };
    junctions.resolve(&[comes(first)], &LaneUse::default(), &graph, 0);
    for step in (3..3000).step_by(3) {
        junctions.resolve(std::slice::from_ref(&waits), &LaneUse::default(), &graph, step);
        assert_eq!(junctions.refusal(car), Refusal::Taken(first));
    }
    // The car has waited for long, but the next tram asks now.
    junctions.forget(first);
    junctions.resolve(&[waits, comes(tram)], &LaneUse::default(), &graph, 3000);
    assert!(junctions.holds(tram, track));
    assert_eq!(junctions.refusal(car), Refusal::Taken(tram));
}

#[test]
fn trams_come_one_after_the_other() {
    for (seed, town) in towns_with_tracks(3) {
        let mut world = busy(seed, &town);
        let leaders = |world: &World| -> Vec<(i32, f64, LaneId)> {
            let drivers = trains(world).into_iter();
            drivers.map(|(a, d)| (a.id, d.train.front_m, d.train.track.position(0.0).lane)).collect()
        };
        let start = leaders(&world);
        for (k, a) in start.iter().enumerate() {
            for b in &start[..k] {
                assert!(a.2 != b.2 || (a.1 - b.1).abs() > 70.0, "seed {seed}: {a:?} and {b:?}");
            }
        }
        let mut known: Vec<i32> = start.iter().map(|a| a.0).collect();
        let mut last_s = f64::NEG_INFINITY;
        for second in 0..180 {
            world.step(SECOND);
            for (id, ..) in leaders(&world) {
                if !known.contains(&id) {
                    known.push(id);
                    let pause_s = f64::from(second) - last_s;
                    assert!(pause_s >= 9.0, "seed {seed}: a tram comes after {pause_s} s");
                    last_s = f64::from(second);
                }
            }
        }
    }
}

#[test]
fn without_tracks_there_are_no_trams_and_worlds_stay_as_they_were() {
    let poses = |num_trams: usize| {
        let mut world = filled_as(suburb(3), 3, &TrafficConfig { num_trams, ..TrafficConfig::default() });
        world.step(300);
        world.snapshot().actors.iter().map(|a| (a.id, a.world_from_box.translation)).collect::<Vec<_>>()
    };
    assert_eq!(poses(0), poses(5));
}

#[test]
fn a_tram_can_be_added_and_led() {
    let mut world = World::new(slope(0.0), StreamKey::scene(0)).unwrap();
    let course = Course::Straight { x_m: 10.0, y_m: 6.0, yaw_rad: 0.0, speed_mps: 8.0 };
    let id = put(&mut world, ObjectClass::Tram, 4, &course);
    world.step(SECOND);
    let tram = actor(&world, id);
    assert!((tram.world_from_box.translation.x - 18.0).abs() < 0.05, "{}", tram.world_from_box.translation);
    assert!(tram.class == ObjectClass::Tram && (13.0..16.0).contains(&tram.size_lwh.x));
    assert!(add(&mut world, ObjectClass::Tram, 18.0, 6.0, 0.0, 1).is_err());
}
