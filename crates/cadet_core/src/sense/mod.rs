//! What a beam meets first: the posed triangles, the visibility kernel over grids of beams, and parry for single rays.

mod posed;

pub use posed::{PosedInstance, PosedScene};
