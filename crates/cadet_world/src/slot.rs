//! How agents are numbered in the arena.

/// An agent's place in the arena: kept by whoever replaces it when it has gone, unlike its id.
pub(super) type Slot = usize;

/// The ego's.
pub(super) const EGO: Slot = 0;
