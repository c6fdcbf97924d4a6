//! The model of a camera: how points become pixels, through which lens, and how light becomes values.

mod camera_model;
mod development;
mod distortion;
mod fisheye;
mod maps;

#[cfg(test)]
pub(crate) use camera_model::tests::kitti_like;
pub use camera_model::{CameraModel, MAX_MOTION_BLUR_S, MAX_ROLLING_SHUTTER_S, Pixel, SIDES_PX};
pub use development::{CURVE_POINTS, Development, MOST_EXPOSURE_EV, MOST_NOISE, Response, WHITE_BALANCE_FACTORS};
pub(super) use development::{WHITE_BALANCE, WHITE_VALUE};
pub use distortion::{Distortion, Warp};
pub(super) use fisheye::Side;
pub use fisheye::{Fisheye, MOST_ANGLE_RAD};
pub use maps::{Maps, SurfaceMaps};
