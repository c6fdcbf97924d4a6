//! The visibility kernel: what each beam of a grid meets first.

mod as_met;
mod coarse_depth;
mod kernel;

pub(crate) use as_met::{HalfTurn, MetWhileTurning, Still};
pub(crate) use kernel::cast_layers;
pub use kernel::{SurfaceFilter, cast};
