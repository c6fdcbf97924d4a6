//! What a beam meets first: the posed triangles, the visibility kernel over grids of beams, and parry for single rays.

mod beams;
mod cluster_culling;
mod grids;
mod raster;
mod rays;
mod scene;
mod spinning;

pub(crate) use beams::{HalfTurn, MetWhileTurning, Still, cast_layers};
pub use beams::{SurfaceFilter, cast};
pub use grids::{Beam, BeamGrid, EdgePlanes, FaceHit, Hits, NO_HIT, PinholeGrid, SurfaceHits, Window};
pub use raster::{BLOCK, Block, DrawnFace, ROW_BITS, VisibilityBuffer, bits_by_column, rasterize, rasterize_instances};
pub use rays::{FaceTrees, Moment, MovingCaster, RayCaster, RayHit};
pub use scene::{Placement, PosedInstance, PosedLamp, PosedScene, Resolution, RigidMotion};
pub use spinning::{LaserRing, SpinningGrid};
