//! The kinds of agents, a file each: their bodies, their state, and what they do; an agent is one of them.

mod actor;
mod behavior;
mod car;
mod cyclist;
mod fixture;
mod pedestrian;
mod scripted;
mod timed_path;
mod tram;

pub(super) use actor::{Actor, ActorView};
pub(super) use behavior::Behavior;
pub(super) use car::Car;
#[cfg(test)]
pub(super) use car::axles_of;
pub(super) use cyclist::{Cyclist, Habits};
pub(super) use fixture::{Fixture, Gone};
pub(super) use pedestrian::Pedestrian;
pub(super) use scripted::{Led, PERSON_HALF_CHORD_M, Script, Scripted};
pub(super) use timed_path::TimedPath;
pub(super) use tram::{Coupled, Train, Tram, TramCar};

/// The ego, a car in traffic, a parked one, a person, a train.
pub(super) struct Agent {
    /// Of its first actor: never given twice; 0 for the ego. Its other actors have the next ones.
    pub id: i32,
    pub kind: Kind,
    /// Put there by the user: never replaced.
    pub is_placed: bool,
}

/// What an agent is, with its bodies and its state.
pub(super) enum Kind {
    /// A vehicle with somebody at the wheel.
    Car(Box<Car>),
    /// Somebody on a bicycle.
    Cyclist(Box<Cyclist>),
    /// Somebody on foot.
    Pedestrian(Box<Pedestrian>),
    /// A train of several cars.
    Tram(Box<Tram>),
    /// Led by a user's script.
    Scripted(Box<Scripted>),
    /// Stays where it is.
    Static(Box<Fixture>),
    /// Has left the world: its slot is free.
    Gone(Gone),
}

impl Agent {
    pub fn behavior(&self) -> &dyn Behavior {
        match &self.kind {
            Kind::Car(car) => car.as_ref(),
            Kind::Cyclist(cyclist) => cyclist.as_ref(),
            Kind::Pedestrian(pedestrian) => pedestrian.as_ref(),
            Kind::Tram(tram) => tram.as_ref(),
            Kind::Scripted(scripted) => scripted.as_ref(),
            Kind::Static(fixture) => fixture.as_ref(),
            Kind::Gone(gone) => gone,
        }
    }

    pub fn behavior_mut(&mut self) -> &mut dyn Behavior {
        match &mut self.kind {
            Kind::Car(car) => car.as_mut(),
            Kind::Cyclist(cyclist) => cyclist.as_mut(),
            Kind::Pedestrian(pedestrian) => pedestrian.as_mut(),
            Kind::Tram(tram) => tram.as_mut(),
            Kind::Scripted(scripted) => scripted.as_mut(),
            Kind::Static(fixture) => fixture.as_mut(),
            Kind::Gone(gone) => gone,
        }
    }

    pub fn as_car(&self) -> Option<&Car> {
        if let Kind::Car(car) = &self.kind { Some(car) } else { None }
    }

    pub fn as_cyclist(&self) -> Option<&Cyclist> {
        if let Kind::Cyclist(cyclist) = &self.kind { Some(cyclist) } else { None }
    }

    pub fn as_pedestrian(&self) -> Option<&Pedestrian> {
        if let Kind::Pedestrian(pedestrian) = &self.kind { Some(pedestrian) } else { None }
    }

    pub fn as_tram(&self) -> Option<&Tram> {
        if let Kind::Tram(tram) = &self.kind { Some(tram) } else { None }
    }

    /// Its actors, each with its id.
    pub fn actors(&self) -> impl Iterator<Item = (i32, ActorView<'_>)> {
        let behavior = self.behavior();
        (0..).map_while(move |k| behavior.actor(k)).zip(self.id..).map(|(actor, id)| (id, actor))
    }

    /// Its first actor, which is its only one unless it is a train.
    pub fn actor(&self) -> ActorView<'_> {
        self.behavior().actor(0).expect("who is in the world has a body")
    }
}
