//! What agents look like: a model, and the parts of it that the sensors see.

mod appearance;
mod lamp_light;
mod ride;
mod turn_signal;

pub(super) use appearance::Appearance;
pub(super) use lamp_light::LampLight;
pub(super) use ride::Ride;
pub(super) use turn_signal::TurnSignal;
