//! The LIDAR: sensor specifications, beams and returns.

mod air;
mod catalogue;
mod firing;
mod presets;
mod returns;
mod scan;
mod spec;

pub use firing::Firing;
pub use presets::PRESETS;
pub use scan::{IdealScan, Scan, ideal_scan, scan};
pub use spec::{LidarSpec, Rays};
