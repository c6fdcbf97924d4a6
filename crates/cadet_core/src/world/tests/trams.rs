//! Trams on their tracks, among traffic and people.

use super::towns::{slope, tram_roads};
use super::*;
use crate::town::{LaneId, LaneKind, Town};
use crate::world::DT_S;
use crate::world::control::{Train, TramCar};

fn tram_cars(world: &World) -> Vec<(&Agent, &TramCar)> {
    world.arena.controlled_by::<TramCar>().map(|(_, agent, car)| (agent, car)).collect()
}

/// The cars of each tram, the first ahead.
pub(super) fn trains(world: &World) -> Vec<Vec<(&Agent, &TramCar)>> {
    let cars = tram_cars(world);
    let leaders = cars.iter().filter(|(_, car)| car.leads());
    leaders.map(|(_, leader)| cars.iter().filter(|(_, car)| car.is_of_train_of(leader)).copied().collect()).collect()
}

/// Towns with tracks: some have their faster streets at the border, where no tram runs.
pub(super) fn towns_with_tracks(count: usize) -> Vec<(u64, Arc<Town>)> {
    let towns = (0..40).map(|seed| (seed, tram_roads(seed)));
    let found: Vec<_> = towns.filter(|(_, town)| town.network.tracks().next().is_some()).take(count).collect();
    assert_eq!(found.len(), count);
    found
}

pub(super) fn busy(seed: u64, town: &Arc<Town>) -> World {
    let mut world = World::new(Arc::clone(town), StreamKey::scene(seed)).unwrap();
    let config =
        TrafficConfig { num_cars: 30, num_pedestrians: 20, num_cyclists: 6, num_trams: 4, ..TrafficConfig::default() };
    world.spawn_traffic(&config).unwrap();
    world
}

#[test]
fn trams_keep_to_their_tracks_stay_coupled_and_touch_nobody_for_minutes() {
    let (mut num_trains, mut gone_m, mut longest_s, mut crossed) = (0, 0.0, 0.0_f64, 0);
    for (seed, town) in towns_with_tracks(6) {
        let mut world = busy(seed, &town);
        num_trains += trains(&world).len();
        for tick in 0..300 {
            world.step(15);
            let others = world
                .arena
                .active()
                .filter(|(_, agent)| agent.class != ObjectClass::Tram && !matches!(agent.body, Body::Upright(_)));
            let others: Vec<(i32, Footprint)> =
                others.map(|(_, a)| a).chain(parked(&world)).map(|a| (a.id, footprint(&world, a))).collect();
            let trains = trains(&world);
            for (k, train) in trains.iter().enumerate() {
                for (agent, car) in train {
                    let (own, at) = (footprint(&world, agent), place(&world, agent));
                    for (id, other) in &others {
                        assert!(!own.overlaps(other), "seed {seed}, tick {tick}: tram {} in {id} at {at}", agent.id);
                    }
                    for other in trains[..k].iter().flatten() {
                        let other = footprint(&world, other.0);
                        assert!(!own.overlaps(&other), "seed {seed}, tick {tick}: two trams at {at}");
                    }
                    for (walker, _) in walkers(&world) {
                        let apart_m = (own.closest_point(place(&world, walker)) - place(&world, walker)).length();
                        assert!(apart_m > 0.15, "seed {seed}, tick {tick}: tram {} in {}", agent.id, walker.id);
                    }
                    // Both ends, and the middle, are over a track, but for the chord of 10.5 m in a bend of 20 m.
                    for t in [-1.0, 0.0, 1.0] {
                        let p = own.center + own.heading * (t * (own.half_length_m - 2.4).max(0.5));
                        let off_m = town.network.tracks().map(|l| l.project(p.extend(0.0)).1).fold(9.0, f64::min);
                        assert!(off_m < 0.7, "seed {seed}, tick {tick}: {} is {off_m} m off at {p}", agent.id);
                    }
                    gone_m += own.velocity.length() / 4.0;
                    if car.leads() {
                        let cause = car.cause();
                        let is_at_end = car.shared().is_at_end();
                        let stood_s = car.standing_steps() as f64 * DT_S;
                        longest_s = longest_s.max(if is_at_end { 0.0 } else { stood_s });
                        assert!(is_at_end || stood_s < 60.0, "seed {seed}: {} stands, {cause:?}", agent.id);
                        let shared = car.shared();
                        let lane = shared.track.lane_at(shared.front_m).0;
                        crossed += usize::from(town.network.lane(lane).junction.is_some());
                    }
                }
                for pair in train.windows(2) {
                    let [a, b] = [0, 1].map(|i| footprint(&world, pair[i].0));
                    let gap_m =
                        (a.center - a.heading * a.half_length_m - b.center - b.heading * b.half_length_m).length();
                    assert!(gap_m < 0.15, "seed {seed}, tick {tick}: {gap_m} m between two cars");
                }
            }
        }
        for (agent, driver) in cars(&world) {
            let stood_s = driver.standing_steps as f64 * DT_S;
            assert!(stood_s < 60.0, "seed {seed}: {} stands for {stood_s} s, {:?}", agent.id, driver.cause());
        }
    }
    assert!(num_trains >= 5, "{num_trains} trams");
    assert!(gone_m > 1000.0 && crossed > 10, "{gone_m} m in all, {crossed} looks in junctions, {longest_s} s stood");
}

fn asked(car: crate::world::slot::Slot, has_priority: bool, lanes: &[LaneId], exit: LaneId) -> Request<'_> {
    Request { car, lanes, exit, room_m: 1.0, exit_blocked_by: None, yields_to_oncoming: false, has_priority }
}

#[test]
fn a_tram_goes_first_where_a_car_waits_too() {
    let (_, town) = towns_with_tracks(1).remove(0);
    let roads = Roads::new(Arc::clone(&town));
    let junctions = Junctions::new(&roads);
    let track = roads.lanes().iter().find(|l| l.kind == LaneKind::Tram && l.junction.is_some()).expect("a crossing");
    let crossed = junctions.conflicts_of(track.id);
    let crossing: Vec<LaneId> =
        crossed.into_iter().filter(|l| town.network.lane(*l).kind == LaneKind::Driving).collect();
    assert!(!crossing.is_empty());
    let mut junctions = Junctions::new(&roads);
    let (first, car, tram) = (1, 2, 3);
    // Somebody crosses; a car waits for the other way, then the tram comes.
    junctions.request(&asked(first, false, &[crossing[0]], track.id), 0).unwrap();
    assert_eq!(junctions.request(&asked(tram, true, &[track.id], track.id), 10), Err(Refusal::Taken(first)));
    junctions.forget(first);
    assert_eq!(junctions.request(&asked(car, false, &[crossing[0]], track.id), 12), Err(Refusal::Earlier(tram)));
    junctions.request(&asked(tram, true, &[track.id], track.id), 13).unwrap();
    assert_eq!(junctions.request(&asked(car, false, &[crossing[0]], track.id), 14), Err(Refusal::Taken(tram)));
}

#[test]
fn who_waits_for_room_behind_a_junction_keeps_its_place() {
    let (_, town) = towns_with_tracks(1).remove(0);
    let roads = Roads::new(Arc::clone(&town));
    let mut junctions = Junctions::new(&roads);
    let is_road = |l: &LaneId| roads.lane(*l).kind == LaneKind::Driving;
    let (ours, theirs) = (roads.lanes().iter())
        .filter(|l| l.kind == LaneKind::Driving && l.junction.is_some())
        .find_map(|l| Some((l.id, junctions.conflicts_of(l.id).into_iter().find(is_road)?)))
        .expect("two ways that cross");
    let (early, late, third) = (1, 2, 3);
    junctions.request(&asked(third, false, &[ours], ours), 0).unwrap();
    let lanes = [ours];
    let blocked = Request { exit_blocked_by: Some(9), ..asked(early, false, &lanes, ours) };
    assert_eq!(junctions.request(&blocked, 1), Err(Refusal::ExitFull(9)));
    assert_eq!(junctions.request(&asked(late, false, &[theirs], theirs), 5), Err(Refusal::Taken(third)));
    junctions.forget(third);
    // Once its exit is free, who came first goes first.
    assert_eq!(junctions.request(&asked(early, false, &[ours], ours), 10), Ok(()));
}

#[test]
fn a_car_that_waits_longer_than_a_tram_still_lets_it_go() {
    let (_, town) = towns_with_tracks(1).remove(0);
    let roads = Roads::new(Arc::clone(&town));
    let mut junctions = Junctions::new(&roads);
    let track = roads.lanes().iter().find(|l| l.kind == LaneKind::Tram && l.junction.is_some()).expect("a crossing");
    let is_road = |l: &LaneId| town.network.lane(*l).kind == LaneKind::Driving;
    let crossing = junctions.conflicts_of(track.id).into_iter().find(is_road).expect("a way across");
    let other = junctions.conflicts_of(crossing).into_iter().find(|l| is_road(l)).expect("another way");
    junctions.request(&asked(9, false, &[other], track.id), 0).unwrap();
    assert!(junctions.request(&asked(2, false, &[crossing], track.id), 1).is_err());
    junctions.forget(9);
    // The car came first, but the tram asks now.
    assert_eq!(junctions.request(&asked(3, true, &[track.id], track.id), 2), Ok(()));
}

#[test]
fn who_waits_for_a_tram_holds_up_nobody_whose_way_is_free() {
    let (_, town) = towns_with_tracks(1).remove(0);
    let roads = Roads::new(Arc::clone(&town));
    let mut junctions = Junctions::new(&roads);
    let is_road = |l: &LaneId| town.network.lane(*l).kind == LaneKind::Driving;
    let of = |junctions: &Junctions, lane: LaneId| -> Vec<LaneId> { junctions.conflicts_of(lane) };
    // A track, a way that crosses it, and one that crosses that way but not the track.
    let (track, blocked, free) = roads
        .lanes()
        .iter()
        .filter(|l| l.kind == LaneKind::Tram && l.junction.is_some())
        .find_map(|track| {
            let across = of(&junctions, track.id);
            let (blocked, free) = across.iter().filter(|l| is_road(l)).find_map(|blocked| {
                let free = of(&junctions, *blocked).into_iter().find(|l| is_road(l) && !across.contains(l))?;
                Some((*blocked, free))
            })?;
            Some((track.id, blocked, free))
        })
        .expect("a junction with such ways");
    let (tram, waiting, third) = (1, 2, 3);
    junctions.request(&asked(tram, true, &[track], track), 0).unwrap();
    assert_eq!(junctions.request(&asked(waiting, false, &[blocked], track), 1), Err(Refusal::Taken(tram)));
    assert_eq!(junctions.request(&asked(third, false, &[free], track), 2), Ok(()));
    // Once the tram is over, who came first goes first.
    junctions.forget(third);
    junctions.forget(tram);
    junctions.request(&asked(9, false, &[free], track), 3).unwrap();
    assert_eq!(junctions.request(&asked(waiting, false, &[blocked], track), 4), Err(Refusal::Taken(9)));
    junctions.forget(9);
    assert_eq!(junctions.request(&asked(third, false, &[free], track), 5), Err(Refusal::Earlier(waiting)));
}

#[test]
fn trams_come_one_after_the_other() {
    for (seed, town) in towns_with_tracks(3) {
        let mut world = busy(seed, &town);
        let leaders = |world: &World| -> Vec<(i32, f64, LaneId)> {
            let cars = tram_cars(world);
            let leaders = cars.iter().filter(|(_, car)| car.leads());
            let place = |train: &Train| (train.front_m, train.track.lane_at(0.0).0);
            leaders.map(|(a, car)| (a.id, place(&car.shared()))).map(|(id, (m, lane))| (id, m, lane)).collect()
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
        let mut world = World::new(suburb(3), StreamKey::scene(3)).unwrap();
        world.spawn_traffic(&TrafficConfig { num_trams, ..TrafficConfig::default() }).unwrap();
        world.step(300);
        world.snapshot().actors.iter().map(|a| (a.id, a.world_from_box.translation)).collect::<Vec<_>>()
    };
    assert_eq!(poses(0), poses(5));
}

#[test]
fn a_tram_can_be_added_and_led() {
    let mut world = World::new(slope(0.0), StreamKey::scene(0)).unwrap();
    let course = Course::Straight { x_m: 10.0, y_m: 6.0, yaw_rad: 0.0, speed_mps: 8.0 };
    let id = world.add(ObjectClass::Tram, ModelChoice::Seed(4), &course, Overlap::Refuse).unwrap();
    world.step(SECOND);
    let snapshot = world.snapshot();
    let tram = snapshot.actors.iter().find(|a| a.id == id).unwrap();
    assert!((tram.world_from_box.translation.x - 18.0).abs() < 0.05, "{}", tram.world_from_box.translation);
    assert!(tram.class == ObjectClass::Tram && (13.0..16.0).contains(&tram.size_lwh.x));
    assert!(add(&mut world, ObjectClass::Tram, 18.0, 6.0, 0.0, 1).is_err());
}
