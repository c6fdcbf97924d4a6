//! The camera: model and lens, shading, sky, shadows, noise, PNG.

mod ambient_cache;
mod block_sums;
mod bloom;
mod compositing;
mod contact_occlusion;
mod coverage;
mod deferred_shading;
mod distortion;
mod exposure;
mod face;
mod face_cache;
mod fragment_binning;
mod lens_drops;
mod light;
mod model;
mod mosaic;
mod night_lights;
mod noise;
pub mod png;
mod precipitation;
mod radiance_pass;
mod render;
mod rolling_shutter;
mod shading_pass;
mod shading_queue;
mod shadow;
mod sky;
mod sky_rows;
mod sky_visibility;
mod spray;
#[cfg(test)]
mod tests;
mod textures;
mod value_noise;
mod visibility_pass;
mod windows;

pub use distortion::{Distortion, Warp};
pub use exposure::{Gain, Metering};
pub use lens_drops::LensDrops;
#[cfg(test)]
pub(crate) use model::tests::kitti_like;
pub use model::{CameraModel, MAX_ROLLING_SHUTTER_S, Pixel, SIDES_PX};
pub use precipitation::Precipitation;
pub use render::{Foreground, Rendered, render, render_through};
pub use rolling_shutter::{Moving, render_rolling};
pub use visibility_pass::{Maps, View, Visibility, visibility_pass};
