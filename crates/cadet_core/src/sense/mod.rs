//! What a beam meets first: the posed triangles, the visibility kernel over grids of beams, and parry for single rays.

mod block_drawing;
mod detail;
mod edges;
mod face_trees;
mod grid;
mod hits;
mod kernel;
mod motion;
mod moving;
mod outline;
mod pinhole;
mod posed;
mod raster;
mod raycast;
mod to_grid;
mod turret;
mod turret_table;
mod visibility_buffer;
mod visible;

pub use block_drawing::bits_by_column;
pub use detail::Resolution;
pub use edges::EdgePlanes;
pub use face_trees::FaceTrees;
pub use grid::{Beam, BeamGrid, Window};
pub use hits::{Hits, NO_HIT};
pub use kernel::{Layer, cast};
pub use motion::Motion;
pub use moving::{FaceHit, LayerHits, Moment, MovingCaster};
pub use pinhole::PinholeGrid;
pub use posed::{Placement, PosedInstance, PosedScene};
pub use raster::{draw, draw_instances};
pub use raycast::{RayCaster, RayHit};
pub use turret::{TurretGrid, TurretRing};
pub use visibility_buffer::{BLOCK, Block, DrawnFace, VisibilityBuffer};
