//! Traffic at lights: nobody runs a red one, queues dissolve, people cross when theirs is green.

use std::collections::BTreeMap;

use super::*;
use crate::DT_S;
use cadet_town::{Aspect, CrossingRule, LaneId, PropConfig, STOP_LINE_M, SuburbConfig, Town};

fn lit_town(seed: u64) -> Arc<Town> {
    let config = SuburbConfig { blocks: (2, 2), main_share: 0.6, signal_share: 1.0, ..SuburbConfig::default() };
    // Some suburbs as small as these have no fast street.
    let mut towns =
        (0..20).map(|k| towns::bare(seed + 100 * k, &config, PropConfig { clutter: 0.0, ..Default::default() }));
    towns.find(|town| !town.signals.junctions.is_empty()).expect("a town with lights")
}

fn traffic(seed: u64) -> World {
    filled(lit_town(seed), seed, [28, 40, 6])
}

/// By agent: the lane that it is on, and how far its front is from the lane's end.
fn fronts(world: &World) -> BTreeMap<i32, (LaneId, f64)> {
    let graph = &world.arena.streets.graph;
    let front = |agent: &Agent, lane: LaneId, s_m: f64| {
        let half_m = footprint(world, agent).half_length_m;
        (agent.id, (lane, graph.lane(lane).length_m() - s_m - half_m))
    };
    let cars = cars(world).into_iter().filter_map(|(a, d)| d.route.as_ref().map(|r| front(a, r.lanes[0], r.s_m)));
    let cyclists = cyclists(world).into_iter().map(|(a, c)| front(a, c.route.lanes[0], c.route.s_m));
    cars.chain(cyclists).collect()
}

#[test]
fn nobody_crosses_a_stop_line_on_red() {
    let (mut crossed, mut waited, mut on_yellow) = (0, 0, 0);
    for seed in 0..5 {
        let mut world = traffic(seed);
        let mut before = fronts(&world);
        for step in 0..150 * SECOND {
            world.step(1);
            let now = fronts(&world);
            let town = Arc::clone(world.town());
            for (id, (lane, front_m)) in &now {
                let Some(aspect) = town.signals.aspect(*lane, world.time_s()) else { continue };
                let is_held = matches!(aspect, Aspect::Red | Aspect::RedYellow);
                waited += usize::from(is_held && step % SECOND == 0 && *front_m < 12.0);
                let Some((was_on, was_m)) = before.get(id) else { continue };
                if was_on == lane && *was_m >= STOP_LINE_M.1 && *front_m < STOP_LINE_M.1 {
                    crossed += 1;
                    on_yellow += usize::from(aspect == Aspect::Yellow);
                    assert!(!is_held, "seed {seed}: {id} runs a red light at {:.1} s", world.time_s());
                }
            }
            before = now;
        }
    }
    assert!(crossed > 150 && waited > 300, "{crossed} crossed, {waited} seconds of waiting");
    assert!(on_yellow < crossed / 5, "{on_yellow} of {crossed} on yellow");
}

#[test]
fn queues_at_lights_dissolve_and_nothing_is_touched() {
    for seed in 0..4 {
        let mut world = traffic(seed);
        let name = format!("lights {seed}");
        for _ in 0..3 {
            let red_s = world.town().signals.junctions.iter().map(|j| j.plan.longest_red_s()).fold(0.0, f64::max);
            flows(&mut world, 60, (1.2, 60.0 + red_s), &name);
        }
    }
}

#[test]
fn people_step_onto_a_ford_only_on_their_green() {
    let (mut on_fords, mut waited) = (0, 0);
    for seed in 0..10 {
        let mut world = traffic(seed);
        let mut waiting: BTreeMap<i32, (DVec2, DVec2)> = BTreeMap::new();
        for _ in 0..150 * SECOND / 3 {
            world.step(3);
            let town = Arc::clone(world.town());
            for (walker, pedestrian) in walkers(&world) {
                match pedestrian.motion {
                    Motion::Waits { from, to, .. } => {
                        let rule = town.signals.crossing_rule(from, to);
                        assert_ne!(rule, CrossingRule::Nowhere, "seed {seed}: beside a ford");
                        waited += usize::from(matches!(rule, CrossingRule::Ford(_)));
                        waiting.insert(walker.id, (from, to));
                    }
                    Motion::Crosses { .. } => {
                        let Some((from, to)) = waiting.remove(&walker.id) else { continue };
                        if let CrossingRule::Ford(ford) = town.signals.crossing_rule(from, to) {
                            on_fords += 1;
                            let looked_s = world.time_s() - 3.0 * DT_S;
                            assert!(town.signals.may_walk(ford, looked_s), "seed {seed}: {} on red", walker.id);
                        }
                    }
                    _ => {
                        waiting.remove(&walker.id);
                    }
                }
            }
        }
    }
    assert!(on_fords > 20 && waited > 200, "{on_fords} crossed on fords, {waited} looks while waiting there");
}
