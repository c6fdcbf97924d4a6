//! Traffic round the ego: all of it at the start, and newcomers for who has gone.

use super::fast;
use super::spawner::Spawner;
use crate::error::Result;
use crate::rng::Stream;
use crate::town::Town;
use crate::world::agent::Agent;
use crate::world::arena::{Arena, Newcomer};
use crate::world::control::{Cyclist, Driver, Pedestrian};
use crate::world::slot::{EGO, Slot};

/// Steps between two looks at who has gone too far away.
pub(crate) const RENEW_EVERY: u64 = 30;
/// Cars farther from the ego than this give their place to new ones, which appear beyond what the ego can see.
const CAR_GONE_M: f64 = 190.0;
const CAR_APPEARS_M: (f64, f64) = (100.0, 170.0);
const WALKER_GONE_M: f64 = 130.0;
const WALKER_APPEARS_M: (f64, f64) = (90.0, 125.0);
/// Nearest to the ego that cars and people start.
const CAR_STARTS_M: f64 = 9.0;
const WALKER_STARTS_M: f64 = 3.0;
/// The same of cyclists.
const CYCLIST_GONE_M: f64 = 115.0;
const CYCLIST_APPEARS_M: (f64, f64) = (65.0, 105.0);
const CYCLIST_STARTS_M: f64 = 8.0;
/// How far ahead a truck looks for a corner that it can't take.
const CORNER_AHEAD_M: f64 = 35.0;
/// A car that has stood this long somewhere out of sight is stuck.
const STUCK_STEPS: u64 = 60 * 45;

/// Fills a world: parked cars, then driven ones, then people on foot, then cyclists, then people who sit,
/// then trams. To be called once, before the first step.
///
/// # Errors
/// [`crate::Error::OutOfRange`] for a configuration that makes no sense.
pub(crate) fn fill(spawner: &mut Spawner<'_>, town: &Town) -> Result<()> {
    let config = spawner.config;
    config.check()?;
    spawner.park_cars(town)?;
    let Arena { streets, around, .. } = &mut *spawner.arena;
    streets.roads.note_standing(&around.standing);
    let (car_m, walker_m, cyclist_m) = (config.car_radius_m, config.pedestrian_radius_m, config.cyclist_radius_m);
    spawner.roll_ego();
    let car_m = car_m * if spawner.is_fast() { fast::FARTHER } else { 1.0 };
    spawner.survey();
    add(spawner, "driven cars", config.num_cars, (CAR_STARTS_M, car_m), Spawner::new_car);
    add(spawner, "people", config.num_pedestrians, (WALKER_STARTS_M, walker_m), Spawner::new_walker);
    add(spawner, "cyclists", config.num_cyclists, (CYCLIST_STARTS_M, cyclist_m), Spawner::new_cyclist);
    let people: Vec<Slot> = spawner.arena.controlled_by::<Pedestrian>().map(|(slot, ..)| slot).collect();
    spawner.hand_out(&people);
    spawner.seat_people(town);
    spawner.fill_tracks();
    Ok(())
}

/// How many have been replaced, and when.
#[derive(Debug, Clone, Copy, Default)]
pub(crate) struct Respawns {
    /// All attempts so far: they number the draws.
    count: u64,
    /// No tram comes before this step.
    next_tram_step: u64,
}

/// Replaces who has gone too far from the ego by newcomers out of its sight.
pub(crate) fn renew(spawner: &mut Spawner<'_>, respawns: &mut Respawns, step: u64) {
    let Respawns { count: respawns, next_tram_step } = respawns;
    let gone = gone_cars(spawner);
    let appears_m = if spawner.is_fast() { fast::APPEARS_M } else { CAR_APPEARS_M };
    replace(spawner, "newcomers", respawns, &gone, appears_m, Spawner::new_car);
    let gone = gone_walkers(spawner);
    replace(spawner, "new people", respawns, &gone, WALKER_APPEARS_M, Spawner::new_walker);
    spawner.hand_out(&gone);
    let gone = gone_cyclists(spawner);
    replace(spawner, "new cyclists", respawns, &gone, CYCLIST_APPEARS_M, Spawner::new_cyclist);
    if step >= *next_tram_step
        && let Some(pause_steps) = spawner.renew_tram(respawns)
    {
        *next_tram_step = step + pause_steps;
    }
}

/// Makes somebody for a slot, between two distances from the ego, hidden from it or not; `None` where there is no place.
type Make<'s> = fn(&mut Spawner<'s>, Slot, &mut Stream, (f64, f64), bool) -> Option<Newcomer>;

fn add<'s>(spawner: &mut Spawner<'s>, name: &'static str, count: usize, ring_m: (f64, f64), make: Make<'s>) {
    let mut stream = spawner.key.stream(name);
    for _ in 0..count {
        let slot = spawner.arena.agents.len();
        if let Some(newcomer) = make(spawner, slot, &mut stream, ring_m, false) {
            spawner.arena.put(newcomer);
            spawner.survey();
        }
    }
}

fn replace<'s>(
    spawner: &mut Spawner<'s>,
    name: &'static str,
    respawns: &mut u64,
    gone: &[Slot],
    ring_m: (f64, f64),
    make: Make<'s>,
) {
    for slot in gone {
        let mut stream = spawner.key.indexed(name, *respawns);
        *respawns += 1;
        if let Some(newcomer) = make(spawner, *slot, &mut stream, ring_m, true) {
            spawner.arena.replace(*slot, newcomer);
            spawner.survey();
        }
    }
}

fn gone_cars(spawner: &Spawner<'_>) -> Vec<Slot> {
    let (ego, view) = spawner.arena.ego_place();
    let gone_m = if spawner.is_fast() { fast::GONE_M } else { CAR_GONE_M };
    let is_gone = |(slot, agent, driver): &(Slot, &Agent, &Driver)| {
        let to = agent.body.world_from_box(&spawner.arena.physics).translation.truncate() - ego;
        let is_hidden = to.length() > 100.0 || (to.length() > 90.0 && to.dot(view) < 0.0);
        let is_stuck = is_hidden && driver.standing_steps > STUCK_STEPS;
        // A truck leaves before a corner that it can't take, where the cameras ahead don't see it.
        let is_unseen = to.length() > 100.0 || (to.length() > 35.0 && to.dot(view) < 0.6 * to.length());
        let is_cornered = is_unseen
            && driver.route.as_ref().is_some_and(|route| !route.fits(CORNER_AHEAD_M, &spawner.arena.streets.roads));
        *slot != EGO && !agent.is_placed && (to.length() >= gone_m || is_stuck || is_cornered)
    };
    spawner.arena.controlled_by::<Driver>().filter(is_gone).map(|(slot, ..)| slot).collect()
}

fn gone_walkers(spawner: &Spawner<'_>) -> Vec<Slot> {
    let (ego, _) = spawner.arena.ego_place();
    let people = spawner.arena.controlled_by::<Pedestrian>();
    people
        .filter(|(_, agent, _)| {
            let at = agent.body.world_from_box(&spawner.arena.physics).translation.truncate();
            !agent.is_placed && (at - ego).length() >= WALKER_GONE_M
        })
        .map(|(slot, ..)| slot)
        .collect()
}

fn gone_cyclists(spawner: &Spawner<'_>) -> Vec<Slot> {
    let (ego, view) = spawner.arena.ego_place();
    let is_gone = |(_, agent, cyclist): &(Slot, &Agent, &Cyclist)| {
        let to = agent.body.world_from_box(&spawner.arena.physics).translation.truncate() - ego;
        let is_hidden = to.length() > 90.0 && to.dot(view) < 0.0;
        let is_stuck = is_hidden && cyclist.standing_steps > STUCK_STEPS;
        !agent.is_placed && (to.length() >= CYCLIST_GONE_M || is_stuck)
    };
    spawner.arena.controlled_by::<Cyclist>().filter(is_gone).map(|(slot, ..)| slot).collect()
}
