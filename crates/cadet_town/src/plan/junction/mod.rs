//! The ways through the junctions of a plan.

pub(crate) mod cycle_turns;
pub(crate) mod roundabout;
pub(crate) mod street_arm;
pub(crate) mod turns;
