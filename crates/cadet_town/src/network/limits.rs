//! Numbers that a plan and those who read it back agree on.

/// Height of a curb: a sidewalk's lane lies this much above the carriageway.
pub(crate) const CURB_HEIGHT_M: f64 = 0.12;
/// Speed limit of aisles between rows of bays.
pub(crate) const AISLE_KMH: u32 = 20;
