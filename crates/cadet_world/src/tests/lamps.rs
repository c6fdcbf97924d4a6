//! Brake lamps tell of braking, low beams of the weather.

use std::collections::BTreeMap;

use super::trams::{busy, towns_with_tracks, trains};
use super::*;
use cadet_base::instance::Instance;
use cadet_base::material::{Material, Pattern};

/// How many lenses' materials of each actor's body shine red and white, by its id; turn signals do not count.
fn shining(instances: &[Instance]) -> BTreeMap<i32, [usize; 2]> {
    let mut by_actor = BTreeMap::new();
    for instance in instances.iter().filter(|i| i.actor_id > 0) {
        let lamps = || instance.palette.materials().iter().filter(|m| m.pattern == Pattern::Lamp && !is_amber(m));
        let white = lamps().filter(|m| m.albedo[1] > 0.5).count();
        by_actor.insert(instance.actor_id, [lamps().count() - white, white]);
    }
    by_actor
}

/// Of a turn signal that is lit.
pub(super) fn is_amber(lens: &Material) -> bool {
    lens.pattern == Pattern::Lamp && (0.2..0.5).contains(&lens.albedo[1]) && lens.albedo[2] < 0.1
}

fn traffic(needs_lamps: bool) -> World {
    filled(suburb(3), 3, [20, 20, 0]).with_lamps(needs_lamps)
}

/// Speeds of what is driven, by id.
fn speeds(world: &World) -> BTreeMap<i32, f64> {
    let speed = |agent: &Agent| agent.actor().body.velocity_world(&world.arena.physics).length();
    cars(world).into_iter().skip(1).map(|(agent, _)| (agent.id, speed(agent))).collect()
}

#[test]
fn brake_lamps_shine_when_a_car_slows_or_waits_and_not_when_it_gains_speed() {
    let (mut world, (mut slowing, mut waiting, mut gaining)) = (traffic(false), ([0; 2], [0; 2], [0; 2]));
    for _ in 0..120 {
        let before = speeds(&world);
        world.step(SECOND / 2);
        let (after, shining) = (speeds(&world), shining(&world.snapshot().instances));
        for (id, speed) in &after {
            let (Some(last), Some([red, white])) = (before.get(id), shining.get(id)) else { continue };
            assert_eq!(*white, 0);
            let mps2 = (speed - last) / 0.5;
            let tally = match mps2 {
                _ if *speed < 0.02 && *last < 0.02 => &mut waiting,
                ..-1.5 => &mut slowing,
                0.5.. => &mut gaining,
                _ => continue,
            };
            tally[usize::from(*red > 0)] += 1;
        }
    }
    // The body follows the pedals a little later.
    for [dark, lit] in [slowing, waiting] {
        assert!(dark + lit > 20 && lit > 9 * dark, "{lit} of {} braking cars", dark + lit);
    }
    let [dark, lit] = gaining;
    assert!(dark > 50 && dark > 9 * lit, "{lit} of {} that gain speed", dark + lit);
}

#[test]
fn in_the_dark_what_is_driven_has_low_beams_and_tail_lamps_and_nothing_parked_has() {
    let world = traffic(true);
    let shining = shining(&world.snapshot().instances);
    let driven: Vec<i32> = cars(&world).into_iter().map(|(agent, _)| agent.id).collect();
    let parked: Vec<i32> = parked(&world).into_iter().map(|agent| agent.id).collect();
    let lenses = |ids: &[i32]| ids.iter().filter_map(|id| shining.get(id)).copied().collect::<Vec<_>>();
    let (driven, parked) = (lenses(&driven), lenses(&parked));
    assert!(driven.len() > 5 && driven.iter().all(|lit| *lit == [1, 1]), "{driven:?}");
    assert!(parked.len() > 20 && parked.iter().all(|lit| *lit == [0, 0]), "{parked:?}");
}

#[test]
fn all_cars_of_a_tram_show_that_it_brakes() {
    let (mut slowing, mut gaining) = (0, 0);
    for (seed, town) in towns_with_tracks(2) {
        let mut world = busy(seed, &town);
        let mut before: BTreeMap<i32, f64> = BTreeMap::new();
        for _ in 0..120 {
            world.step(SECOND / 2);
            let shining = shining(&world.snapshot().instances);
            let mut after = BTreeMap::new();
            for (agent, tram) in trains(&world) {
                let (first, speed_mps) = (agent.id, tram.train.speed_mps);
                after.insert(first, speed_mps);
                let lit: Vec<bool> =
                    agent.actors().filter_map(|(id, _)| shining.get(&id)).map(|[red, _]| *red > 0).collect();
                assert!(lit.windows(2).all(|pair| pair[0] == pair[1]));
                let (Some(last), Some(is_lit)) = (before.get(&first), lit.first()) else { continue };
                match (speed_mps - last) / 0.5 {
                    ..-0.9 => slowing += if *is_lit { 1 } else { -9 },
                    0.3.. => gaining += if *is_lit { -9 } else { 1 },
                    _ => {}
                }
            }
            before = after;
        }
    }
    assert!(slowing > 5 && gaining > 10, "{slowing} and {gaining}, ten off for each that is wrong");
}
