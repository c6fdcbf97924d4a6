//! When a LIDAR's lasers fire and where they point: turns, and paths of beams that do not spin.

mod firing;
mod half_scan;
mod scan_path;
mod spin;

pub use firing::{Firing, MAX_COLUMNS};
pub(super) use half_scan::{HalfScan, HalvesMade};
pub(super) use scan_path::azimuths_of;
pub use scan_path::{Aim, MAX_FIRINGS, Raster, Rosette};
pub use spin::{Spin, SpinDirection};
