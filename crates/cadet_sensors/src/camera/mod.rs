//! The camera: model and lens, shading, sky, shadows, noise, PNG.

mod light;
mod model;
mod overlays;
pub mod png;
mod render;
mod sensor;
mod shading;
mod surfaces;
#[cfg(test)]
mod tests;
mod visibility;

#[cfg(test)]
pub(crate) use model::kitti_like;
pub use model::{
    CURVE_POINTS, CameraModel, Development, Distortion, Fisheye, MAX_MOTION_BLUR_S, MAX_ROLLING_SHUTTER_S,
    MOST_ANGLE_RAD, MOST_EXPOSURE_EV, MOST_NOISE, Maps, Pixel, Response, SIDES_PX, SurfaceMaps, WHITE_BALANCE_FACTORS,
    Warp,
};
pub use overlays::{LensDrops, Precipitation};
pub use render::{Foreground, Moving, Rendered, render, render_fisheye, render_rolling, render_through};
pub use sensor::{Gain, LastGain, Metering};
pub use visibility::{Motions, SurfaceMapKinds, View, Visibility, visibility_pass};
