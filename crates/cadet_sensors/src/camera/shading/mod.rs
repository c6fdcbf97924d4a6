//! From what samples meet to radiance: fragments, binned by shader variant and shaded in batches.

mod ambient_cache;
mod deferred_shading;
mod face;
mod face_cache;
mod fragment_binning;
mod radiance_pass;
mod shading_pass;
mod shading_queue;
mod sky_rows;

#[cfg(test)]
pub(super) use face::{clump, luminaire_share};
pub(super) use radiance_pass::{radiance_pass, room_for};
#[cfg(test)]
pub(super) use shading_pass::{SurfaceCoat, environment, highlight, lamp_coat};
