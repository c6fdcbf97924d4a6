//! Writes a plan as OpenDRIVE.

pub(in crate::town) mod lanes;
pub(in crate::town) mod motorway;
pub(in crate::town) mod signals;
pub(in crate::town) mod text;
pub(in crate::town) mod writer;
