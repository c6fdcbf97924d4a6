//! The camera: model and lens, shading, sky, shadows, noise, PNG.

mod ambient_cache;
mod block_sums;
mod bloom;
mod compositing;
mod contact_occlusion;
mod coverage;
mod deferred_shading;
mod development;
mod distortion;
mod exposure;
mod face;
mod face_cache;
mod fisheye;
mod fisheye_pass;
mod fragment_binning;
mod lens_drops;
mod light;
mod maps;
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
mod surface_maps;
#[cfg(test)]
mod tests;
mod textures;
mod value_noise;
mod visibility_pass;
mod windows;

pub use development::{CURVE_POINTS, Development, MOST_EXPOSURE_EV, MOST_NOISE, Response, WHITE_BALANCE_FACTORS};
pub use distortion::{Distortion, Warp};
pub use exposure::{Gain, LastGain, Metering};
pub use fisheye::{Fisheye, MOST_ANGLE_RAD};
pub use fisheye_pass::render_fisheye;
pub use lens_drops::LensDrops;
pub use maps::{Maps, SurfaceMaps};
#[cfg(test)]
pub(crate) use model::tests::kitti_like;
pub use model::{CameraModel, MAX_MOTION_BLUR_S, MAX_ROLLING_SHUTTER_S, Pixel, SIDES_PX};
pub use precipitation::Precipitation;
pub use render::{Foreground, Rendered, render, render_through};
pub use rolling_shutter::{Moving, render_rolling};
pub use surface_maps::{Motions, SurfaceMapKinds};
pub use visibility_pass::{View, Visibility, visibility_pass};
