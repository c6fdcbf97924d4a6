//! The grid of a spinning LIDAR: which of its rows and columns may pass through what, and where they do.

mod azimuth_ticks;
mod laser_ring;
mod row_lookup;
mod row_planes;
mod spinning_grid;
mod spinning_table;

pub(super) use azimuth_ticks::azimuth_rad_of;
pub use laser_ring::LaserRing;
pub use spinning_grid::SpinningGrid;
