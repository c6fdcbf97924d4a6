//! Turn signals tell where a car goes, and flash; cyclists point there.

use std::cmp::Ordering;
use std::collections::BTreeMap;

use super::lamps::is_amber;
use super::*;
use crate::look::{Ride, TurnSignal};

/// Which sides of each vehicle's signals shine: left and right, by its id.
fn lit(world: &World) -> BTreeMap<i32, [bool; 2]> {
    let bodies = world.snapshot().instances.into_iter().filter(|i| i.actor_id > 0 && i.is_body);
    bodies
        .map(|i| {
            // The lenses of the left side come first in every vehicle's palette.
            let materials = i.palette.materials();
            let signals = materials.get(21..23).map_or([false; 2], |lenses| [0, 1].map(|k| is_amber(&lenses[k])));
            (i.actor_id, signals)
        })
        .collect()
}

fn busy(seed: u64, num_cyclists: usize) -> World {
    filled(suburb(seed), seed, [24, 0, num_cyclists])
}

/// The yaw of a body, and whether it is on a lane of a junction.
fn heading(world: &World, agent: &Agent) -> f64 {
    let x = agent.actor().body.world_from_box(&world.arena.physics).rotation * DVec3::X;
    math::atan2(x.y, x.x)
}

fn is_in_junction(world: &World, agent: &Agent) -> bool {
    let lane = agent.behavior().on_lane(0).map(|at| at.lane);
    lane.is_some_and(|lane| world.arena.streets.graph.lane(lane).junction.is_some())
}

/// What somebody showed while in a junction and just before, and how far they turned there.
#[derive(Default)]
struct Passage {
    began: f64,
    shown: [u32; 2],
}

/// Counts what was shown in two minutes on ways through junctions: by straight on, left, right; none, left, right.
fn count_passages(
    tally: &mut [[u32; 3]; 3],
    (mut world, before_looks): (World, usize),
    moves: impl Fn(&Agent) -> bool,
    shown: impl Fn(&World) -> BTreeMap<i32, [bool; 2]>,
) {
    let (mut inside, mut before) = (BTreeMap::<i32, Passage>::new(), BTreeMap::new());
    for _ in 0..480 {
        world.step(SECOND / 4);
        let shown = shown(&world);
        for (_, agent) in world.arena.active().filter(|(_, a)| moves(a)) {
            let yaw = heading(&world, agent);
            let sides = shown.get(&agent.id).copied().unwrap_or_default();
            let recent: &mut Vec<[bool; 2]> = before.entry(agent.id).or_default();
            recent.push(sides);
            if recent.len() > before_looks {
                recent.remove(0);
            }
            if is_in_junction(&world, agent) {
                let start = || {
                    let count = |k: usize| recent.iter().filter(|s| s[k]).count() as u32;
                    Passage { began: yaw, shown: [count(0), count(1)] }
                };
                let passage = inside.entry(agent.id).or_insert_with(start);
                for (count, is_lit) in passage.shown.iter_mut().zip(sides) {
                    *count += u32::from(is_lit);
                }
            } else if let Some(passage) = inside.remove(&agent.id) {
                let turned = math::wrap_angle(yaw - passage.began);
                let way = match turned {
                    0.8.. => 1,
                    ..-0.8 => 2,
                    -0.3..=0.3 => 0,
                    _ => continue,
                };
                let [left, right] = passage.shown;
                let side = match left.cmp(&right) {
                    Ordering::Equal => 0,
                    Ordering::Greater => 1,
                    Ordering::Less => 2,
                };
                tally[way][side] += 1;
            }
        }
    }
}

#[test]
fn who_turns_off_signals_to_that_side_and_who_goes_straight_on_does_not() {
    let mut tally = [[0; 3]; 3];
    for seed in [3, 5] {
        count_passages(&mut tally, (busy(seed, 0), 16), |a| a.get::<Car>().is_some() && a.id > 0, lit);
    }
    let [straight, left, right] = tally;
    assert!(left[1] >= 4 && left[0] + left[2] == 0, "{tally:?}");
    assert!(right[2] >= 4 && right[0] + right[1] == 0, "{tally:?}");
    assert!(straight[0] >= 4 && straight[1] + straight[2] <= straight[0] / 10, "{tally:?}");
}

fn show(agent: &mut Agent, signal: TurnSignal) {
    if let Some(car) = agent.get_mut::<Car>() {
        car.own.look.signal = signal;
    } else if let Some(Fixture::Vehicle(car)) = agent.get_mut() {
        car.look.signal = signal;
    }
}

#[test]
fn signals_flash_ninety_times_a_minute_lit_half_of_the_time() {
    let mut world = busy(3, 0);
    world.step(2 * SECOND);
    let (id, slot) = {
        let (slot, agent, _) = world.arena.each::<Car>().find(|(_, a, _)| a.id > 0).unwrap();
        (agent.id, slot)
    };
    // Parked behind a script of its own: what it shows stays.
    let mut states = Vec::new();
    for _ in 0..4 * SECOND {
        world.step(1);
        show(&mut world.arena.agents[slot], TurnSignal::Hazard);
        let sides = lit(&world)[&id];
        assert_eq!(sides[0], sides[1], "both sides flash together");
        states.push(sides[0]);
    }
    let lit_share = states.iter().filter(|lit| **lit).count() as f64 / states.len() as f64;
    let flashes = states.windows(2).filter(|w| !w[0] && w[1]).count();
    assert!((lit_share - 0.5).abs() < 0.02 && flashes == 6, "{flashes} flashes in 4 s, lit for {lit_share}");
    let phases: Vec<bool> = {
        for k in 1..world.arena.agents.len() {
            show(&mut world.arena.agents[k], TurnSignal::Left);
        }
        lit(&world).values().map(|sides| sides[0]).collect()
    };
    let lit_now = phases.iter().filter(|lit| **lit).count();
    assert!(lit_now * 4 > phases.len() && lit_now * 4 < 3 * phases.len(), "{lit_now} of {}", phases.len());
}

#[test]
fn cyclists_point_where_they_turn_and_nowhere_else() {
    let arms = |world: &World| {
        let arm = |ride: &Ride| [ride.arm_share > 0.5, ride.arm_share < -0.5];
        cyclists(world).into_iter().map(|(agent, rider)| (agent.id, arm(&rider.own.look.ride))).collect()
    };
    let mut tally = [[0; 3]; 3];
    for seed in [3, 5, 8] {
        count_passages(&mut tally, (busy(seed, 24), 48), |a| a.get::<Cyclist>().is_some(), arms);
    }
    let [straight, left, right] = tally;
    // Some never point, and who comes to the junction at a crawl keeps both hands on the bar.
    assert!(left[1] >= 3 && left[2] == 0 && 3 * left[1] >= 2 * left[0], "{tally:?}");
    assert!(right[2] >= 3 && right[1] == 0 && 3 * right[2] >= 2 * right[0], "{tally:?}");
    assert!(straight[0] >= 3 && straight[1] + straight[2] == 0, "{tally:?}");
}
