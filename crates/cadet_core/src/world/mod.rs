//! What moves: rapier bodies, drivers, walkers, and the immutable picture of an instant that the sensors read.

mod snapshot;

pub use snapshot::{EgoState, Snapshot};
