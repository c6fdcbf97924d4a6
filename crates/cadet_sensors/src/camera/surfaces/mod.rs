//! What surfaces look like from near by: patterns, lit panes, and flags of faces.

mod face_flags;
pub(super) mod textures;
mod value_noise;
pub(super) mod windows;

pub(super) use face_flags::Flags;
pub(super) use textures::PatternPoint;
pub(super) use value_noise::{fbm, hash2, split, value_noise};
pub(super) use windows::window;
