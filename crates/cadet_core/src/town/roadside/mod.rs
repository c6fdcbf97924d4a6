//! What lies between carriageways and plots: lines to walk along and places to park.

pub(in crate::town) mod parking_spots;
pub(in crate::town) mod walkway;
