//! What lies between carriageways and plots: lines to walk along and places to park.

pub(crate) mod parking_spots;
pub(crate) mod walkway;
