//! The ground: one continuous surface of road, pavement and terrain.

use std::sync::Arc;

use crate::math::Vec3;

/// The surface that wheels and feet touch.
#[derive(Debug, Clone)]
pub struct Ground {
    /// Corners of the surface, for the physics.
    pub vertices: Arc<Vec<Vec3>>,
    /// Triangles of the surface, counter-clockwise from above.
    pub faces: Arc<Vec<[u32; 3]>>,
}
