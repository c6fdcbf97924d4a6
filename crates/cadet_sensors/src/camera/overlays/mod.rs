//! What lies over the image of the scene: spray, drops and flakes, drops on the lens, and halos of lamps.

mod bloom;
mod compositing;
mod lens_drops;
mod precipitation;
pub(super) mod spray;

pub(super) use bloom::add_halos;
pub use lens_drops::LensDrops;
pub use precipitation::Precipitation;
