//! The LIDAR: sensor specifications, beams and returns.

mod air;
mod casting;
mod detection;
mod echoes;
mod reflectance;
mod returns;
mod scan;
mod scan_pattern;
mod sensor;

pub use air::{Fate, Weathered, weather_recorded};
pub use casting::SceneInMotion;
pub use detection::{LaserReceiver, MAX_DIVERGENCE_RAD, Receiver, ReturnMode};
pub use returns::{ReturnSurface, Scan};
pub use scan::{IdealScan, ideal_scan, scan, scan_in_motion, scan_through};
pub use scan_pattern::{Aim, Firing, MAX_COLUMNS, MAX_FIRINGS, Raster, Rosette, Spin, SpinDirection};
pub use sensor::{BlindSector, LidarSpec, PRESETS, Rays};
