//! What people have along: in which weather, how many, and that it meets nobody.

use std::collections::BTreeSet;

use super::*;
use crate::look::PersonLook;
use cadet_base::math::DPose3;

fn town_people(seed: u64, rains: bool) -> World {
    let mut world = World::new(suburb(seed), StreamKey::scene(seed)).unwrap().with_rain(rains);
    let config = TrafficConfig { num_cars: 6, num_pedestrians: 40, ..TrafficConfig::default() };
    world.spawn_traffic(&config).unwrap();
    world
}

/// What the people on foot have along, by their ids; empty for nothing.
fn things(world: &World) -> Vec<(i32, String)> {
    let thing = |name: &str| {
        let kind = name.split('/').next().unwrap_or_default();
        kind.split_once(" with ").map(|(_, thing)| thing.to_owned()).unwrap_or_default()
    };
    walkers(world).into_iter().map(|(agent, _)| (agent.id, thing(agent.actor().look.model().name))).collect()
}

#[test]
fn half_of_the_people_have_umbrellas_in_rain_and_none_when_it_is_dry() {
    let share = |rains: bool, thing: &str| {
        let of_all: Vec<String> =
            (0..40).flat_map(|seed| things(&town_people(seed, rains))).map(|(_, thing)| thing).collect();
        of_all.iter().filter(|t| *t == thing).count() as f64 / of_all.len() as f64
    };
    assert_eq!(share(false, "umbrella"), 0.0);
    let wet = share(true, "umbrella");
    assert!((0.40..0.58).contains(&wet), "{wet}");
    let dry = ["pram", "dog", "case", "rollator"].map(|thing| share(false, thing));
    let [pram, dog, case, rollator] = dry;
    assert!((0.008..0.055).contains(&pram) && (0.012..0.055).contains(&dog), "{dry:?}");
    assert!((0.005..0.04).contains(&case) && (0.004..0.04).contains(&rollator), "{dry:?}");
    // 1 % of the adults have crutches, and a tenth of the old ones, who are 15 %, sticks.
    let [crutches, sticks] = [share(false, "crutches") + share(false, "crutch"), share(false, "stick")];
    assert!((0.003..0.02).contains(&crutches) && (0.005..0.028).contains(&sticks), "{crutches} {sticks}");
}

#[test]
fn who_walks_where_does_not_depend_on_what_they_have_along() {
    let (mut dry, mut wet) = (town_people(4, false), town_people(4, true));
    for _ in 0..10 {
        let poses = |world: &World| -> Vec<(i32, DPose3, DVec3)> {
            let actors = world.snapshot().actors;
            actors.into_iter().map(|a| (a.id, a.world_from_box, a.size_lwh)).collect()
        };
        assert_eq!(poses(&dry), poses(&wet));
        dry.step(SECOND);
        wet.step(SECOND);
    }
    let names = |world: &World| things(world).into_iter().filter(|(_, thing)| !thing.is_empty()).count();
    assert!(names(&wet) > names(&dry) + 8);
}

/// Middles of what stands on the ground beside or before its owner, with half its length and width.
fn footprints(world: &World) -> Vec<(i32, Footprint)> {
    let mut found = Vec::new();
    for (agent, walker) in walkers(world) {
        let PersonLook { model, phase } = &walker.own.look;
        let Some(belonging) = model.belonging.as_ref().filter(|b| b.is_solid()) else { continue };
        let bounds = belonging.pose(*phase).bounds;
        let pose = agent.actor().body.world_from_box(&world.arena.physics);
        let (center, half) = (bounds.center().as_dvec3(), bounds.size().as_dvec3() / 2.0);
        let heading = (pose.rotation * DVec3::X).truncate().normalize();
        let (center, z_m) = (pose.transform_point(center).truncate(), pose.translation.z);
        let (half_length_m, half_width_m) = (half.x, half.y);
        found.push((agent.id, Footprint { center, heading, half_length_m, half_width_m, z_m, velocity: DVec2::ZERO }));
    }
    found
}

#[test]
fn prams_and_cases_are_seldom_within_anything() {
    let (mut seen, mut in_people) = (0, 0);
    let (mut things, mut in_vehicles) = (BTreeSet::new(), BTreeSet::new());
    for seed in 0..16 {
        let mut world = town_people(seed, false);
        for _ in 0..60 {
            world.step(SECOND);
            let driven = cars(&world).into_iter().map(|(agent, _)| agent);
            let vehicles = boxes(&world, driven.chain(parked(&world)));
            let people: Vec<(i32, DVec2)> =
                walkers(&world).into_iter().map(|(a, _)| (a.id, place(&world, a))).collect();
            for (id, thing) in footprints(&world) {
                seen += 1;
                things.insert((seed, id));
                if vehicles.iter().any(|(_, v)| v.overlaps(&thing)) {
                    in_vehicles.insert((seed, id));
                }
                let touched = people.iter().any(|(other, at)| *other != id && thing.distance_m(*at) < 0.15);
                in_people += usize::from(touched);
            }
        }
    }
    assert!(seen > 300, "{seen}");
    assert!(in_people * 100 <= 8 * seen, "{in_people} of {seen}");
    assert!(in_vehicles.len() * 25 <= things.len(), "{} of {}", in_vehicles.len(), things.len());
}
