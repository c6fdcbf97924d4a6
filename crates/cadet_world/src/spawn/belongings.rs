//! Things that people have along: umbrellas in rain, prams, dogs, wheeled cases, rollators, sticks, crutches.

use std::sync::Arc;

use super::spawner::Spawner;
use crate::agents::Pedestrian;
use crate::slot::Slot;
use crate::walking::Motion;
use cadet_assets::belongings::Thing;
use cadet_assets::person::PersonModel;
use cadet_base::rng::Stream;

/// Share of the people on foot who hold an umbrella when it rains.
const UMBRELLAS: f64 = 0.5;
/// Shares of all who walk: not everybody has a place in a group for each, and those who have it have it oftener.
const PRAMS: f64 = 0.03;
const DOGS: f64 = 0.03;
const CASES: f64 = 0.02;
/// About 2 % of all people: one in seven of the old ones.
const ROLLATORS_OF_OLD: f64 = 0.14;
/// Walking sticks of all old people, and crutches of all adults, two in so many of those.
const STICKS_OF_OLD: f64 = 0.10;
const CRUTCHES: f64 = 0.01;
const BOTH_CRUTCHES: f64 = 0.6;
/// Share of walkers who have nobody before them or beside them where the thing would be.
const PLACES_AHEAD: f64 = 0.48;
const PLACES_BEHIND: f64 = 0.55;

/// Where others of the same group are.
#[derive(Debug, Clone, Copy)]
struct Place {
    is_first: bool,
    is_last: bool,
    /// The side where nobody walks: +1 is the left; 0 with people on both.
    free_side: f64,
}

impl Spawner<'_> {
    /// Gives the people of some slots what they have along, by draws of their own.
    pub(super) fn assign_belongings(&mut self, slots: &[Slot]) {
        for slot in slots {
            let agent = &self.arena.agents[*slot];
            let Some(pedestrian) = agent.get::<Pedestrian>() else { continue };
            let model = &pedestrian.own.look.model;
            if agent.is_placed || model.belonging.is_some() {
                continue;
            }
            let place = self.place_in_group(*slot, pedestrian);
            let mut stream = Stream::from_seed("what one has along", model.seed());
            let thing = thing_of(model, pedestrian, place, self.rains, &mut stream);
            if let Some(thing) = leaning_on(model, thing).or(thing) {
                let drawn = if stream.chance(0.35) { 1.0 } else { -1.0 };
                let side = if thing == Thing::Dog && place.free_side != 0.0 { place.free_side } else { drawn };
                let carrying = Arc::new(model.carrying(thing, side as f32));
                if let Some(pedestrian) = self.arena.agents[*slot].get_mut::<Pedestrian>() {
                    pedestrian.own.look.model = carrying;
                }
            }
        }
    }

    fn place_in_group(&self, slot: Slot, own: &Pedestrian) -> Place {
        let (leader, aside_m, behind_m) = own.company.map_or((slot, 0.0, 0.0), |c| (c.leader, c.aside_m, c.behind_m));
        let direction = match own.motion {
            Motion::Walks { direction, .. } => direction,
            _ => 1.0,
        };
        let others = self.arena.each::<Pedestrian>().filter(|(other, ..)| *other != slot);
        let mut place = Place { is_first: true, is_last: true, free_side: 0.0 };
        for (other, _, pedestrian) in others {
            let (aside, behind) = match pedestrian.company {
                _ if other == leader => (0.0, 0.0),
                Some(c) if c.leader == leader => (c.aside_m, c.behind_m),
                _ => continue,
            };
            place.is_first &= behind >= behind_m - 0.1;
            place.is_last &= behind <= behind_m + 0.1;
            if (behind - behind_m).abs() < 0.1 && aside != aside_m {
                // Offsets are to the left of the walkway's line, which may be walked the other way.
                place.free_side = -(aside - aside_m).signum() * direction;
            }
        }
        place
    }
}

/// What somebody has along, if anything.
fn thing_of(
    model: &PersonModel,
    pedestrian: &Pedestrian,
    place: Place,
    rains: bool,
    stream: &mut Stream,
) -> Option<Thing> {
    let walks = matches!(pedestrian.motion, Motion::Walks { .. });
    let [pram, dog, case, rollator, umbrella] = [(); 5].map(|()| stream.unit());
    let is_adult = !model.is_child();
    // A thing ahead of somebody at the curb would be on the road.
    let has_room_ahead = walks && is_adult && place.is_first && !pedestrian.crosser;
    if has_room_ahead && model.is_elderly() && rollator < ROLLATORS_OF_OLD / PLACES_AHEAD {
        Some(Thing::Rollator)
    } else if has_room_ahead && !model.is_elderly() && pram < PRAMS / PLACES_AHEAD {
        Some(Thing::Pram)
    } else if has_room_ahead && dog < DOGS / PLACES_AHEAD {
        Some(Thing::Dog)
    } else if walks && is_adult && place.is_last && case < CASES / PLACES_BEHIND {
        Some(Thing::Case)
    } else if rains && umbrella < UMBRELLAS {
        Some(Thing::Umbrella)
    } else {
        None
    }
}

/// What somebody leans on, in place of what they would have; a rollator is enough. By a draw of its own.
fn leaning_on(model: &PersonModel, other: Option<Thing>) -> Option<Thing> {
    let mut stream = Stream::from_seed("what one leans on", model.seed());
    let [crutch, both, stick] = [(); 3].map(|()| stream.unit());
    if model.is_child() || other == Some(Thing::Rollator) {
        None
    } else if crutch < CRUTCHES {
        Some(if both < BOTH_CRUTCHES { Thing::Crutches } else { Thing::Crutch })
    } else {
        (model.is_elderly() && stick < STICKS_OF_OLD).then_some(Thing::Stick)
    }
}
