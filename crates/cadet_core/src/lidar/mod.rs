//! The LIDAR: sensor specifications, beams and returns.

mod air;
mod presets;
mod returns;
mod scan;
mod spec;

pub use air::{Fate, Weathered, weather_recorded};
pub use presets::PRESETS;
pub use scan::{IdealScan, Scan, ideal_scan, scan};
pub use spec::{LidarSpec, Rays};
