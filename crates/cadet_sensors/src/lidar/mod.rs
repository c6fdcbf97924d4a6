//! The LIDAR: sensor specifications, beams and returns.

mod air;
mod casting;
mod divergence;
mod draws;
mod echo;
mod echo_batch;
mod firing;
mod ground_texture;
mod hdl64e;
mod intensity;
mod laser_receiver;
mod order;
mod presets;
mod receiver;
mod reflection;
mod return_mode;
mod returned_points;
mod returns;
mod ring_receiver;
mod scan;
mod spec;
mod spin;
mod surfaces;
mod turning;

pub use air::{Fate, Weathered, weather_recorded};
pub use firing::{Firing, MAX_COLUMNS};
pub use laser_receiver::LaserReceiver;
pub use presets::PRESETS;
pub use receiver::{MAX_DIVERGENCE_RAD, Receiver};
pub use return_mode::ReturnMode;
pub use returned_points::{ReturnSurface, Scan};
pub use scan::{IdealScan, ideal_scan, scan, scan_through, turning_scan};
pub use spec::{BlindSector, LidarSpec, Rays};
pub use spin::{Spin, SpinDirection};
pub use turning::Turning;
