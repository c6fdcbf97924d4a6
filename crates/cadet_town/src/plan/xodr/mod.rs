//! Writes a plan as OpenDRIVE.

mod lanes;
pub(crate) mod motorway_writer;
mod signal_records;
mod text;
pub(crate) mod writer;

use lanes::{
    CYCLE_FORD_M, LaneRecord, OuterLine, Section, driven_surface, driving_id, outermost_lane, ridden_id, sidewalk_id,
    street_sections, write_lanes,
};
use signal_records::{write_controllers, write_junction_controllers, write_signals};
use text::{Cubic, Link, begin_document, begin_road, put, write_type};
use writer::write_shape;
