//! Kinds of ground.

/// What the ground is at a place.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum GroundKind {
    /// Carriageway, parking bays, cycle lanes.
    Road,
    /// Sidewalk and curb stones.
    Sidewalk,
    /// Everything else: grass and soil.
    Terrain,
}
