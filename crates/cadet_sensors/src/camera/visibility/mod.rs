//! What the samples of an image meet: depth, identity, and motion, before light and color.

mod coverage;
mod surface_maps;
mod visibility_pass;

pub(super) use coverage::{
    CoverageMask, CoveredFace, FIRST_SAMPLES, any_of_pixels, bits_of, place_of, read_block, samples_within,
    split_by_face, where_nearer, whole_pixels,
};
pub use surface_maps::{Motions, SurfaceMapKinds};
pub(super) use visibility_pass::{ImageRays, Samples, visible_points};
pub use visibility_pass::{View, Visibility, visibility_pass};
