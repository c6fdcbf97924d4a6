//! The ways through the junctions of a plan.

pub(in crate::town) mod cycle_turns;
pub(in crate::town) mod roundabout;
pub(in crate::town) mod street_arm;
pub(in crate::town) mod turns;
