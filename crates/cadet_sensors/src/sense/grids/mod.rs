//! Grids of beams, the pinhole's among them, and what their beams met.

mod edges;
mod grid;
mod hits;
mod pinhole;
mod to_grid;

pub use edges::EdgePlanes;
pub(super) use grid::tangents_of_circle;
pub use grid::{Beam, BeamGrid, Window};
pub use hits::{FaceHit, Hits, NO_HIT, SurfaceHits};
pub use pinhole::PinholeGrid;
pub(super) use to_grid::ToGrid;
