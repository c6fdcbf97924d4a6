//! How much of a laser pulse surfaces throw back, dry and bare, wet, and under snow.

mod ground_cover;
pub(super) mod ground_texture;
mod reflection;

pub(crate) use ground_cover::{FALLEN_SNOW, under_snow, under_water};
pub(super) use reflection::{pane, reflectance};
