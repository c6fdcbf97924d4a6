//! That traffic flows: how often the ego stands where views are taken, and for how long.

use super::towns::suburb;
use super::*;
use crate::driving::Cause;

/// What the ego brakes for, and where the people on the road near it are and want to go.
fn what_stops_the_ego(world: &World) -> String {
    let cause = cars(world)[0].1.cause();
    if cause != Cause::Person {
        return format!("{cause:?}");
    }
    let ego = footprint(world, world.arena.ego());
    let walkers = walkers(world);
    let graph = &world.arena.streets.graph;
    let near = |(w, _): &&(&Agent, &Pedestrian)| (place(world, w) - ego.center).length() < 12.0;
    let on_road = |(_, pedestrian): &&(&Agent, &Pedestrian)| pedestrian.on_road(graph).is_some();
    let on_road = walkers.iter().filter(on_road).filter(near).map(|(w, pedestrian)| {
        let p = place(world, w);
        let away = |o: &Footprint| (o.closest_point(p) - p).length();
        let nearest = |all: &mut dyn Iterator<Item = f64>| all.fold(f64::INFINITY, f64::min);
        let parked_m = nearest(&mut parked(world).iter().map(|a| away(&footprint(world, a))));
        let car_m = nearest(&mut cars(world).iter().map(|(a, _)| away(&footprint(world, a))));
        let others = walkers.iter().filter(|(o, _)| o.id != w.id);
        let person_m = nearest(&mut others.map(|(o, _)| (place(world, o) - p).length()));
        format!(
            "{} at {p}, {:?}, {:.2} m/s; parked {parked_m:.2} m, car {car_m:.2} m (ego {:.2} m), person {person_m:.2} m away",
            w.id,
            pedestrian.motion,
            w.actor().body.velocity_world(&world.arena.physics).length(),
            away(&ego)
        )
    });
    format!("Person: {:?}", on_road.collect::<Vec<_>>())
}

/// Views at which the ego stands, and what it braked for at each view of the longest run of them, over `views` views of a
/// drive.
fn standing_views(world: &mut World, views: u32) -> (u32, Vec<String>) {
    let (mut standing, mut run, mut longest) = (0, Vec::new(), Vec::new());
    world.step(120);
    for view in 0..views {
        if view > 0 {
            world.drive(10.0, 2.0).unwrap();
        }
        let stands = world.ego().velocity_world.length() < 0.1;
        standing += u32::from(stands);
        if stands {
            run.push(what_stops_the_ego(world));
        } else {
            run.clear();
        }
        if run.len() > longest.len() {
            longest.clone_from(&run);
        }
    }
    (standing, longest)
}

#[test]
fn the_ego_seldom_stands_where_views_are_taken() {
    let (mut standing, mut longest) = (0, Vec::new());
    let (num_suburbs, num_views) = (10, 20);
    for seed in 0..num_suburbs {
        let mut world = World::new(suburb(seed), StreamKey::scene(seed)).unwrap();
        // From quiet streets to main roads.
        let num_cars = [8, 14, 20, 28][seed as usize % 4];
        let config = TrafficConfig { num_cars, num_pedestrians: 24, ..TrafficConfig::default() };
        world.spawn_traffic(&config).unwrap();
        let (views, run) = standing_views(&mut world, num_views);
        standing += views;
        if run.len() > longest.len() {
            longest = run;
            longest[0] = format!("seed {seed}: {}", longest[0]);
        }
    }
    let share = f64::from(standing) / (num_suburbs as f64 * f64::from(num_views));
    assert!(share <= 0.16, "the ego stands at {share:.3} of the views");
    // Twenty seconds: who has to yield loses patience after 18.
    assert!(longest.len() <= 10, "the ego stands for {} views in a row: {longest:?}", longest.len());
}

#[test]
fn who_would_swing_into_somebody_for_ever_takes_another_way() {
    let mut turned = 0;
    for seed in 0..60 {
        let town = crossing();
        let mut world = World::new(Arc::clone(&town), StreamKey::scene(seed)).unwrap();
        let graph = &LaneGraph::new(town);
        let route = cars(&world)[0].1.route.clone().unwrap();
        let Some(k) = route.lanes.iter().position(|l| graph.lane(*l).junction.is_some()) else { continue };
        let (before, wanted) = (graph.lane(route.lanes[k - 1]), graph.lane(route.lanes[k]));
        let start = (wanted.center[1] - wanted.center[0]).truncate();
        let through = (wanted.center[wanted.center.len() - 1] - wanted.center[0]).truncate();
        if start.normalize().perp_dot(through) > -3.0 {
            continue;
        }
        // At the line of the arm that is turned into, too near to the lane that leads into it.
        let line_m = before.length_m() - route.s_m + wanted.length_m() + 6.0;
        let exit = route.ahead(line_m, graph);
        let at = exit.at + exit.tangent.perp() * 2.1;
        let waypoint = |t_s: f64, p: DVec2| Waypoint { t_s, x_m: p.x, y_m: p.y };
        let stands_there = Course::Path(vec![waypoint(0.0, at + exit.tangent * 0.01), waypoint(1.0, at)]);
        world.add(ObjectClass::Van, ModelChoice::Seed(3), &stands_there, Overlap::Refuse).unwrap();
        let from_m = position(&world, world.arena.ego());
        let waits = |world: &mut World| {
            world.step(SECOND);
            matches!(cars(world)[0].1.cause(), Cause::Junction(Refusal::InSweep(_)))
        };
        assert!((0..30).any(|_| waits(&mut world)), "seed {seed}: {:?}", cars(&world)[0].1.cause());
        world.step(50 * SECOND);
        let taken = &cars(&world)[0].1.route.as_ref().unwrap().lanes;
        let gone_m = (position(&world, world.arena.ego()) - from_m).length();
        assert!(!taken.contains(&before.id), "seed {seed}: stands after {gone_m} m, {:?}", cars(&world)[0].1.cause());
        turned += 1;
    }
    assert!(turned >= 3, "{turned}");
}
