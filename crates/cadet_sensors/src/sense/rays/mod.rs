//! Single rays, by parry, also into a world that moves.

mod face_trees;
mod moving;
mod raycast;

pub use face_trees::FaceTrees;
pub use moving::{Moment, MovingCaster};
pub use raycast::{RayCaster, RayHit};
