//! What the land between streets is used for, and the paved yards beside them.

mod fields;
pub(crate) mod yard_region;
mod yards;

pub(crate) use fields::{Crop, Land};
pub(crate) use yards::{YardSurface, Yards};
