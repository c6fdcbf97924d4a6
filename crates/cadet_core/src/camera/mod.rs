//! The camera: model and lens, shading, sky, shadows, noise, PNG.

mod ambient;
mod block_sums;
mod collect;
mod contact;
mod coverage;
mod distortion;
mod exposure;
mod face;
mod faces;
mod light;
mod look;
mod model;
mod noise;
mod paint;
mod painter;
mod pattern;
pub mod png;
mod render;
mod shade;
mod shading_batch;
mod shading_pass;
mod shading_queue;
mod shadow;
mod sky;
mod sky_rows;
#[cfg(test)]
mod tests;

pub use distortion::{Distortion, Warp};
pub use look::{Maps, Seen, View, look};
#[cfg(test)]
pub(crate) use model::tests::kitti_like;
pub use model::{CameraModel, Pixel};
pub use render::{Rendered, paint, paint_through};
