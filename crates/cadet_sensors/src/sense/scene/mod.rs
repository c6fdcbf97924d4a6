//! The posed scene: triangles at their levels of detail, lamps, and how things move meanwhile.

mod detail;
mod motion;
mod posed;

pub use detail::Resolution;
pub use motion::RigidMotion;
pub use posed::{Placement, PosedInstance, PosedLamp, PosedScene};
