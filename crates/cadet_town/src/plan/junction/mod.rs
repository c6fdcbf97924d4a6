//! The ways through the junctions of a plan.

mod cycle_turns;
mod roundabout;
mod street_arm;
mod turns;

pub(crate) use cycle_turns::{CycleTurn, cycle_turns};
pub(crate) use roundabout::{OnRing, Roundabout};
pub(crate) use street_arm::{StreetArm, StreetEnd};
pub(crate) use turns::{PlannedTurn, STRAIGHT_RAD, turns};
