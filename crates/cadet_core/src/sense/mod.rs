//! What a beam meets first: the posed triangles, the visibility kernel over grids of beams, and parry for single rays.

mod edges;
mod grid;
mod kernel;
mod pinhole;
mod posed;
mod raster;
mod raycast;
mod turret;
mod turret_table;
mod visibility_buffer;

pub use edges::EdgePlanes;
pub use grid::{Beam, BeamGrid, Window};
pub use kernel::{Hits, Layer, NO_HIT, cast};
pub use pinhole::PinholeGrid;
pub use posed::{Placement, PosedInstance, PosedScene};
pub use raster::draw;
pub use raycast::{RayCaster, RayHit};
pub use turret::{TurretGrid, TurretRing};
pub use visibility_buffer::{Block, DrawnFace, Quad, VisibilityBuffer};
