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
    pub kind: AgentKind,
    /// Put there by the user: never replaced.
    pub is_placed: bool,
}

/// Lists what an agent may be, with its bodies and its state.
macro_rules! kinds {
    ($($(#[$doc:meta])* $kind:ident,)*) => {
        /// What an agent is.
        pub(super) enum AgentKind {
            $($(#[$doc])* $kind(Box<$kind>),)*
        }

        impl Agent {
            pub fn behavior(&self) -> &dyn Behavior {
                match &self.kind {
                    $(AgentKind::$kind(own) => own.as_ref(),)*
                }
            }

            pub fn behavior_mut(&mut self) -> &mut dyn Behavior {
                match &mut self.kind {
                    $(AgentKind::$kind(own) => own.as_mut(),)*
                }
            }
        }

        $(
            impl From<$kind> for AgentKind {
                fn from(own: $kind) -> Self {
                    Self::$kind(Box::new(own))
                }
            }

            impl OfKind for $kind {
                fn of(agent: &Agent) -> Option<&Self> {
                    if let AgentKind::$kind(own) = &agent.kind { Some(own) } else { None }
                }

                fn of_mut(agent: &mut Agent) -> Option<&mut Self> {
                    if let AgentKind::$kind(own) = &mut agent.kind { Some(own) } else { None }
                }
            }
        )*
    };
}

kinds! {
    /// A vehicle with somebody at the wheel.
    Car,
    /// Somebody on a bicycle.
    Cyclist,
    /// Somebody on foot.
    Pedestrian,
    /// A train of several cars.
    Tram,
    /// Led by a user's script.
    Scripted,
    /// Stays where it is.
    Fixture,
    /// Has left the world: its slot is free.
    Gone,
}

/// A kind of agent.
pub(super) trait OfKind: Sized + 'static {
    fn of(agent: &Agent) -> Option<&Self>;

    fn of_mut(agent: &mut Agent) -> Option<&mut Self>;
}

impl Agent {
    /// The agent, if it is of this kind.
    pub fn get<K: OfKind>(&self) -> Option<&K> {
        K::of(self)
    }

    /// The agent to be changed, if it is of this kind.
    pub fn get_mut<K: OfKind>(&mut self) -> Option<&mut K> {
        K::of_mut(self)
    }

    /// The agent's actors, each with its id.
    pub fn actors(&self) -> impl Iterator<Item = (i32, ActorView<'_>)> {
        let behavior = self.behavior();
        (0..).map_while(move |k| behavior.actor(k)).zip(self.id..).map(|(actor, id)| (id, actor))
    }

    /// The agent's first actor, which is the only one unless it is a train.
    pub fn actor(&self) -> ActorView<'_> {
        self.behavior().actor(0).expect("who is in the world has a body")
    }
}
