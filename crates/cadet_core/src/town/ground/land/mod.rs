//! What the land between streets is used for, and the paved yards beside them.

pub(in crate::town) mod fields;
pub(in crate::town) mod yard_region;
pub(in crate::town) mod yards;
