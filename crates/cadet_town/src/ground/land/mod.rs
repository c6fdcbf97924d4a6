//! What the land between streets is used for, and the paved yards beside them.

pub(crate) mod fields;
pub(crate) mod yard_region;
pub(crate) mod yards;
