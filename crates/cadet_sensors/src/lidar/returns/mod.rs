//! What a sensor reports: the echoes that arrive, those that are detected, and the points that are written.

mod arrivals;
mod echo_batch;
mod order;
mod returned_points;

pub(super) use arrivals::arrivals;
pub(super) use echo_batch::EchoBatch;
pub use returned_points::{ReturnSurface, Scan};
