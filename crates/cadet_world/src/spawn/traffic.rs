//! Traffic round the ego: all of it at the start, and newcomers for who has gone.

use super::spawner::{Entry, Newcomer, Spawner};
use super::{fast, trams};
use crate::agents::{Agent, AgentKind, Car, Cyclist, Pedestrian};
use crate::arena::Arena;
use crate::driving::Cause;
use crate::slot::{EGO, Slot};
use crate::streets::Route;
use cadet_base::actor::ObjectClass;
use cadet_base::error::Result;
use cadet_town::Town;

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
/// Distances from the ego beyond which cyclists give their place to new ones, between which those appear, and nearest
/// at which cyclists start.
const CYCLIST_GONE_M: f64 = 115.0;
const CYCLIST_APPEARS_M: (f64, f64) = (65.0, 105.0);
const CYCLIST_STARTS_M: f64 = 8.0;
/// How far ahead a truck looks for a corner that it can't take.
const CORNER_AHEAD_M: f64 = 35.0;
/// Least distance from the ego at which newcomers come in at the map's edge.
const EDGE_M: f64 = 30.0;
/// The ego's middle is so near the road's end when it stands there, and who has stood so long behind it leaves.
const EGO_ENDS_M: f64 = 8.0;
const WAITS_STEPS: u64 = 60 * 2;
/// A car that has stood this long somewhere out of sight is stuck.
const STUCK_STEPS: u64 = 60 * 45;

/// Agents of a kind of which fewer found room than were asked for.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Shortfall {
    /// The field of [`super::TrafficConfig`] that asks for them.
    pub setting: &'static str,
    /// How many it asks for.
    pub asked: usize,
    /// How many there are.
    pub placed: usize,
}

/// Fills a world: parked cars, then driven ones, then people on foot, then cyclists, then people who sit,
/// then trams. To be called once, before the first step. Returns what found no room.
///
/// # Errors
/// [`cadet_base::Error::OutOfRange`] for a configuration that makes no sense.
pub(crate) fn fill(spawner: &mut Spawner<'_>, town: &Town) -> Result<Vec<Shortfall>> {
    let config = spawner.config;
    config.check()?;
    spawner.park_cars(town)?;
    let Arena { streets, around, .. } = &mut *spawner.arena;
    streets.graph.note_standing(&around.standing);
    let (car_m, walker_m, cyclist_m) = (config.car_radius_m, config.pedestrian_radius_m, config.cyclist_radius_m);
    spawner.roll_ego();
    let car_m = car_m * if spawner.is_fast() { fast::FARTHER_FACTOR } else { 1.0 };
    spawner.refresh_traffic_state();
    let kinds: [(_, usize, _, _, Make<'_>); 3] = [
        ("num_cars", config.num_cars, "driven cars", (CAR_STARTS_M, car_m), Spawner::new_car),
        ("num_pedestrians", config.num_pedestrians, "people", (WALKER_STARTS_M, walker_m), Spawner::new_walker),
        ("num_cyclists", config.num_cyclists, "cyclists", (CYCLIST_STARTS_M, cyclist_m), Spawner::new_cyclist),
    ];
    let mut placed = Vec::new();
    for (setting, asked, stream, ring_m, make) in kinds {
        placed.push(Shortfall { setting, asked, placed: add(spawner, stream, asked, ring_m, make) });
    }
    let people: Vec<Slot> = spawner.arena.each::<Pedestrian>().map(|(slot, ..)| slot).collect();
    spawner.assign_belongings(&people);
    spawner.seat_people(town);
    let num_trams = add(spawner, "trams", config.num_trams, trams::STARTS_M, Spawner::new_tram);
    placed.push(Shortfall { setting: "num_trams", asked: config.num_trams, placed: num_trams });
    placed.retain(|kind| kind.placed < kind.asked);
    Ok(placed)
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
    replace(spawner, "newcomers", respawns, &gone, (appears_m, Entry::Unseen), Spawner::new_car);
    let gone = gone_walkers(spawner);
    replace(spawner, "new people", respawns, &gone, (WALKER_APPEARS_M, Entry::Unseen), Spawner::new_walker);
    spawner.assign_belongings(&gone);
    let gone = gone_cyclists(spawner);
    let appears_m = CYCLIST_APPEARS_M;
    replace(spawner, "new cyclists", respawns, &gone, (appears_m, Entry::Unseen), Spawner::new_cyclist);
    fill_vacant(spawner, respawns);
    if step >= *next_tram_step
        && let Some(pause_steps) = spawner.renew_tram(respawns)
    {
        *next_tram_step = step + pause_steps;
    }
}

/// Makes somebody; `None` where there is no place.
type Make<'s> = fn(&mut Spawner<'s>, &mut Newcomer<'_>) -> Option<AgentKind>;

/// Adds so many, or as many as find room; returns how many.
fn add<'s>(spawner: &mut Spawner<'s>, name: &'static str, count: usize, ring_m: (f64, f64), make: Make<'s>) -> usize {
    let before = spawner.arena.agents.len();
    let mut stream = spawner.key.stream(name);
    for _ in 0..count {
        let slot = spawner.arena.agents.len();
        let mut by = Newcomer { slot, stream: &mut stream, ring_m, entry: Entry::Anywhere };
        if let Some(newcomer) = make(spawner, &mut by) {
            spawner.arena.put(newcomer);
            spawner.refresh_traffic_state();
        }
    }
    spawner.arena.agents.len() - before
}

fn replace<'s>(
    spawner: &mut Spawner<'s>,
    name: &'static str,
    respawns: &mut u64,
    gone: &[Slot],
    (ring_m, entry): ((f64, f64), Entry),
    make: Make<'s>,
) {
    for slot in gone {
        let mut stream = spawner.key.indexed(name, *respawns);
        *respawns += 1;
        let mut by = Newcomer { slot: *slot, stream: &mut stream, ring_m, entry };
        if let Some(newcomer) = make(spawner, &mut by) {
            spawner.arena.replace(*slot, newcomer);
            spawner.refresh_traffic_state();
        }
    }
}

/// Newcomers for those who have left the world, out of sight or, where no such place is free, at the map's edge.
fn fill_vacant(spawner: &mut Spawner<'_>, respawns: &mut u64) {
    let appears_m = if spawner.is_fast() { fast::APPEARS_M } else { CAR_APPEARS_M };
    let vacant: Vec<(Slot, ObjectClass)> = spawner.arena.vacant().map(|(slot, gone)| (slot, gone.class)).collect();
    for (slot, class) in vacant {
        let (make, appears_m): (Make<'_>, _) = match class {
            ObjectClass::Cyclist => (Spawner::new_cyclist, CYCLIST_APPEARS_M),
            _ => (Spawner::new_car, appears_m),
        };
        replace(spawner, "replacements", respawns, &[slot], (appears_m, Entry::Unseen), make);
        if spawner.arena.vacant().any(|(other, _)| other == slot) {
            replace(spawner, "arrivals", respawns, &[slot], ((EDGE_M, appears_m.1), Entry::MapEdge), make);
        }
    }
}

/// Takes those out of the world who have come to where their road ends with the map, and those who wait behind an ego that
/// stands there.
pub(crate) fn leave(arena: &mut Arena) {
    let graph = &arena.streets.graph;
    let ego = arena.ego_car().route.as_ref();
    let ego_is_over = ego.is_some_and(|route| route.leads_off_map(EGO_ENDS_M, graph));
    let is_over = |agent: &Agent, route: &Route, standing_steps: u64| {
        let half_m = agent.actor().look.size_lwh().x / 2.0;
        let waits = ego_is_over && standing_steps > WAITS_STEPS && agent.behavior().cause() == Cause::Vehicle(EGO);
        !agent.is_placed && (waits || route.leads_off_map(half_m, graph))
    };
    let drivers = arena.each::<Car>().filter(|(slot, ..)| *slot != EGO);
    let drivers = drivers.filter_map(|(slot, agent, driver)| {
        is_over(agent, driver.route.as_ref()?, driver.standing_steps).then_some(slot)
    });
    let cyclists = arena.each::<Cyclist>();
    let cyclists = cyclists.filter(|(_, agent, cyclist)| is_over(agent, &cyclist.route, cyclist.standing_steps));
    let gone: Vec<Slot> = drivers.chain(cyclists.map(|(slot, ..)| slot)).collect();
    gone.into_iter().for_each(|slot| arena.remove(slot));
}

fn gone_cars(spawner: &Spawner<'_>) -> Vec<Slot> {
    let (ego, view) = spawner.arena.ego_place();
    let gone_m = if spawner.is_fast() { fast::GONE_M } else { CAR_GONE_M };
    let is_gone = |(slot, agent, driver): &(Slot, &Agent, &Car)| {
        let to = agent.actor().body.world_from_box(&spawner.arena.physics).translation.truncate() - ego;
        let is_hidden = to.length() > 100.0 || (to.length() > 90.0 && to.dot(view) < 0.0);
        let is_stuck = is_hidden && driver.standing_steps > STUCK_STEPS;
        // A truck leaves before a corner that it can't take, where the cameras ahead don't see it.
        let is_unseen = to.length() > 100.0 || (to.length() > 35.0 && to.dot(view) < 0.6 * to.length());
        let is_cornered = is_unseen
            && driver.route.as_ref().is_some_and(|route| !route.fits(CORNER_AHEAD_M, &spawner.arena.streets.graph));
        *slot != EGO && !agent.is_placed && (to.length() >= gone_m || is_stuck || is_cornered)
    };
    spawner.arena.each::<Car>().filter(is_gone).map(|(slot, ..)| slot).collect()
}

fn gone_walkers(spawner: &Spawner<'_>) -> Vec<Slot> {
    let (ego, _) = spawner.arena.ego_place();
    let people = spawner.arena.each::<Pedestrian>();
    people
        .filter(|(_, agent, pedestrian)| !agent.is_placed && (pedestrian.own.body.at() - ego).length() >= WALKER_GONE_M)
        .map(|(slot, ..)| slot)
        .collect()
}

fn gone_cyclists(spawner: &Spawner<'_>) -> Vec<Slot> {
    let (ego, view) = spawner.arena.ego_place();
    let is_gone = |(_, agent, cyclist): &(Slot, &Agent, &Cyclist)| {
        let to = agent.actor().body.world_from_box(&spawner.arena.physics).translation.truncate() - ego;
        let is_hidden = to.length() > 90.0 && to.dot(view) < 0.0;
        let is_stuck = is_hidden && cyclist.standing_steps > STUCK_STEPS;
        !agent.is_placed && (to.length() >= CYCLIST_GONE_M || is_stuck)
    };
    spawner.arena.each::<Cyclist>().filter(is_gone).map(|(slot, ..)| slot).collect()
}
