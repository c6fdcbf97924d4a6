//! Writes a plan as OpenDRIVE.

pub(in crate::town) mod lanes;
pub(in crate::town) mod motorway_writer;
pub(in crate::town) mod signal_records;
pub(in crate::town) mod text;
pub(in crate::town) mod writer;
