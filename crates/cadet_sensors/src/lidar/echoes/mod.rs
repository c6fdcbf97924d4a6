//! The echoes of a beam: which surfaces return it, how much, and what the receiver cannot tell apart.

mod blooming;
mod draws;
mod echo;
mod mixed;
mod surfaces;

pub(super) use blooming::Blooming;
pub(super) use draws::Draws;
#[cfg(test)]
pub(super) use echo::HitSurface;
pub(super) use echo::{Echo, first_echo};
pub(super) use mixed::echoes_of;
pub(super) use surfaces::SurfaceLookup;
