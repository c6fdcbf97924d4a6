//! Kinds of ground.

/// What the ground is at a place.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum GroundKind {
    /// Carriageway, parking bays, cycle lanes.
    Road,
    /// Pavement and kerb stones.
    Pavement,
    /// Everything else: grass and soil.
    Terrain,
}
