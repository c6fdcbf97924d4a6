//! Junctions: who may cross one when. A lane across a junction is reserved before it is entered, and lanes that come too
//! near to each other exclude one another.

mod conflicts;
mod exit_room;
mod request;
mod reservations;
mod resolver;
#[cfg(test)]
mod tests;

pub(super) use request::{Request, Stage, Turn};
pub(super) use reservations::{Junctions, Refusal};
