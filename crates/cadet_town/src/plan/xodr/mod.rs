//! Writes a plan as OpenDRIVE.

pub(crate) mod lanes;
pub(crate) mod motorway_writer;
pub(crate) mod signal_records;
pub(crate) mod text;
pub(crate) mod writer;
