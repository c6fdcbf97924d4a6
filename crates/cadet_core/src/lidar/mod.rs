//! The LIDAR: sensor specifications, beams and returns.

mod air;
mod catalogue;
mod firing;
mod hdl64e;
mod presets;
mod reflection;
mod response;
mod returns;
mod scan;
mod spec;

pub use firing::Firing;
pub use presets::PRESETS;
pub use scan::{IdealScan, Scan, ideal_scan, scan};
pub use spec::{BlindSector, LidarSpec, Rays};
